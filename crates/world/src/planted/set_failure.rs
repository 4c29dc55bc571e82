//! Infusion sets that fail: for eight hours 40 % of the recorded insulin arrives.

use cohort::Record;
use physiology::STEPS_PER_DAY;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

use super::Happenings;
use super::arriving_insulin::raise;

/// Share that arrives through a failed set.
const ARRIVES: f64 = 0.4;
/// How long nobody notices, steps: 8 h.
const LASTS: usize = 96;

/// Each day, a failure begins with probability `size`, at any time.
pub(super) fn plant(record: &mut Record, size: f64, rng: &mut ChaCha8Rng) -> Happenings {
    let mut count = 0;
    let mut share = vec![1.0; record.len()];
    for day in 0..record.len() / STEPS_PER_DAY {
        let (fails, step) = (rng.random::<f64>() < size, rng.random_range(0..STEPS_PER_DAY));
        let from = day * STEPS_PER_DAY + step;
        let until = (from + LASTS).min(record.len());
        if fails {
            share[from..until].fill(ARRIVES);
            count += 1;
        }
    }
    raise(record, &share);
    Happenings { count, places: record.len() / LASTS }
}
