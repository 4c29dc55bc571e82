//! Insulin is absorbed faster at some times than at others, in forms whose unit is not the day.

use physiology::STEPS_PER_HOUR;
use rand::Rng;

use crate::behaviour::Life;
use crate::stream::standard_normal;

/// Correlation time of the wandering form, h.
const HOURS: f64 = 12.0;
/// Change of the logarithm of the time over three days of wear: insulin from sites of three days
/// peaked in about two thirds of the time (Clausen et al., Diabetes Technol Ther 2009;11:575, of
/// the order).
const OVER_THREE_DAYS: f64 = -0.40;

/// Draws the logarithms by site and wandering, one per step, each with this spread.
#[must_use]
pub(super) fn sample(
    life: &Life,
    spread: f64,
    rng: &mut (impl Rng + ?Sized),
) -> (Vec<f64>, Vec<f64>) {
    let steps = life.calendar.steps();
    let mut value = spread * standard_normal(rng);
    let by_site = (0..steps)
        .map(|step| {
            if life.sets.changed_at(step) {
                value = spread * standard_normal(rng);
            }
            value
        })
        .collect();
    let keep = (-1.0 / (HOURS * STEPS_PER_HOUR as f64)).exp();
    let mut wandering = spread * standard_normal(rng);
    let course = (0..steps)
        .map(|_| {
            wandering =
                keep * wandering + spread * (1.0 - keep * keep).sqrt() * standard_normal(rng);
            wandering
        })
        .collect();
    (by_site, course)
}

/// The logarithm for a set of an age: slower at first, faster later.
#[must_use]
pub(super) fn by_age(age_days: f64) -> f64 {
    OVER_THREE_DAYS * (age_days.min(4.0) / 3.0 - 0.5)
}
