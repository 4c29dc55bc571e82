//! Compression lows: lying on the sensor makes it read low.

use super::prelude::*;

/// Depth of an event of size 1, mg/dL.
const DEPTH: f64 = -24.0;
/// Lengths that are tried, min: 45 (30 to 70).
const MINUTES: [f64; 5] = [45.0, 30.0, 60.0, 75.0, 105.0];
/// How fast the reading falls and returns, as shares of the depth in the first and last steps of five minutes: within
/// five, ten and twenty minutes.
const EDGES: [&[f64]; 3] = [&[], &[0.6], &[0.25, 0.55, 0.85]];
/// Relative sizes and their weights: 12, 24 and 48 mg/dL.
const SIZES: [(f64, f64); 3] = [(0.5, 0.3), (1.0, 0.45), (2.0, 0.25)];
/// Events a day: 3 % of the readings of a night of 8.5 h, 45 min each.
const PER_DAY: f64 = 0.34;
/// Share of a step asleep from which the person lies.
const ASLEEP: f64 = 0.5;
/// No low starts so shortly before carbohydrate is logged, min: a breakfast that is eaten before it is logged raises
/// glucose as the end of a low does (decision 0043).
const BEFORE_A_LOG: f64 = 120.0;
/// Hours of the night where sleep is unknown.
const NIGHT: (f64, f64) = (23.0, 7.0);

/// See the module.
#[derive(Debug, Clone, Copy)]
pub(super) struct CompressionLows;

impl Effect for CompressionLows {
    fn card(&self) -> Card {
        Card {
            id: EffectId::COMPRESSION_LOWS,
            port: Port::Sensor,
            summary: "the sensor reads low for a while when the sleeper lies on it",
            size_at_one: "24 mg/dL low (12 to 48) for 45 min, one night in three",
            source: "3 % of the readings of 1,125 nights: Baysal et al., J Diabetes Sci Technol 2014;8:1091; in volunteers: \
                     Mensh et al., J Diabetes Sci Technol 2013;7:863",
            signature: "sharp falls in sleep that end as sharply, without insulin or a rescue",
            channels: &[Channel::Sleep, Channel::Clock],
            confusable_with: &[EffectId::UNLOGGED_RESCUE_CARBS, EffectId::COUNTER_REGULATION],
            relations: Relations::USUAL,
            prior: Prior { median: 1.0, log_sd: 0.3, largest: 2.5 },
        }
    }

    fn form(&self, course: &Course) -> Option<Form> {
        let lying = |k: usize, hour: f64| {
            let share = value_at(course.asleep.as_ref(), k);
            share.map_or(hour >= NIGHT.0 || hour < NIGHT.1, |share| share >= ASLEEP)
        };
        let eaten = meals::near(course, BEFORE_A_LOG, 0.0);
        let steps = course.hour.iter().enumerate();
        let onsets = steps.filter(|(k, hour)| lying(*k, **hour) && !eaten[*k]).map(|(k, _)| k);
        EventShape {
            field: Field::SensorOffset,
            profiles: courses(),
            onsets: onsets.collect(),
            per_day: PER_DAY,
            sizes: SIZES.to_vec(),
        }
        .if_it_starts()
    }

    fn modulate(&self, _: usize, _: f64, _: &Course, _: &mut [Modulation]) {}
}

/// The courses that are tried, mg/dL in steps of five minutes.
fn courses() -> Vec<Vec<f64>> {
    let of = |minutes: f64, edge: &[f64]| -> Vec<f64> {
        let n = meals::steps(minutes);
        let share = |k: usize| edge.get(k).copied().unwrap_or(1.0);
        (0..n).map(|k| DEPTH * share(k).min(share(n - 1 - k))).collect()
    };
    MINUTES.iter().flat_map(|m| EDGES.iter().map(|edge| of(*m, edge))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{DAY, SHORT_NIGHT_BEFORE, fortnight};

    #[test]
    fn the_sensor_reads_low_in_sleep_only() {
        let mut course = fortnight();
        let onsets = |course: &Course| match CompressionLows.form(course) {
            Some(Form::Events(events)) => {
                assert!(events.profiles.iter().flatten().all(|offset| *offset < 0.0));
                events.onsets
            }
            other => panic!("nights are there: {other:?}"),
        };
        let awake_at_5h = SHORT_NIGHT_BEFORE * DAY + 60;
        let asleep = onsets(&course);
        assert!(asleep.contains(&(DAY + 24)) && !asleep.contains(&awake_at_5h));
        assert!(asleep.iter().all(|k| course.hour[*k] < 7.0 || course.hour[*k] >= 23.0));
        course.asleep = None;
        assert!(onsets(&course).contains(&awake_at_5h), "by the clock where sleep is unknown");
    }

    #[test]
    fn a_breakfast_that_is_logged_late_ends_no_low() {
        let course = fortnight();
        let Some(Form::Events(events)) = CompressionLows.form(&course) else {
            panic!("nights are there");
        };
        let breakfast = course.carbs.iter().position(|grams| *grams > 0.0).expect("a meal");
        assert!(events.onsets.contains(&(breakfast - 25)));
        assert!(!events.onsets.contains(&(breakfast - 24)));
    }
}
