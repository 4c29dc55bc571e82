//! Sensors that lose gain: a share `size` from the first of ten days to the last, with gain 1 in
//! the middle.

use cohort::Record;
use physiology::STEPS_PER_DAY;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

use super::sensor_column::rewrite;

/// Days that a sensor is worn.
const WORN: f64 = 10.0;

/// Scales the readings; the age of the first sensor at the start is drawn.
pub(super) fn plant(record: &mut Record, size: f64, rng: &mut ChaCha8Rng) {
    let phase = rng.random_range(0.0..WORN);
    rewrite(record, |k, reading| {
        let age = (k as f64 / STEPS_PER_DAY as f64 + phase) % WORN;
        reading * (1.0 + size * (0.5 - age / WORN))
    });
}
