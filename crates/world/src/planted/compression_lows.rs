//! Nights in which a sleeper lies on the sensor: readings lowered for three quarters of an hour.

use cohort::Record;
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

use super::sensor_column::rewrite;

/// Hours of the clock within which one begins.
const NIGHT: std::ops::Range<u8> = 0..5;
/// How long it lasts, steps: 45 min.
const LASTS: usize = 9;
/// Steps in which it comes, and goes.
const EDGE: f64 = 2.0;
/// Depth, mg/dL.
const DEPTH: std::ops::Range<f64> = 24.0..48.0;

/// Lowers the readings of a share `size` of the nights.
pub(super) fn plant(record: &mut Record, size: f64, rng: &mut ChaCha8Rng) {
    let mut lowered = vec![0.0; record.len()];
    let mut night = Vec::new();
    for k in 0..=record.len() {
        if k < record.len() && NIGHT.contains(&record.hour(k)) {
            night.push(k);
            continue;
        }
        if night.is_empty() {
            continue;
        }
        let (pressed, depth) = (rng.random::<f64>() < size, rng.random_range(DEPTH));
        let begin = night[rng.random_range(0..night.len())];
        for (j, low) in lowered.iter_mut().skip(begin).take(LASTS).enumerate() {
            let edge = ((j + 1) as f64 / EDGE).min((LASTS - j) as f64 / EDGE).min(1.0);
            *low += if pressed { depth * edge } else { 0.0 };
        }
        night.clear();
    }
    rewrite(record, |k, reading| reading - lowered[k]);
}
