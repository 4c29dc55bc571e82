//! Boluses given later than recorded: every other bolus moved earlier in the log.
//!
//! This is a habit of logging, not an effect of a plant. A diagnosis may call it unknown, or name
//! insulin's clock.

use cohort::{Channel, Record};

use super::meals::move_earlier;

/// Least bolus that is moved, U: a controller gives micro-boluses and logs them itself.
const LEAST: f64 = 0.5;

/// Moves every other bolus by `size` minutes, rounded to steps.
pub(super) fn plant(record: &mut Record, size: f64) {
    let steps = (size / 5.0).round() as isize;
    let mut other = false;
    let moved: Vec<bool> = record
        .bolus()
        .iter()
        .map(|dose| {
            let large = dose.is_some_and(|dose| dose >= LEAST);
            other ^= large;
            large && other
        })
        .collect();
    move_earlier(record, Channel::Bolus, |k| if moved[k] { steps } else { 0 });
}
