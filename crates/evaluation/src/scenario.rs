//! Windows that begin with something that moves glucose (paper, "Contribution of individual-level
//! inputs").
//!
//! The paper names the three scenarios and does not say how windows were found. Here a window begins
//! where the event does; windows of one scenario do not overlap.

use std::ops::Range;

use cohort::{Person, Window, WindowRule, windows};
use physiology::{STEPS_PER_HOUR, StepInput};

use crate::error::EvaluationError;

named::named! {
    /// An event that a window begins with.
    Scenario {
        /// Heart rate (or, where it is not recorded, steps) raised for half an hour.
        PhysicalActivity: "physical_activity",
        /// A meal of at least 10 g.
        Meal: "meal",
        /// Falling asleep for at least two hours.
        Sleep: "sleep",
    }
}

/// Smallest meal, g: less is a treatment of a low or a correction of the log.
const LEAST_MEAL: f64 = 10.0;
/// Heart rate over baseline of physical activity, 1/min: about 15 % of the reserve of a young adult.
const RAISED_HEART_RATE: f64 = 20.0;
/// Steps in five minutes that count as walking briskly (100 a minute).
const WALKING: f64 = 500.0;
/// Steps of half an hour, and how many of them must be raised.
const HALF_HOUR: usize = STEPS_PER_HOUR / 2;
const RAISED_STEPS: usize = 5;
/// Two hours of sleep, and how many steps of them must be asleep.
const TWO_HOURS: usize = 2 * STEPS_PER_HOUR;
const ASLEEP_STEPS: usize = 20;
/// Share of a step asleep that counts.
const ASLEEP: f64 = 0.5;
/// Steps without the event that must come before it: an hour.
const QUIET: usize = STEPS_PER_HOUR;

impl Scenario {
    /// The name for people.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Self::PhysicalActivity => "Physical activity",
            Self::Meal => "Meals",
            Self::Sleep => "Sleep",
        }
    }

    /// Whether the event begins at a step of the record.
    fn begins(self, person: &Person, inputs: &[StepInput], step: usize) -> bool {
        let holds = |k: usize| match self {
            Self::Meal => inputs[k].carbs.0 >= LEAST_MEAL,
            Self::PhysicalActivity => match inputs[k].context.heart_rate_over_baseline {
                Some(rate) => rate.0 >= RAISED_HEART_RATE,
                None => person.record.steps()[k].is_some_and(|steps| steps >= WALKING),
            },
            Self::Sleep => inputs[k].context.sleep_efficiency.is_some_and(|share| share >= ASLEEP),
        };
        // Steps that it lasts, and how many of them must hold it.
        let (lasts, least) = match self {
            Self::Meal => return holds(step),
            Self::PhysicalActivity => (HALF_HOUR, RAISED_STEPS),
            Self::Sleep => (TWO_HOURS, ASLEEP_STEPS),
        };
        holds(step)
            && step + lasts <= inputs.len()
            && (step..step + lasts).filter(|k| holds(*k)).count() >= least
            && !(step.saturating_sub(QUIET)..step).any(holds)
    }

    /// Windows in `range` that begin with the event and are as complete as `rule` asks; none
    /// overlaps an earlier one.
    pub(crate) fn windows(
        self,
        index: usize,
        person: &Person,
        inputs: &[StepInput],
        range: Range<usize>,
        rule: &WindowRule,
    ) -> Result<Vec<Window>, EvaluationError> {
        let mut found: Vec<Window> = Vec::new();
        for step in range.clone() {
            let free = found.last().is_none_or(|last| step >= last.start + last.len);
            let end = step + rule.len;
            if free && end <= range.end && self.begins(person, inputs, step) {
                found.extend(windows(index, &person.record, step..end, rule)?);
            }
        }
        Ok(found)
    }
}
