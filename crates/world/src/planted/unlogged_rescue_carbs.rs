//! Carbohydrate eaten at a low and not logged: such entries struck from the log.
//!
//! Only what a person did log can be struck. A cohort that logs no rescue cannot carry this planting.

use cohort::Record;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

use super::meals::{logged, strike};

/// Most carbohydrate of a rescue, g: the rule of 15 g, doubled.
const MOST_RESCUE: f64 = 30.0;
/// Glucose below which an entry is taken for a rescue, mg/dL: the alert of a low and a little.
const LOW: f64 = 80.0;
/// Steps before the entry within which the sensor showed it: 20 min.
const BEFORE: usize = 4;

/// Strikes a share `size` of the rescues that are logged.
pub(super) fn plant(record: &mut Record, size: f64, rng: &mut ChaCha8Rng) {
    let low = |step: usize| {
        let shown = &record.cgm()[step.saturating_sub(BEFORE)..=step];
        shown.iter().flatten().any(|glucose| *glucose < LOW)
    };
    let rescues: Vec<usize> = logged(record, 0.0)
        .into_iter()
        .filter(|(step, grams)| *grams <= MOST_RESCUE && low(*step))
        .map(|(step, _)| step)
        .collect();
    // One draw a rescue, so that a larger share holds the smaller one.
    let struck: Vec<usize> = rescues.into_iter().filter(|_| rng.random::<f64>() < size).collect();
    strike(record, struck);
}
