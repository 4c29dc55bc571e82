//! What the residual network sees besides the states: the vector u_Ind of the paper.

use std::f64::consts::TAU;

use physiology::{Context, StepInput};

use crate::heart_rate::HeartRateScaler;

/// States among the residual network's inputs: Q1, Q2, X1, X3, C2, scaled.
pub const STATE_INPUTS: usize = 5;
/// Personal inputs after the states: heart rate, weekend, cosine and sine of the hour, sleep.
pub const PERSONAL_INPUTS: usize = 5;
/// All inputs of the residual network. The published weights have ten columns in their first
/// layer, and 10-128-64-32-1 has 11,777 parameters.
pub const INPUTS: usize = STATE_INPUTS + PERSONAL_INPUTS;

/// Names of the residual network's inputs in their order.
pub const INPUT_NAMES: [&str; INPUTS] =
    ["Q1", "Q2", "X1", "X3", "C2", "heart_rate", "weekend", "hour_cos", "hour_sin", "sleep"];

named::named_in_json! {
    /// Which personal inputs reach the residual network (paper, "Contribution of individual-level
    /// inputs").
    ///
    /// An input outside the set is held at 0 in training and simulation alike, so that every variant
    /// has the same shape and number of parameters.
    #[derive(serde::Serialize, serde::Deserialize)]
    InputSet {
        /// Heart rate, weekend, hour and sleep efficiency.
        All: "all",
        /// Heart rate only.
        HeartRateOnly: "heart_rate_only",
        /// Sleep efficiency only.
        SleepOnly: "sleep_only",
        /// Weekend only.
        WeekendOnly: "weekend_only",
        /// Cosine and sine of the hour only.
        TimeOnly: "time_only",
        /// The states alone.
        None: "none",
    }
}

impl InputSet {
    /// The personal inputs of one step, in the network's order: scaled heart rate over baseline,
    /// weekend (0 or 1), cos(2 pi h / 24), sin(2 pi h / 24) of the integer hour h, sleep
    /// efficiency (0 to 1).
    ///
    /// What was not recorded is read as follows, and counted by [`MissingContext`]: heart rate as
    /// 0, which is the median of the training data after scaling; sleep efficiency as 0, awake.
    /// Without a scaler (no heart rate in the training data) every heart rate is read as 0.
    #[must_use]
    pub fn personal(
        self,
        context: &Context,
        scaler: Option<&HeartRateScaler>,
    ) -> [f64; PERSONAL_INPUTS] {
        let angle = TAU * f64::from(context.hour) / 24.0;
        let heart_rate = match (context.heart_rate_over_baseline, scaler) {
            (Some(rate), Some(scaler)) => scaler.scale(rate),
            _ => 0.0,
        };
        // Each with the set that, beside `All`, lets it through.
        let all = [
            (Self::HeartRateOnly, heart_rate),
            (Self::WeekendOnly, f64::from(context.weekend)),
            (Self::TimeOnly, angle.cos()),
            (Self::TimeOnly, angle.sin()),
            (Self::SleepOnly, context.sleep_efficiency.unwrap_or(0.0)),
        ];
        all.map(|(alone, value)| if self == Self::All || self == alone { value } else { 0.0 })
    }
}

/// How many steps lacked a personal input and were read as [`InputSet::personal`] says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub struct MissingContext {
    /// Steps counted.
    pub steps: usize,
    /// Of these, steps without a heart rate.
    pub heart_rate: usize,
    /// Of these, steps without a sleep efficiency.
    pub sleep_efficiency: usize,
}

impl MissingContext {
    /// Counts over the inputs of some steps.
    #[must_use]
    pub fn count<'a>(inputs: impl IntoIterator<Item = &'a StepInput>) -> Self {
        let mut missing = Self::default();
        for input in inputs {
            missing.steps += 1;
            missing.heart_rate += usize::from(input.context.heart_rate_over_baseline.is_none());
            missing.sleep_efficiency += usize::from(input.context.sleep_efficiency.is_none());
        }
        missing
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use physiology::BeatsPerMinute;

    fn evening() -> Context {
        Context {
            heart_rate_over_baseline: Some(BeatsPerMinute(30.0)),
            hour: 18,
            weekend: true,
            sleep_efficiency: Some(0.25),
        }
    }

    #[test]
    fn each_set_lets_through_its_own_inputs() {
        let scaler = HeartRateScaler { center: 10.0, scale: 20.0 };
        let cases: [(InputSet, [f64; 5]); 6] = [
            (InputSet::All, [1.0, 1.0, 0.0, -1.0, 0.25]),
            (InputSet::HeartRateOnly, [1.0, 0.0, 0.0, 0.0, 0.0]),
            (InputSet::WeekendOnly, [0.0, 1.0, 0.0, 0.0, 0.0]),
            (InputSet::TimeOnly, [0.0, 0.0, 0.0, -1.0, 0.0]),
            (InputSet::SleepOnly, [0.0, 0.0, 0.0, 0.0, 0.25]),
            (InputSet::None, [0.0; 5]),
        ];
        for (set, expected) in cases {
            let found = set.personal(&evening(), Some(&scaler));
            for (a, b) in found.iter().zip(expected) {
                assert!((a - b).abs() < 1e-15, "{set:?}: {found:?}"); // rounding of cos and sin
            }
        }
    }

    #[test]
    fn what_is_missing_is_read_as_the_median_or_awake_and_counted() {
        let scaler = HeartRateScaler { center: 10.0, scale: 20.0 };
        let nothing = Context::default();
        let read = InputSet::All.personal(&nothing, Some(&scaler));
        assert_eq!((read[0], read[4]), (0.0, 0.0));
        let known = StepInput { context: evening(), ..StepInput::default() };
        let missing = MissingContext::count(&[known, StepInput::default()]);
        assert_eq!(missing, MissingContext { steps: 2, heart_rate: 1, sleep_efficiency: 1 });
    }
}
