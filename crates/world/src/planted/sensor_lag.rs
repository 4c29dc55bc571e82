//! A sensor that follows glucose more slowly: its readings filtered to first order.

use cohort::Record;
use physiology::STEP;

use super::sensor_column::rewrite;

/// Delays the readings by a first-order lag of `size` minutes, which starts again after every gap.
/// The filter runs over the whole column, including the lines that the source drew.
pub(super) fn plant(record: &mut Record, size: f64) {
    if size <= 0.0 {
        return;
    }
    // Readings are joined by straight lines, so that a steady rise comes late by `size` minutes.
    let (kept, along) = ((-STEP.0 / size).exp(), size / STEP.0);
    let mut last: Option<(f64, f64)> = None;
    let lagged: Vec<Option<f64>> = record
        .cgm()
        .iter()
        .map(|reading| {
            last = reading.map(|now| {
                let (before, shown) = last.unwrap_or((now, now));
                let behind = (now - before) * along;
                (now, now - behind + kept * (shown - before + behind))
            });
            last.map(|(_, shown)| shown)
        })
        .collect();
    rewrite(record, |k, reading| lagged[k].unwrap_or(reading));
}

#[cfg(test)]
mod tests {
    use cohort::{Channel, Record};

    use super::*;

    #[test]
    fn a_steady_rise_comes_late_by_the_size() {
        let start = "2024-03-04T00:00:00".parse().expect("a literal time");
        let mut record = Record::new(start, 60).expect("on the grid");
        for (k, value) in record.channel_mut(Channel::Cgm).iter_mut().enumerate() {
            // 0.8 mg/dL a minute.
            *value = (k != 30).then_some(60.0 + 4.0 * k as f64);
        }
        plant(&mut record, 10.0);
        // exp(-14.5) of the start is left; after a gap the lag starts again.
        for (k, expected) in [(0, 60.0), (29, 176.0 - 8.0), (31, 184.0), (59, 296.0 - 8.0)] {
            let shown = record.cgm()[k].expect("a reading");
            assert!((shown - expected).abs() < 1e-4, "step {k}: {shown}, {expected}");
        }
        assert_eq!(record.cgm()[30], None);
    }
}
