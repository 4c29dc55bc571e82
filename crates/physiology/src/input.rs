//! What acts on a person during one five-minute step.

use crate::units::{BeatsPerMinute, Grams, Minutes, Units, UnitsPerHour};

/// Length of a step: the sampling period of the paper and of CGM, 5 min.
pub const STEP: Minutes = Minutes(5.0);
/// Steps in an hour.
pub const STEPS_PER_HOUR: usize = 12;
/// Steps in a day.
pub const STEPS_PER_DAY: usize = 288;

/// Inputs of one step. Meals, boluses and exercise are inputs, never constants in an equation.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StepInput {
    /// Basal infusion through the step.
    pub basal: UnitsPerHour,
    /// Bolus insulin delivered within the step.
    pub bolus: Units,
    /// Carbohydrate eaten at the start of the step.
    pub carbs: Grams,
    /// Fast carbohydrate taken against low glucose.
    pub rescue: FastCarbs,
    /// Exercise held through the step; `None` at rest.
    pub exercise: Option<Exercise>,
    /// What the personal model sees beyond insulin and carbohydrate.
    pub context: Context,
}

impl StepInput {
    /// Basal and bolus together as a rate over the step: the model's u_I.
    #[inline]
    #[must_use]
    pub fn insulin(&self) -> UnitsPerHour {
        self.basal + self.bolus.over(STEP)
    }
}

/// Fast-absorbing carbohydrate (glucose tablets, juice).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FastCarbs {
    /// Amount eaten.
    pub amount: Grams,
    /// Time since it was eaten at the start of the step; 0 for "now". A rescue that is decided
    /// from a reading and belongs to the step before carries 5 min here.
    pub eaten_before: Minutes,
}

/// Aerobic exercise at one intensity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exercise {
    /// Intensity, per cent of maximal oxygen uptake (0 to 100).
    pub vo2max_percent: f64,
    /// Share of the muscle mass that is active (0 to 1).
    pub active_muscle_share: f64,
}

/// Personal context of a step (paper, section on the individual-level model, vector u_Ind).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Context {
    /// Heart rate over the person's resting baseline; `None` if not recorded.
    pub heart_rate_over_baseline: Option<BeatsPerMinute>,
    /// Hour of the local day, 0 to 23.
    pub hour: u8,
    /// Whether the step lies on a Saturday or Sunday.
    pub weekend: bool,
    /// Share of the step spent asleep, 0 to 1; `None` if not recorded.
    pub sleep_efficiency: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn insulin_adds_the_bolus_as_a_rate_over_the_step() {
        let input =
            StepInput { basal: UnitsPerHour(0.8), bolus: Units(2.0), ..StepInput::default() };
        assert!((input.insulin().0 - 24.8).abs() < 1e-12); // 0.8 + 2 x 12, rounding of the sum
    }
}
