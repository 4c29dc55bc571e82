//! Plantings in the readings of a sensor.

use cohort::{Channel, Record, SensorCadence, StraightLines};
use physiology::{STEP, STEPS_PER_DAY};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;

/// Lowest and highest reading of a sensor, mg/dL.
const RANGE: (f64, f64) = (40.0, 400.0);
/// Share of values on drawn lines from which a source is assumed to have drawn them. Sensors that
/// report whole mg/dL every five minutes put a few per cent on lines by chance.
const DRAWN: f64 = 0.2;
/// Days that a sensor is worn.
const WORN: f64 = 10.0;
/// Hours of the clock within which a sleeper comes to lie on the sensor.
const NIGHT: std::ops::Range<u8> = 0..5;
/// How long that lasts, steps: 45 min.
const LASTS: usize = 9;
/// Steps in which it comes, and goes.
const EDGE: f64 = 2.0;
/// How much lower readings are then, mg/dL.
const DEPTH: std::ops::Range<f64> = 24.0..48.0;

/// Gives every reading of the sensor the value `new(step, reading)`, kept in the sensor's range.
///
/// Where the source drew lines between readings, they are drawn again between the new ones.
/// Finger-stick readings between two readings stay as they are: no sensor made them.
fn rewrite(record: &mut Record, new: impl Fn(usize, f64) -> f64) {
    let old = record.cgm().to_vec();
    let within = |k: usize, reading: f64| new(k, reading).clamp(RANGE.0, RANGE.1);
    let column = record.channel_mut(Channel::Cgm);
    if StraightLines::find(&old).share < DRAWN {
        for (k, value) in column.iter_mut().enumerate() {
            *value = value.map(|reading| within(k, reading));
        }
        return;
    }
    let strangers = SensorCadence::find(&old).map_or(Vec::new(), |cadence| cadence.strangers);
    let corners = StraightLines::corners(&old);
    for k in &corners {
        if strangers.binary_search(k).is_err() {
            column[*k] = column[*k].map(|reading| within(*k, reading));
        }
    }
    for ends in corners.windows(2) {
        let (from, to) = (ends[0], ends[1]);
        let (Some(a), Some(b)) = (column[from], column[to]) else { continue };
        for (offset, value) in column[from + 1..to].iter_mut().enumerate() {
            let part = (offset + 1) as f64 / (to - from) as f64;
            *value = value.map(|_| a + part * (b - a));
        }
    }
}

/// A sensor that follows glucose more slowly: delays the readings by a first-order lag of `size`
/// minutes, which starts again after every gap. The filter runs over the whole column, including
/// the lines that the source drew.
pub(super) fn lag(record: &mut Record, size: f64) {
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

/// Sensors that lose gain: a share `size` from the first of ten days to the last, with gain 1 in
/// the middle. The age of the first sensor at the start is drawn.
pub(super) fn drift(record: &mut Record, size: f64, rng: &mut ChaCha8Rng) {
    let phase = rng.random_range(0.0..WORN);
    rewrite(record, |k, reading| {
        let age = (k as f64 / STEPS_PER_DAY as f64 + phase) % WORN;
        reading * (1.0 + size * (0.5 - age / WORN))
    });
}

/// Nights in which a sleeper lies on the sensor: lowers the readings of a share `size` of the
/// nights for three quarters of an hour.
pub(super) fn press(record: &mut Record, size: f64, rng: &mut ChaCha8Rng) {
    let mut lowered = vec![0.0; record.len()];
    let asleep: Vec<usize> =
        (0..record.len()).filter(|k| NIGHT.contains(&record.hour(*k))).collect();
    for night in asleep.chunk_by(|step, next| step + 1 == *next) {
        let (pressed, depth) = (rng.random::<f64>() < size, rng.random_range(DEPTH));
        let begin = night[rng.random_range(0..night.len())];
        for (j, low) in lowered.iter_mut().skip(begin).take(LASTS).enumerate() {
            let edge = ((j + 1) as f64 / EDGE).min((LASTS - j) as f64 / EDGE).min(1.0);
            *low += if pressed { depth * edge } else { 0.0 };
        }
    }
    rewrite(record, |k, reading| reading - lowered[k]);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(values: impl IntoIterator<Item = Option<f64>>) -> Record {
        let values: Vec<Option<f64>> = values.into_iter().collect();
        let start = "2024-03-04T00:00:00".parse().expect("a literal time");
        let mut record = Record::new(start, values.len()).expect("on the grid");
        record.channel_mut(Channel::Cgm).copy_from_slice(&values);
        record
    }

    #[test]
    fn readings_of_five_minutes_are_changed_one_by_one() {
        let mut record = record((0..50).map(|k| Some(f64::from(100 + k * k % 17))));
        let old = record.cgm().to_vec();
        rewrite(&mut record, |k, reading| if k == 7 { reading + 3.0 } else { reading });
        for (k, (old, new)) in old.iter().zip(record.cgm()).enumerate() {
            assert_eq!(
                new.zip(*old).map(|(new, old)| new - old),
                Some(if k == 7 { 3.0 } else { 0.0 })
            );
        }
    }

    #[test]
    fn lines_are_drawn_again_and_a_finger_stick_stays() {
        let read = |k: usize| 120.0 + ((k * k * 7) % 41) as f64;
        let drawn = (0..300).map(|k| {
            let part = (k % 3) as f64 / 3.0;
            Some(read(k / 3) + part * (read(k / 3 + 1) - read(k / 3)))
        });
        let mut record = record(drawn);
        let old = record.cgm().to_vec();
        // A stick at step 100, with a line from it to the reading at 102.
        let stick = record.channel_mut(Channel::Cgm);
        stick[100] = Some(300.0);
        stick[101] = old[102].map(|after| 0.5 * (300.0 + after));
        rewrite(&mut record, |_, reading| reading + 10.0);
        let new = record.cgm();
        assert_eq!(new[100], Some(300.0));
        for k in (3..297).filter(|k| ![100, 101].contains(k)) {
            let raised = new[k].zip(old[k]).map(|(new, old)| new - old);
            assert!(raised.is_some_and(|raised| (raised - 10.0).abs() < 1e-9), "{k}: {raised:?}");
        }
        let middle = new[101].zip(new[102]).map(|(at, after)| at - 0.5 * (300.0 + after));
        assert!(middle.is_some_and(|off| off.abs() < 1e-9), "{middle:?}");
    }

    #[test]
    fn readings_stay_in_range_and_gaps_stay_gaps() {
        let mut record = record([Some(60.0), None, Some(390.0), Some(100.0)]);
        rewrite(&mut record, |_, reading| reading * 1.5 - 50.0);
        assert_eq!(record.cgm(), [Some(40.0), None, Some(400.0), Some(100.0)]);
    }

    #[test]
    fn a_steady_rise_comes_late_by_the_size() {
        let start = "2024-03-04T00:00:00".parse().expect("a literal time");
        let mut record = Record::new(start, 60).expect("on the grid");
        for (k, value) in record.channel_mut(Channel::Cgm).iter_mut().enumerate() {
            // 0.8 mg/dL a minute.
            *value = (k != 30).then_some(60.0 + 4.0 * k as f64);
        }
        lag(&mut record, 10.0);
        // exp(-14.5) of the start is left; after a gap the lag starts again.
        for (k, expected) in [(0, 60.0), (29, 176.0 - 8.0), (31, 184.0), (59, 296.0 - 8.0)] {
            let shown = record.cgm()[k].expect("a reading");
            assert!((shown - expected).abs() < 1e-4, "step {k}: {shown}, {expected}");
        }
        assert_eq!(record.cgm()[30], None);
    }
}
