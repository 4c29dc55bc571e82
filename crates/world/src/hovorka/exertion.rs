//! What exercise does to glucose: uptake by working muscle, and higher insulin action afterwards.

use physiology::{Exercise, STEP};

/// Uptake in excess of production at an effort of 1, mmol/kg/min. With an effort near 0.5 glucose
/// falls by 40 to 60 mg/dL in 45 min, as in moderate continuous exercise with T1D
/// (Riddell et al., Lancet Diabetes Endocrinol 2017;5:377).
const UPTAKE: f64 = 0.028;
/// Time constant of the uptake, min.
const UPTAKE_TIME: f64 = 8.0;
/// Intensity above which the body releases more glucose of its own, % of VO2max; at 100 % the
/// release has overtaken four fifths of the uptake (Riddell et al. 2017).
const HARD: f64 = 70.0;
/// Rise of insulin action after 45 min at an effort of 0.5, as a share: 20 to 50 % over the
/// following hours (design of the effect after McMahon et al., J Clin Endocrinol Metab
/// 2007;92:963).
const SENSITIVITY: f64 = 0.30;
/// Effort times minutes of that session.
const SESSION: f64 = 22.5;
/// Time constants of the rise and of the decay of the higher action, min.
const RISE_TIME: f64 = 90.0;
const FADE_TIME: f64 = 480.0;

/// What past and present exercise does to the body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ExerciseTrace {
    /// Excess uptake relative to effort 1, after its lag.
    uptake: f64,
    /// Work done that has not yet become higher action, sessions.
    fresh: f64,
    /// Work done that has, sessions.
    settled: f64,
}

impl ExerciseTrace {
    /// The trace one step later, with `exercise` held through the step.
    #[must_use]
    pub fn after_step(self, exercise: Option<Exercise>) -> Self {
        let intensity = exercise.map_or(0.0, |e| e.vo2max_percent);
        let effort = (intensity - 5.0).max(0.0) / 100.0;
        let net = effort * (1.0 - 0.8 * ((intensity - HARD) / (100.0 - HARD)).clamp(0.0, 1.0));
        let keep = (-STEP.0 / UPTAKE_TIME).exp();
        let turned = self.fresh * (1.0 - (-STEP.0 / RISE_TIME).exp());
        Self {
            uptake: net + keep * (self.uptake - net),
            fresh: self.fresh - turned + effort * STEP.0 / SESSION,
            settled: (self.settled + turned) * (-STEP.0 / FADE_TIME).exp(),
        }
    }

    /// Glucose taken from the accessible compartment, mmol/kg/min, at a glucose of `mmol_per_l`.
    ///
    /// Below 4.5 mmol/L it falls in proportion, as the model's own uptake does.
    #[must_use]
    pub fn uptake(&self, mmol_per_l: f64, amplitude: f64) -> f64 {
        amplitude * UPTAKE * self.uptake * (mmol_per_l / 4.5).min(1.0)
    }

    /// Factor on the action of insulin in the periphery.
    #[must_use]
    pub fn action_factor(&self, amplitude: f64) -> f64 {
        1.0 + amplitude * SENSITIVITY * self.settled.min(2.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uptake_follows_the_session_and_action_outlasts_it() {
        let bout = Exercise { vo2max_percent: 55.0, active_muscle_share: 0.5 };
        let mut trace = ExerciseTrace::default();
        for _ in 0..9 {
            trace = trace.after_step(Some(bout));
        }
        assert!(trace.uptake(7.0, 1.0) > 0.95 * UPTAKE * 0.5);
        assert!(trace.uptake(2.25, 1.0) < 0.51 * UPTAKE * 0.5);
        let mut best: f64 = 1.0;
        for _ in 0..36 {
            trace = trace.after_step(None);
            best = best.max(trace.action_factor(1.0));
        }
        assert!((1.1..1.3).contains(&best), "{best}");
        assert!(trace.uptake(7.0, 1.0) < 1e-6); // 180 min are 22 time constants
        for _ in 0..300 {
            trace = trace.after_step(None);
        }
        assert!(trace.action_factor(1.0) < 1.02); // 25 h later
        assert_eq!(trace.action_factor(0.0), 1.0);
    }

    #[test]
    fn very_hard_exercise_takes_up_less() {
        let after = |vo2max_percent| {
            let bout = Exercise { vo2max_percent, active_muscle_share: 0.5 };
            (0..6).fold(ExerciseTrace::default(), |t, _| t.after_step(Some(bout))).uptake(7.0, 1.0)
        };
        assert!(after(95.0) < after(65.0));
    }
}
