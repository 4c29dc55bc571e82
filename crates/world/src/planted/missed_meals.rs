//! Meals that were eaten and not logged: entries removed from the log.

use cohort::Record;
use physiology::STEPS_PER_DAY;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::Happenings;
use super::meals::{LEAST_MEAL, logged, strike};

/// Removes `size` meals a day, at most every other one. Their boluses stay.
pub(super) fn plant(record: &mut Record, size: f64, rng: &mut ChaCha8Rng) -> Happenings {
    let mut meals: Vec<usize> = logged(record, LEAST_MEAL).into_iter().map(|meal| meal.0).collect();
    meals.shuffle(rng);
    let days = record.len() as f64 / STEPS_PER_DAY as f64;
    let struck = ((size * days).round() as usize).min(meals.len() / 2);
    let happenings = Happenings { count: struck, places: meals.len() };
    strike(record, meals.into_iter().take(struck));
    happenings
}
