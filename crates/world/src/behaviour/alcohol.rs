//! Evenings with alcohol.

use rand::{Rng, RngExt};

use super::habits::Habits;
use super::hours::Hours;
use crate::calendar::Calendar;

/// Alcohol taken in one evening.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drinking {
    /// Step of the middle of the drinking.
    pub step: usize,
    /// Amount, in the dose of the clinical study: 1 is 0.75 g per kg of body weight.
    pub dose: f64,
}

/// Draws the evenings with alcohol. They are more frequent on Friday and Saturday by the factor in
/// the hours (three in regular ones). They are at 20:00 to 22:00, with 0.5 to 1.3 times the 0.75
/// g/kg of Turner et al. (Diabetes Care 2001;24:1888). The weekly pattern is assumed.
#[must_use]
pub(super) fn evenings(
    habits: &Habits,
    hours: &Hours,
    calendar: &Calendar,
    rng: &mut (impl Rng + ?Sized),
) -> Vec<Drinking> {
    let ordinary = habits.alcohol_evenings_per_week / (5.0 + 2.0 * hours.weekend_drinking);
    (0..calendar.days())
        .filter_map(|day| {
            let (chance, hour) = (rng.random::<f64>(), rng.random_range(20.0..22.0));
            let dose = rng.random_range(0.5..1.3);
            let weight =
                if matches!(calendar.weekday(day), 4 | 5) { hours.weekend_drinking } else { 1.0 };
            let step = calendar.step_at(day, hour)?;
            (chance < weight * ordinary).then_some(Drinking { step, dose })
        })
        .collect()
}
