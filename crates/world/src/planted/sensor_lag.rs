//! A sensor that follows glucose more slowly: its readings filtered to first order.

use cohort::Record;

use super::sensor_column::rewrite;

/// Minutes of a step.
const STEP: f64 = 5.0;

/// Delays the readings by a first-order lag of `size` minutes, which starts again after every gap.
/// The filter runs over the whole column, including the lines that the source drew.
pub(super) fn plant(record: &mut Record, size: f64) {
    if size <= 0.0 {
        return;
    }
    let gain = 1.0 - (-STEP / size).exp();
    let mut shown: Option<f64> = None;
    let lagged: Vec<Option<f64>> = record
        .cgm()
        .iter()
        .map(|reading| {
            shown = reading.map(|now| shown.map_or(now, |before| before + gain * (now - before)));
            shown
        })
        .collect();
    rewrite(record, |k, reading| lagged[k].unwrap_or(reading));
}
