//! How the same person differs from day to day and from hour to hour.

use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};
use rand::Rng;

use crate::calendar::Calendar;
use crate::stream::standard_normal;

/// Hour of the day around which one day's values change to the next's.
const CHANGE_HOUR: f64 = 3.0;

/// Spreads of one person's days, each that of a logarithm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spreads {
    /// Of insulin action between days.
    pub action_between_days: f64,
    /// Correlation of insulin action from one day to the next.
    pub memory: f64,
    /// Of insulin action within days, and its correlation time, h.
    pub action_within_days: (f64, f64),
    /// Of the time of insulin absorption between days, at amplitude 1 of the effect.
    pub insulin_time_between_days: f64,
    /// Of the time of meal absorption between days.
    pub gut_time_between_days: f64,
    /// Of the time of insulin absorption between days, whether the effect acts or not.
    pub insulin_time_always: f64,
}

impl Spreads {
    /// Those of the embedded cohort's people.
    ///
    /// Insulin action: the insulin that closed loops gave varied by 20 to 30 % between days (Ruan
    /// et al., Diabetes Care 2016;39:830), most of it because of food and behaviour. Time of
    /// insulin absorption: coefficients of variation of 10 to 25 % within a person (Heinemann,
    /// Diabetes Technol Ther 2002;4:673). The spread of insulin action within days and that of the
    /// time of meal absorption are assumed.
    pub const NARROW: Self = Self {
        action_between_days: 0.12,
        memory: 0.0,
        action_within_days: (0.10, 5.0),
        insulin_time_between_days: 0.15,
        gut_time_between_days: 0.12,
        insulin_time_always: 0.0,
    };
}

/// Logarithms of the factors of one person's days, per step.
#[derive(Debug, Clone, PartialEq)]
pub struct Variability {
    /// Insulin action, all three targets.
    pub action: Vec<f64>,
    /// Time of insulin absorption at amplitude 1.
    pub insulin_time: Vec<f64>,
    /// Time of meal absorption.
    pub gut_time: Vec<f64>,
    /// Time of insulin absorption whether the effect acts or not.
    pub insulin_time_always: Vec<f64>,
}

impl Variability {
    /// Draws the days of a calendar.
    #[must_use]
    pub fn sample(calendar: &Calendar, spreads: &Spreads, rng: &mut (impl Rng + ?Sized)) -> Self {
        let mut action = by_day(calendar, spreads.action_between_days, spreads.memory, rng);
        let insulin_time = by_day(calendar, spreads.insulin_time_between_days, 0.0, rng);
        let gut_time = by_day(calendar, spreads.gut_time_between_days, 0.0, rng);
        let (spread, hours) = spreads.action_within_days;
        let keep = (-1.0 / (hours * STEPS_PER_HOUR as f64)).exp();
        let innovation = spread * (1.0 - keep * keep).sqrt();
        let mut drift = spread * standard_normal(rng);
        for value in &mut action {
            *value += drift;
            drift = keep * drift + innovation * standard_normal(rng);
        }
        // Draws from a separate part of the stream, after all others.
        let insulin_time_always = if spreads.insulin_time_always > 0.0 {
            by_day(calendar, spreads.insulin_time_always, 0.0, rng)
        } else {
            Vec::new()
        };
        Self { action, insulin_time, gut_time, insulin_time_always }
    }
}

/// One normal value a day, correlated with that of the day before, changing from day to day within
/// the two hours about [`CHANGE_HOUR`].
fn by_day(
    calendar: &Calendar,
    spread: f64,
    memory: f64,
    rng: &mut (impl Rng + ?Sized),
) -> Vec<f64> {
    let fresh = (1.0 - memory * memory).sqrt();
    let mut last: Option<f64> = None;
    let days: Vec<f64> = (0..=calendar.days())
        .map(|_| {
            let drawn = standard_normal(rng);
            let unit = last.map_or(drawn, |before| memory * before + fresh * drawn);
            last = Some(unit);
            spread * unit
        })
        .collect();
    (0..calendar.steps())
        .map(|step| {
            let day = step / STEPS_PER_DAY;
            let share = ((calendar.hour(step) - CHANGE_HOUR + 1.0) / 2.0).clamp(0.0, 1.0);
            days[day] + share * (days[day + 1] - days[day])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::{Concept, stream};
    use chrono::NaiveDate;

    #[test]
    fn the_spread_is_the_stated_one() {
        let start = NaiveDate::from_ymd_opt(2024, 1, 8).expect("a date");
        let days = Variability::sample(
            &Calendar::new(start, 400),
            &Spreads::NARROW,
            &mut stream(1, 0, Concept::Variability),
        );
        let noon: Vec<f64> =
            days.insulin_time.iter().skip(144).step_by(STEPS_PER_DAY).copied().collect();
        let sd = (noon.iter().map(|v| v * v).sum::<f64>() / noon.len() as f64).sqrt();
        // 400 independent values: a standard error of 3.5 % of the spread, four of them.
        let stated = Spreads::NARROW.insulin_time_between_days;
        assert!((sd / stated - 1.0).abs() < 0.14, "{sd}");
    }
}
