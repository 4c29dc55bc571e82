//! The liver answers a low with more glucose.

use physiology::{MgPerDl, Minutes, STEP};

use super::forms::LowForm;

/// Glucose below which counter-regulation begins and at which it is fully active, mg/dL: adrenaline
/// is released from about 68 mg/dL on (Schwartz et al., J Clin Invest 1987;79:777) and near its
/// height 20 mg/dL lower.
const BEGINS: f64 = 70.0;
const FULL: f64 = 50.0;

/// How far a low has activated counter-regulation; it follows glucose with a lag.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LowTrace {
    level: f64,
}

impl LowTrace {
    /// The trace one step later, with `glucose` held through the step and a time constant `time`,
    /// in this form.
    #[must_use]
    pub fn after_step(self, glucose: MgPerDl, form: LowForm, time: Minutes) -> Self {
        let (begins, full) = match form {
            LowForm::Proportional | LowForm::Prolonged => (BEGINS, FULL),
            LowForm::Threshold => (63.0, 61.0),
            LowForm::Early => (80.0, 60.0),
        };
        let wanted = ((begins - glucose.0) / (begins - full)).clamp(0.0, 1.0);
        let fades = form == LowForm::Prolonged && wanted < self.level;
        let keep = (-STEP.0 / if fades { 6.0 * time.0 } else { time.0 }).exp();
        Self { level: wanted + keep * (self.level - wanted) }
    }

    /// Factor on the production when a full response raises it by the share `response`.
    #[must_use]
    pub fn production_factor(&self, response: f64) -> f64 {
        1.0 + response * self.level
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn production_rises_behind_a_low_and_not_without_one() {
        let run = |glucose: f64, steps: usize| {
            (0..steps).fold(LowTrace::default(), |t, _| {
                t.after_step(MgPerDl(glucose), LowForm::Proportional, Minutes(15.0))
            })
        };
        assert_eq!(run(71.0, 20).production_factor(1.0), 1.0);
        let early = run(50.0, 1).production_factor(0.8);
        let late = run(50.0, 24).production_factor(0.8);
        assert!(early < 1.3 && (late - 1.8).abs() < 1e-3, "{early} {late}"); // eight time constants
        assert!(run(60.0, 24).production_factor(0.8) < 1.41);
        assert_eq!(run(50.0, 24).production_factor(0.0), 1.0);
    }
}
