//! A person's record as the filter and the free runs read it.

use cohort::{Channel, Person};
use physiology::{Context, Grams, Kilograms, MgPerDl, StepInput, Units, UnitsPerHour};
use serde::{Deserialize, Serialize};

use crate::error::GapError;

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
            Self::Within(glucose) => Some(glucose.0),
            Self::Low => Some(SENSOR_LOW.0),
            Self::High => Some(SENSOR_HIGH.0),
        }
    }
}

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
    /// Insulin and carbohydrate; exercise and rescue carbohydrate are left to later stages.
    pub inputs: Vec<StepInput>,
    /// Whether basal, bolus and carbohydrate of the step were all recorded.
    pub doses_recorded: Vec<bool>,
}

impl Observations {
    /// Takes a person's record apart.
    ///
    /// Steps without a dose on record are filled as [`MissingDosePolicy::HoldBasal`] says and marked
    /// in [`doses_recorded`](Self::doses_recorded). A channel that is never recorded counts as
    /// recorded where `assumed_absent` names it (a person who logs no basal because she injects).
    ///
    /// # Errors
    /// [`GapError::Value`] for a number that is not finite or a dose below zero.
    pub fn from_person(person: &Person) -> Result<Self, GapError> {
        let record = &person.record;
        for channel in [Channel::Cgm, Channel::Basal, Channel::Bolus, Channel::Carbs] {
            let negative_allowed = channel == Channel::Cgm;
            let wrong = record.channel(channel).iter().enumerate().find_map(|(step, value)| {
                value
                    .filter(|v| !v.is_finite() || (*v < 0.0 && !negative_allowed))
                    .map(|v| (step, v))
            });
            if let Some((step, value)) = wrong {
                return Err(GapError::Value {
                    person: person.id.clone(),
                    step,
                    channel: channel.column(),
                    value,
                });
            }
        }
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
                    hour: record.hour(step),
                    weekend: record.weekend(step),
                    ..Context::default()
                },
                ..StepInput::default()
            });
            doses_recorded.push((rate.is_some() || injects) && bolus.is_some() && carbs.is_some());
        }
        Ok(Self {
            person: person.id.clone(),
            weight: person.weight.unwrap_or(DEFAULT_WEIGHT),
            readings: record.cgm().iter().map(|value| reading(*value)).collect(),
            inputs,
            doses_recorded,
        })
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
