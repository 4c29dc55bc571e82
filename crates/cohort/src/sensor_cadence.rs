//! The interval of a sensor's readings, and which values of its column are its own.
//!
//! A sensor that reads every 15 min fills one step of three; sources draw straight lines over the
//! other two or leave them empty. Its readings keep their phase until the sensor is changed. A
//! value between two readings that is not on the line is no reading of that sensor: someone added
//! it.

use crate::straight_lines::StraightLines;

/// Share of the distances between neighbouring readings that must equal the cadence.
const REGULAR: f64 = 0.5;
/// Readings on either side that give the phase: 8 h of a sensor that reads every 15 min.
const AROUND: usize = 32;
/// Share of these that must have the phase.
const IN_PHASE: f64 = 0.75;
/// Longest interval that is tried, steps: 30 min.
const LONGEST: usize = 6;

/// A sensor's interval and its readings.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SensorCadence {
    /// Steps from one reading to the next: 1 for a sensor of 5 min, 3 for one of 15 min.
    pub steps: usize,
    /// Steps of the sensor's readings, ascending. Readings that happen to lie on the line between
    /// their neighbours cannot be separated from drawn values and do not count.
    pub readings: Vec<usize>,
    /// Steps of the values between two readings of the sensor that are off its phase and off the
    /// line; ascending. Always empty for a sensor that reads at every step.
    pub strangers: Vec<usize>,
}

impl SensorCadence {
    /// Finds the interval of a column of one value per step; `None` where readings have no regular
    /// one.
    #[must_use]
    pub fn find(values: &[Option<f64>]) -> Option<Self> {
        let corners = StraightLines::corners(values);
        let distances = || corners.windows(2).map(|pair| pair[1] - pair[0]);
        let count = |steps: usize| distances().filter(|distance| *distance == steps).count();
        let steps = (1..=LONGEST).max_by_key(|steps| (count(*steps), LONGEST - steps))?;
        let regular = count(steps) as f64 >= REGULAR * distances().len() as f64;
        if !regular || count(steps) == 0 {
            return None;
        }
        if steps == 1 {
            return Some(Self { steps, readings: corners, strangers: Vec::new() });
        }
        let (mut readings, mut strangers) = (Vec::new(), Vec::new());
        for (index, &corner) in corners.iter().enumerate() {
            let around =
                &corners[index.saturating_sub(AROUND)..(index + AROUND + 1).min(corners.len())];
            let of_phase = |phase| around.iter().filter(|k| *k % steps == phase).count();
            let Some(phase) = (0..steps).max_by_key(|phase| of_phase(*phase)) else { continue };
            if corner % steps == phase {
                readings.push(corner);
                continue;
            }
            let before = corner.checked_sub((corner + steps - phase) % steps);
            let between = before.is_some_and(|before| {
                values[before].is_some() && values.get(before + steps).is_some_and(Option::is_some)
            });
            // The end of a line that fills a gap is not foreign: the sensor reads next to one.
            let beside = |other: Option<&usize>| {
                other.is_some_and(|other| other.abs_diff(corner) <= 2 * steps)
            };
            let among_readings =
                beside(index.checked_sub(1).and_then(|before| corners.get(before)))
                    && beside(corners.get(index + 1));
            if between && among_readings && of_phase(phase) as f64 >= IN_PHASE * around.len() as f64
            {
                strangers.push(corner);
            } else {
                readings.push(corner);
            }
        }
        Some(Self { steps, readings, strangers })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A course read every third step from step 1 on, with lines between.
    fn every_quarter_of_an_hour(readings: usize) -> Vec<Option<f64>> {
        let read = |k: usize| 120.0 + ((k * k * 7) % 41) as f64;
        let drawn = (0..3 * readings).map(|k| {
            let (index, part) = (k / 3, (k % 3) as f64 / 3.0);
            Some(read(index) + part * (read(index + 1) - read(index)))
        });
        std::iter::once(None).chain(drawn).collect()
    }

    /// Puts `value` at a step and draws the rest of the line again, as sources do.
    fn put(values: &mut [Option<f64>], step: usize, value: f64) {
        let (before, after) = ((step - 1) / 3 * 3 + 1, (step - 1) / 3 * 3 + 4);
        for (from, to) in [(before, step), (step, after)] {
            let (a, b) = (values[from].expect("recorded"), values[to].expect("recorded"));
            let (a, b) = if to == step { (a, value) } else { (value, b) };
            for (offset, drawn) in values[from + 1..to].iter_mut().enumerate() {
                *drawn = Some(a + (b - a) * (offset + 1) as f64 / (to - from) as f64);
            }
        }
        values[step] = Some(value);
    }

    #[test]
    fn a_sensor_of_a_quarter_of_an_hour_keeps_its_phase() {
        let values = every_quarter_of_an_hour(200);
        let found = SensorCadence::find(&values).expect("regular");
        assert_eq!((found.steps, found.strangers.as_slice()), (3, [].as_slice()));
        // The last value has no neighbour after it, so no line shows whether it was drawn.
        let (_, inner) = found.readings.split_last().expect("many");
        assert!(inner.len() > 180 && inner.iter().all(|k| k % 3 == 1), "{inner:?}");
    }

    #[test]
    fn values_between_its_readings_are_strangers() {
        let mut values = every_quarter_of_an_hour(200);
        for step in [152, 300, 303, 480] {
            put(&mut values, step, 250.0);
        }
        let found = SensorCadence::find(&values).expect("regular");
        assert_eq!(found.strangers, [152, 300, 303, 480]);
    }

    #[test]
    fn the_ends_of_a_filled_gap_are_no_strangers() {
        let mut values = every_quarter_of_an_hour(200);
        // From the reading at 298 to a value off the phase, after which the sensor reads again.
        let from = values[298].expect("recorded");
        for (step, value) in values.iter_mut().enumerate().take(322).skip(299) {
            *value = Some(from + (250.0 - from) * (step as f64 - 298.0) / 23.0);
        }
        let found = SensorCadence::find(&values).expect("regular");
        assert!(found.strangers.is_empty(), "{:?}", found.strangers);
    }

    #[test]
    fn a_new_sensor_may_have_another_phase() {
        let mut values = every_quarter_of_an_hour(200);
        values.extend([None, None]);
        values.extend(every_quarter_of_an_hour(200));
        let found = SensorCadence::find(&values).expect("regular");
        assert_eq!((found.steps, found.strangers.as_slice()), (3, [].as_slice()));
    }

    #[test]
    fn readings_at_every_step_and_none_at_all() {
        let values: Vec<_> = (0..300).map(|k| Some(f64::from((k * k * 7) % 41))).collect();
        let found = SensorCadence::find(&values).expect("regular");
        assert_eq!((found.steps, found.strangers.len()), (1, 0));
        assert_eq!(SensorCadence::find(&[]), None);
        assert_eq!(SensorCadence::find(&[None, Some(1.0), None]), None);
        // Readings without lines, one step of three.
        let sparse: Vec<_> =
            (0..300).map(|k| (k % 3 == 0).then(|| f64::from((k * k * 7) % 41))).collect();
        assert_eq!(SensorCadence::find(&sparse).map(|found| found.steps), Some(3));
    }
}
