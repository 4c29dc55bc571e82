//! A person's record as the inputs of a plant.

use std::ops::Range;

use physiology::{BeatsPerMinute, Context, FastCarbs, Grams, StepInput, Units, UnitsPerHour};

use crate::error::CohortError;
use crate::person::Person;
use crate::record::Channel;

/// What happens to a basal rate, bolus or meal that was not recorded.
///
/// A plant needs a number. There is no default, because a pump that is silent for an hour and a
/// pump that is switched off for an hour give different glucose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MissingDoses {
    /// A missing dose is an error that names the step and the column.
    Error,
    /// A missing dose counts as none given.
    Zero,
}

impl Person {
    /// The inputs of the steps `range`, one per step.
    ///
    /// Basal, bolus and carbohydrate come from the record under the policy `missing`. Carbohydrate
    /// is a meal, never a rescue, and no exercise is inferred. The context holds heart rate over
    /// the resting baseline (given, or estimated by
    /// [`resting_heart_rate`](Self::resting_heart_rate); `None` where either is unknown), hour,
    /// weekend and sleep efficiency.
    ///
    /// # Errors
    /// If the range leaves the record, if a dose is missing under [`MissingDoses::Error`], or if a
    /// value is not finite.
    pub fn inputs(
        &self,
        range: Range<usize>,
        missing: MissingDoses,
    ) -> Result<Vec<StepInput>, CohortError> {
        self.record.check_range(&range, &self.id)?;
        let baseline = self.resting_heart_rate().map(|rest| rest.0);
        range
            .map(|k| {
                let dose = |channel| self.dose(channel, k, missing);
                Ok(StepInput {
                    basal: UnitsPerHour(dose(Channel::Basal)?),
                    bolus: Units(dose(Channel::Bolus)?),
                    carbs: Grams(dose(Channel::Carbs)?),
                    rescue: FastCarbs::default(),
                    exercise: None,
                    context: Context {
                        heart_rate_over_baseline: self
                            .finite(Channel::HeartRate, k)?
                            .zip(baseline)
                            .map(|(rate, rest)| BeatsPerMinute(rate - rest)),
                        hour: self.record.hour(k),
                        weekend: self.record.weekend(k),
                        sleep_efficiency: self.finite(Channel::SleepEfficiency, k)?,
                    },
                })
            })
            .collect()
    }

    fn dose(&self, channel: Channel, k: usize, missing: MissingDoses) -> Result<f64, CohortError> {
        match (self.finite(channel, k)?, missing) {
            (Some(dose), _) => Ok(dose),
            (None, MissingDoses::Zero) => Ok(0.0),
            (None, MissingDoses::Error) => Err(CohortError::MissingDose {
                person: self.id.clone(),
                step: k,
                column: channel.name(),
            }),
        }
    }

    /// The value of a channel at step `k`, refused if it is not a finite number.
    pub(crate) fn finite(&self, channel: Channel, k: usize) -> Result<Option<f64>, CohortError> {
        match self.record.channel(channel)[k] {
            Some(value) if !value.is_finite() => Err(CohortError::NonFinite {
                person: self.id.clone(),
                step: k,
                column: channel.name(),
                value,
            }),
            value => Ok(value),
        }
    }
}

#[cfg(test)]
mod tests {
    use physiology::Kilograms;

    use super::*;
    use crate::{Record, Therapy};

    fn person() -> Person {
        let start = "2024-03-08T23:50:00".parse().expect("a literal time");
        let mut record = Record::new(start, 3).expect("on the grid");
        for (channel, values) in [
            (Channel::Basal, [Some(0.8), Some(0.9), None]),
            (Channel::Bolus, [Some(2.0), Some(0.0), Some(0.0)]),
            (Channel::Carbs, [Some(0.0), Some(30.0), Some(0.0)]),
            (Channel::HeartRate, [Some(60.0), None, Some(75.0)]),
            (Channel::SleepEfficiency, [Some(1.0), None, Some(0.5)]),
        ] {
            record.channel_mut(channel).copy_from_slice(&values);
        }
        Person {
            id: "a".into(),
            weight: Some(Kilograms(70.0)),
            therapy: Therapy::OpenLoopPump,
            heart_rate_baseline: Some(BeatsPerMinute(62.0)),
            record,
        }
    }

    #[test]
    fn a_step_carries_doses_and_context() {
        let inputs = person().inputs(0..2, MissingDoses::Error).expect("all doses recorded");
        assert_eq!(inputs[0].basal, UnitsPerHour(0.8));
        assert_eq!(inputs[0].bolus, Units(2.0));
        assert_eq!(inputs[1].carbs, Grams(30.0));
        assert_eq!(inputs[0].context.heart_rate_over_baseline, Some(BeatsPerMinute(-2.0)));
        assert_eq!(inputs[1].context.heart_rate_over_baseline, None);
        assert_eq!((inputs[0].context.hour, inputs[0].context.weekend), (23, false));
        assert_eq!(inputs[0].context.sleep_efficiency, Some(1.0));
    }

    #[test]
    fn a_missing_dose_is_never_guessed_silently() {
        let message = person().inputs(0..3, MissingDoses::Error).expect_err("no basal").to_string();
        assert!(
            message.starts_with("person 'a', step 2, column basal_u_h: not recorded"),
            "{message}"
        );
        let inputs = person().inputs(2..3, MissingDoses::Zero).expect("asked for zeros");
        assert_eq!(inputs[0].basal, UnitsPerHour(0.0));
    }

    #[test]
    fn values_that_are_not_finite_and_ranges_outside_are_errors() {
        let mut broken = person();
        broken.record.channel_mut(Channel::HeartRate)[1] = Some(f64::NAN);
        let message = broken.inputs(0..2, MissingDoses::Zero).expect_err("NaN").to_string();
        assert!(message.contains("step 1, column heart_rate_bpm: NaN"), "{message}");
        let message = broken.inputs(1..4, MissingDoses::Zero).expect_err("too far").to_string();
        assert!(message.contains("steps 1..4 were asked for, the record has 3"), "{message}");
    }
}
