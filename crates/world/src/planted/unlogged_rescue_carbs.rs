//! Carbohydrate eaten at a low and not logged: such entries removed from the log.
//!
//! Only what a person logged can be removed. A cohort that logs no rescue cannot have this
//! planting.

use cohort::Record;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

use super::Happenings;
use super::meals::{logged, strike};

/// Most carbohydrate of a rescue, g: the rule of 15 g, doubled.
const MOST_RESCUE: f64 = 30.0;
/// Glucose below which an entry counts as a rescue, mg/dL: a little above the alert of a low.
const LOW: f64 = 80.0;
/// Steps before the entry within which the sensor must show it: 20 min.
const BEFORE: usize = 4;

/// Removes a share `size` of the logged rescues.
pub(super) fn plant(record: &mut Record, size: f64, rng: &mut ChaCha8Rng) -> Happenings {
    let low = |step: usize| {
        let shown = &record.cgm()[step.saturating_sub(BEFORE)..=step];
        shown.iter().flatten().any(|glucose| *glucose < LOW)
    };
    let rescues: Vec<usize> = logged(record, 0.0)
        .into_iter()
        .filter(|(step, grams)| *grams <= MOST_RESCUE && low(*step))
        .map(|(step, _)| step)
        .collect();
    let places = rescues.len();
    // One draw per rescue, so that a larger share contains the smaller one.
    let struck: Vec<usize> = rescues.into_iter().filter(|_| rng.random::<f64>() < size).collect();
    let happenings = Happenings { count: struck.len(), places };
    strike(record, struck);
    happenings
}
