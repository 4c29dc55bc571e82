//! Dinners that reach the blood later than logged: the log moved earlier.
//!
//! The body's response to a dinner then begins `size` minutes later than the log says. A slow meal
//! of the literature rises later *and* more slowly: here the time at which half has arrived is
//! right, but the shape is that of the person's usual meal.

use cohort::{Channel, Record};

use super::meals::{LEAST_MEAL, move_earlier};

/// Hours of dinner, of the clock.
const DINNER: std::ops::Range<u8> = 18..23;

/// Moves the carbohydrate of dinners by `size` minutes, rounded to steps. Boluses stay.
pub(super) fn plant(record: &mut Record, size: f64) {
    let steps = (size / 5.0).round() as isize;
    let dinner: Vec<bool> = (0..record.len())
        .map(|k| {
            DINNER.contains(&record.hour(k))
                && record.carbs()[k].is_some_and(|grams| grams >= LEAST_MEAL)
        })
        .collect();
    move_earlier(record, Channel::Carbs, |k| if dinner[k] { steps } else { 0 });
}
