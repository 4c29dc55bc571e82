//! A person's record as the filter and the free runs read it.

use cohort::{Channel, Person, StraightLines};
use effects::Modulation;
use physiology::{
    BeatsPerMinute, Context, Grams, Kilograms, MgPerDl, StepInput, Units, UnitsPerHour,
};
use serde::{Deserialize, Serialize};

use crate::error::GapError;
use crate::quality::unusable::unusable;

/// Body weight assumed where it is not recorded: the mean of the virtual population of Resalat et
/// al. 2019, 76.3 kg (SD 15.9). Calibration absorbs most of the error, since weight enters as a
/// factor on insulin and on carbohydrate.
pub const DEFAULT_WEIGHT: Kilograms = Kilograms(76.3);

/// Lowest reading of a CGM sensor; lower glucose is reported as this value.
pub const SENSOR_LOW: MgPerDl = MgPerDl(40.0);
/// Highest reading of a CGM sensor; higher glucose is reported as this value.
pub const SENSOR_HIGH: MgPerDl = MgPerDl(400.0);

/// One entry of the CGM channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reading {
    /// No reading.
    Missing,
    /// A reading inside the sensor's range.
    Within(MgPerDl),
    /// A value that the source drew between two readings: good enough to compare a free run with,
    /// no news to a filter.
    Interpolated(MgPerDl),
    /// A reading at or below [`SENSOR_LOW`]: glucose is known to be no higher.
    Low,
    /// A reading at or above [`SENSOR_HIGH`]: glucose is known to be no lower.
    High,
}

impl Reading {
    /// The value that stands in the record, `None` if missing.
    #[must_use]
    pub fn value(self) -> Option<f64> {
        match self {
            Self::Missing => None,
            Self::Within(glucose) | Self::Interpolated(glucose) => Some(glucose.0),
            Self::Low => Some(SENSOR_LOW.0),
            Self::High => Some(SENSOR_HIGH.0),
        }
    }
}

/// Share of CGM values on drawn lines above which they are taken for interpolated. Sensors that report
/// whole mg/dL every five minutes put a few per cent on lines by chance.
pub const INTERPOLATED_SHARE: f64 = 0.2;

/// Most values on one drawn line that still stand for glucose: 25 min between two readings. Longer
/// lines fill gaps and count as missing; sensors never draw eight values on one slope by chance.
pub const LONGEST_INTERPOLATION: usize = 5;

/// What a sensor would show for a glucose value: its range is [`SENSOR_LOW`] to [`SENSOR_HIGH`].
#[must_use]
pub fn within_sensor_range(glucose: f64) -> f64 {
    glucose.clamp(SENSOR_LOW.0, SENSOR_HIGH.0)
}

/// What to do about steps whose insulin or carbohydrate is not recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MissingDosePolicy {
    /// The last recorded basal rate goes on (before the first: the first); no bolus and no
    /// carbohydrate is assumed. The filter runs through, but nothing is scored while an unrecorded
    /// dose could still act.
    HoldBasal,
    /// A person with any unrecorded dose is excluded, by name and reason.
    ExcludePerson,
}

/// A person's readings and inputs, one entry a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Observations {
    /// The person.
    pub person: String,
    /// Body weight, recorded or [`DEFAULT_WEIGHT`].
    pub weight: Kilograms,
    /// CGM readings.
    pub readings: Vec<Reading>,
    /// Insulin and carbohydrate. Exercise and rescue carbohydrate stay empty: a step of the ODE would follow them, but
    /// its derivative does not.
    pub inputs: Vec<StepInput>,
    /// Whether basal, bolus and carbohydrate of the step were all recorded.
    pub doses_recorded: Vec<bool>,
    /// What effects change in each step; empty where none is assumed.
    pub modulations: Vec<Modulation>,
    /// Share of CGM values that lie strictly inside drawn lines; above [`INTERPOLATED_SHARE`] they
    /// are marked [`Reading::Interpolated`].
    pub interpolated_share: f64,
}

impl Observations {
    /// Takes a person's record apart.
    ///
    /// Steps without a dose on record are filled as [`MissingDosePolicy::HoldBasal`] says and marked
    /// in [`doses_recorded`](Self::doses_recorded). CGM values that are no readings of one sensor are
    /// left out or replaced by the line between its readings. Where basal is never recorded (injections), steps
    /// count as recorded without it.
    ///
    /// # Errors
    /// [`GapError::Value`] for a number that is not finite or a dose below zero.
    pub fn from_person(person: &Person) -> Result<Self, GapError> {
        let record = &person.record;
        for channel in [Channel::Cgm, Channel::Basal, Channel::Bolus, Channel::Carbs] {
            let wrong = |v: f64| !v.is_finite() || (v < 0.0 && channel != Channel::Cgm);
            for (step, value) in record.channel(channel).iter().enumerate() {
                if let Some(value) = value.filter(|v| wrong(*v)) {
                    let (person, channel) = (person.id.clone(), channel.name());
                    return Err(GapError::Value { person, step, channel, value });
                }
            }
        }
        let resting = person.resting_heart_rate().map(|resting| resting.0);
        let finite = |value: Option<f64>| value.filter(|value| value.is_finite());
        let mut basal = record.basal().iter().flatten().next().copied().unwrap_or(0.0);
        let injects = record.basal().iter().all(Option::is_none);
        let mut inputs = Vec::with_capacity(record.len());
        let mut doses_recorded = Vec::with_capacity(record.len());
        for step in 0..record.len() {
            let rate = record.basal()[step];
            let (bolus, carbs) = (record.bolus()[step], record.carbs()[step]);
            basal = rate.unwrap_or(basal);
            inputs.push(StepInput {
                basal: UnitsPerHour(basal),
                bolus: Units(bolus.unwrap_or(0.0)),
                carbs: Grams(carbs.unwrap_or(0.0)),
                context: Context {
                    heart_rate_over_baseline: finite(record.heart_rate()[step])
                        .zip(resting)
                        .map(|(rate, resting)| BeatsPerMinute(rate - resting)),
                    hour: record.hour(step),
                    weekend: record.weekend(step),
                    sleep_efficiency: finite(record.sleep_efficiency()[step]),
                },
                ..StepInput::default()
            });
            doses_recorded.push((rate.is_some() || injects) && bolus.is_some() && carbs.is_some());
        }
        let mut readings: Vec<Reading> = record.cgm().iter().map(|v| reading(*v)).collect();
        let lines = StraightLines::find(record.cgm());
        let drawn = lines.share > INTERPOLATED_SHARE;
        for line in &lines.inside {
            for reading in &mut readings[line.clone()] {
                if line.len() > LONGEST_INTERPOLATION {
                    *reading = Reading::Missing;
                } else if let Some(value) = reading.value().filter(|_| drawn) {
                    *reading = Reading::Interpolated(MgPerDl(value));
                }
            }
        }
        for (step, instead) in unusable(record) {
            readings[step] = instead.map_or(Reading::Missing, Reading::Interpolated);
        }
        Ok(Self {
            person: person.id.clone(),
            weight: person.weight.unwrap_or(DEFAULT_WEIGHT),
            readings,
            inputs,
            doses_recorded,
            modulations: Vec::new(),
            interpolated_share: lines.share,
        })
    }

    /// What effects change in a step.
    #[must_use]
    pub fn modulation(&self, step: usize) -> &Modulation {
        self.modulations.get(step).unwrap_or(Modulation::unchanged())
    }

    /// The error of a filter that leaves the finite numbers in a step.
    pub(crate) fn not_finite(&self, step: usize) -> GapError {
        GapError::FilterNotFinite { person: self.person.clone(), step }
    }

    /// Number of steps.
    #[must_use]
    pub fn len(&self) -> usize {
        self.readings.len()
    }

    /// Whether there is no step.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.readings.is_empty()
    }

    /// Share of the steps at which a sensor read, or had read within the 10 min before: 1 for a sensor
    /// that reads every five or every fifteen minutes without gaps.
    #[must_use]
    pub fn coverage(&self) -> f64 {
        let reads = |r: &Reading| !matches!(r, Reading::Missing | Reading::Interpolated(_));
        let covered = (0..self.len())
            .filter(|k| self.readings[k.saturating_sub(2)..=*k].iter().any(reads))
            .count();
        if self.is_empty() { 0.0 } else { covered as f64 / self.len() as f64 }
    }

    /// Whether each step lies at least `memory` steps after the last unrecorded dose.
    #[must_use]
    pub fn trusted(&self, memory: usize) -> Vec<bool> {
        let mut since = memory;
        self.doses_recorded
            .iter()
            .map(|recorded| {
                since = if *recorded { (since + 1).min(memory) } else { 0 };
                since >= memory
            })
            .collect()
    }

    /// Mean basal rate of the first `steps` steps; mean insulin rate where no basal runs.
    #[must_use]
    pub fn initial_basal(&self, steps: usize) -> UnitsPerHour {
        let first = &self.inputs[..steps.min(self.inputs.len())];
        if first.is_empty() {
            return UnitsPerHour(0.0);
        }
        let mean =
            |rate: fn(&StepInput) -> f64| first.iter().map(rate).sum::<f64>() / first.len() as f64;
        let basal = mean(|input| input.basal.0);
        UnitsPerHour(if basal > 0.0 { basal } else { mean(|input| input.insulin().0) })
    }
}

fn reading(value: Option<f64>) -> Reading {
    match value {
        None => Reading::Missing,
        Some(v) if v <= SENSOR_LOW.0 => Reading::Low,
        Some(v) if v >= SENSOR_HIGH.0 => Reading::High,
        Some(v) => Reading::Within(MgPerDl(v)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cohort::{Record, Therapy};

    fn person(steps: usize) -> Person {
        let start = "2024-03-04T00:00:00".parse().expect("a literal time");
        let mut record = Record::new(start, steps).expect("on the grid");
        record.channel_mut(Channel::Basal).fill(Some(1.0));
        record.channel_mut(Channel::Bolus).fill(Some(0.0));
        record.channel_mut(Channel::Carbs).fill(Some(0.0));
        Person {
            id: "p".into(),
            weight: None,
            therapy: Therapy::OpenLoopPump,
            heart_rate_baseline: None,
            record,
        }
    }

    #[test]
    fn readings_at_the_ends_of_the_range_are_censored() {
        let mut person = person(4);
        person.record.channel_mut(Channel::Cgm).copy_from_slice(&[
            Some(40.0),
            Some(120.0),
            Some(400.0),
            None,
        ]);
        let found = Observations::from_person(&person).expect("a good record");
        let expected =
            [Reading::Low, Reading::Within(MgPerDl(120.0)), Reading::High, Reading::Missing];
        assert_eq!(found.readings, expected);
        assert_eq!(found.weight, DEFAULT_WEIGHT);
    }

    #[test]
    fn values_drawn_between_readings_are_told_from_readings() {
        let mut person = person(300);
        let anchors: Vec<f64> =
            (0..101).map(|k| 120.0 + 40.0 * (0.4 * f64::from(k)).sin()).collect();
        for (step, value) in person.record.channel_mut(Channel::Cgm).iter_mut().enumerate() {
            let (anchor, part) = (step / 3, (step % 3) as f64 / 3.0);
            *value = Some(anchors[anchor] + part * (anchors[anchor + 1] - anchors[anchor]));
        }
        let found = Observations::from_person(&person).expect("a good record");
        assert!(found.interpolated_share > 0.5, "{}", found.interpolated_share);
        let drawn = |k: usize| matches!(found.readings[k], Reading::Interpolated(_));
        assert!(drawn(1) && drawn(2) && !drawn(3) && drawn(4) && !drawn(6));
        assert_eq!(found.readings[1].value(), person.record.cgm()[1]);
        assert_eq!(found.coverage(), 1.0);
        // A line of two hours fills a gap and is no data.
        let (from, to) = (anchors[33], anchors[41]);
        for step in 100..123 {
            let part = (step as f64 - 99.0) / 24.0;
            person.record.channel_mut(Channel::Cgm)[step] = Some(from + part * (to - from));
        }
        let found = Observations::from_person(&person).expect("a good record");
        assert!((100..123).all(|k| found.readings[k] == Reading::Missing));
        assert!((found.coverage() - (1.0 - 21.0 / 300.0)).abs() < 1e-12, "{}", found.coverage());
    }

    #[test]
    fn basal_is_held_through_a_gap_and_the_gap_is_marked() {
        let mut person = person(6);
        person.record.channel_mut(Channel::Basal)[2] = Some(2.0);
        person.record.channel_mut(Channel::Basal)[3] = None;
        person.record.channel_mut(Channel::Bolus)[3] = None;
        let found = Observations::from_person(&person).expect("a good record");
        assert_eq!(found.inputs[3].basal, UnitsPerHour(2.0));
        assert_eq!(found.inputs[3].bolus, Units(0.0));
        assert_eq!(found.doses_recorded, [true, true, true, false, true, true]);
        assert_eq!(found.trusted(2), [true, true, true, false, false, true]);
    }

    #[test]
    fn a_dose_that_cannot_be_is_an_error_with_its_place() {
        for wrong in [f64::NAN, -1.0, f64::INFINITY] {
            let mut person = person(3);
            person.record.channel_mut(Channel::Bolus)[1] = Some(wrong);
            let error = Observations::from_person(&person).expect_err("a wrong dose");
            assert!(
                matches!(error, GapError::Value { step: 1, channel: "bolus_u", .. }),
                "{error}"
            );
        }
    }
}
