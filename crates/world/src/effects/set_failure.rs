//! An infusion set fails: from some time on little or nothing of the insulin arrives.

use physiology::STEPS_PER_HOUR;
use rand::{Rng, RngExt};

use super::forms::SetFailureForm;
use crate::behaviour::Life;

/// Share of sets that fail at amplitude 1: 3.3 % within their labelled life (rate of the design of
/// this effect; unexplained failures of 1 to 9 % are reported, e.g. Patel et al., Diabetes Technol
/// Ther 2014;16:15).
const SHARE: f64 = 0.033;

/// What would happen to one set if it failed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetFailure {
    /// Uniform draw from 0 to 1: the set fails if this lies below the share of failing sets.
    pub draw: f64,
    /// First step with less insulin.
    pub from: i64,
    /// Step of the change that ends it.
    pub until: i64,
    /// Step at which the set was put in.
    pub placed: i64,
    /// Share of the insulin that still arrives.
    pub left: f64,
}

/// Draws what would happen to each set that is changed within the record.
///
/// A failure is the reason for changing the set. It begins 4 to 14 h before the change (not before
/// the set is inserted) and leaves 0 to 30 % of the insulin.
#[must_use]
pub(super) fn sample(life: &Life, rng: &mut (impl Rng + ?Sized)) -> Vec<SetFailure> {
    let changes = life.sets.changes();
    changes
        .windows(2)
        .map(|pair| {
            let (draw, left) = (rng.random(), rng.random_range(0.0..0.3));
            let hours: f64 = rng.random_range(4.0..14.0);
            let from = pair[1] - (hours * STEPS_PER_HOUR as f64) as i64;
            SetFailure { draw, from: from.max(pair[0]), until: pair[1], placed: pair[0], left }
        })
        .collect()
}

/// Share of the insulin that arrives in a step.
#[must_use]
pub(super) fn bioavailability(
    form: SetFailureForm,
    sets: &[SetFailure],
    step: usize,
    amplitude: f64,
) -> f64 {
    let step = step as i64;
    sets.iter()
        .find(|set| (set.placed..set.until).contains(&step) && set.draw < amplitude * SHARE)
        .map_or(1.0, |set| set.arriving(form, step))
}

impl SetFailure {
    /// Share of the insulin that arrives in a step while the set is worn.
    fn arriving(&self, form: SetFailureForm, step: i64) -> f64 {
        let lasts = self.until - self.from;
        match form {
            SetFailureForm::Partial if step >= self.from => self.left,
            SetFailureForm::Complete if step >= self.until - lasts / 2 => 0.0,
            SetFailureForm::AtInsertion if step < self.placed + lasts => self.left,
            SetFailureForm::Slow => {
                let from = (self.until - 3 * lasts).max(self.placed);
                let along = (step - from) as f64 / (self.until - from).max(1) as f64;
                1.0 - (1.0 - self.left) * along.clamp(0.0, 1.0)
            }
            SetFailureForm::Partial | SetFailureForm::Complete | SetFailureForm::AtInsertion => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failing_set_gives_little_until_it_is_changed() {
        let set = SetFailure { draw: 0.2, from: 100, until: 200, placed: 20, left: 0.1 };
        let bioavailability = |sets: &[SetFailure], step, amplitude| {
            bioavailability(SetFailureForm::Partial, sets, step, amplitude)
        };
        assert_eq!(bioavailability(&[set], 150, 1.0), 1.0);
        assert_eq!(bioavailability(&[set], 150, 10.0), 0.1);
        assert_eq!(bioavailability(&[set], 99, 10.0), 1.0);
        assert_eq!(bioavailability(&[set], 200, 10.0), 1.0);
    }
}
