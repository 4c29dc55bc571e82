//! A person's record as the effects see it.

use cohort::{Channel, Person};
use effects::Course;
use physiology::{STEP, STEPS_PER_DAY};

use crate::background::hours;

/// Gaps in the readings that are taken for the warm-up of a new sensor, steps: 100 to 150 min.
const WARM_UP: std::ops::RangeInclusive<usize> = 20..=30;

/// The time courses from which drivers are made. `glucose` is the filtered plasma glucose, mg/dL.
#[must_use]
pub fn course(person: &Person, glucose: Vec<f64>) -> Course {
    let record = &person.record;
    let known = |channel: Channel| {
        let values = record.channel(channel);
        values.iter().any(Option::is_some).then(|| values.to_vec())
    };
    let amounts = |channel: Channel| -> Vec<f64> {
        record.channel(channel).iter().map(|v| v.unwrap_or(0.0)).collect()
    };
    let over_rest = known(Channel::HeartRate)
        .zip(person.resting_heart_rate())
        .map(|(rates, rest)| rates.into_iter().map(|r| r.map(|r| r - rest.0)).collect());
    Course {
        hour: hours(record),
        day: (0..record.len()).map(|k| record.day_index(k)).collect(),
        weekend: (0..record.len()).map(|k| record.weekend(k)).collect(),
        carbs: amounts(Channel::Carbs),
        bolus: amounts(Channel::Bolus),
        heart_rate_over_rest: over_rest,
        walked: known(Channel::Steps),
        asleep: known(Channel::SleepEfficiency),
        set_changed: known(Channel::SetChange)
            .map(|values| values.into_iter().map(|v| v.is_some_and(|v| v >= 0.5)).collect()),
        glucose,
        sensor_age: sensor_age(record.cgm()),
    }
}

/// Days since the last gap that looks like a warm-up; before the first, counted back from it as if
/// sensors were worn for ten days. `None` without such a gap.
fn sensor_age(cgm: &[Option<f64>]) -> Option<Vec<f64>> {
    let known: Vec<usize> = (0..cgm.len()).filter(|step| cgm[*step].is_some()).collect();
    let gaps = known.windows(2).filter(|ends| WARM_UP.contains(&(ends[1] - ends[0] - 1)));
    let starts: Vec<usize> = gaps.map(|ends| ends[0] + 1).collect();
    let first = *starts.first()?;
    let before = 10 * STEPS_PER_DAY;
    let counted_back = first as f64 - (first.div_ceil(before) * before) as f64;
    let days = 1.0 / (1440.0 / STEP.0);
    let age = |step: usize| {
        let begun = starts.partition_point(|start| *start <= step);
        let start = begun.checked_sub(1).map_or(counted_back, |last| starts[last] as f64);
        (step as f64 - start) * days
    };
    Some((0..cgm.len()).map(age).collect())
}
