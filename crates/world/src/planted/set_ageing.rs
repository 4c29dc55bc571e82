//! Infusion sets that age: after its first day a set loses a share `size` of the insulin per day.

use cohort::Record;
use physiology::STEPS_PER_DAY;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

use super::arriving_insulin::raise;

/// Days of a set where its change is not recorded.
const WORN: f64 = 3.0;
/// Days without a loss.
const GOOD: f64 = 1.0;
/// Least share that arrives, however long a set is worn.
const LEAST: f64 = 0.3;

/// Ages the sets that were changed as recorded, or every three days from a drawn phase.
pub(super) fn plant(record: &mut Record, size: f64, rng: &mut ChaCha8Rng) {
    let phase = rng.random_range(0.0..WORN);
    let changes = record.set_change().iter().filter(|change| **change == Some(1.0)).count();
    let mut since: Option<usize> = None;
    let share: Vec<f64> = (0..record.len())
        .map(|k| {
            if record.set_change()[k] == Some(1.0) {
                since = Some(k);
            }
            let days = |steps: usize| steps as f64 / STEPS_PER_DAY as f64;
            let age = match (since, changes) {
                (Some(from), _) => days(k - from),
                // Before the first recorded change, and where none is ever recorded.
                (None, _) => (days(k) + phase) % WORN,
            };
            (1.0 - size * (age - GOOD).max(0.0)).max(LEAST)
        })
        .collect();
    raise(record, &share);
}
