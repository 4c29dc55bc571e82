//! What exercise does to the saturating body.
//!
//! Contraction brings carriers to the surface of muscle as insulin does, independently of it
//! (Richter and Hargreaves, Physiol Rev 2013;93:993). So work adds to the capacity of uptake. It
//! spends glycogen, and muscle takes up more under insulin until the glycogen is refilled, which
//! takes a day. The state is this debt, not the time since exercise.

use physiology::{Exercise, STEP};

/// Capacity that full effort adds, mmol/kg/min: with half of it for 45 min glucose falls by 40 to
/// 60 mg/dL (Riddell et al., Lancet Diabetes Endocrinol 2017;5:377).
const CAPACITY: f64 = 0.062;
/// Time constants with which carriers come and go, min.
const COME: f64 = 8.0;
const GO: f64 = 30.0;
/// Intensity above which the liver releases more, % of VO2max, and the rise of production at 100 %.
const HARD: f64 = 70.0;
const RELEASE: f64 = 1.0;
/// Largest rise of insulin's action on muscle, and its debt of glycogen, in units of effort times
/// minutes, at half of it: 28 % after 45 min at half effort (McMahon et al., J Clin Endocrinol
/// Metab 2007;92:963).
const SENSITIVITY: f64 = 0.70;
const HALF_DEBT: f64 = 34.0;
/// Largest rate at which glycogen is refilled, effort times minutes per minute, and the debt at
/// which it is half of that: the first half of a session's debt takes about five hours.
const REFILL: f64 = 0.08;
const HALF_REFILL: f64 = 15.0;

/// What past and present exercise does to the body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SpentGlycogen {
    /// Carriers at the surface relative to full effort.
    carriers: f64,
    /// Release from the liver relative to that at full effort.
    release: f64,
    /// Glycogen spent and not refilled, effort times minutes.
    debt: f64,
}

impl SpentGlycogen {
    /// One step later, with `exercise` held through the step.
    #[must_use]
    pub fn after_step(self, exercise: Option<Exercise>) -> Self {
        let intensity = exercise.map_or(0.0, |e| e.vo2max_percent);
        let effort = (intensity / 100.0).clamp(0.0, 1.0);
        let hard = ((intensity - HARD) / (100.0 - HARD)).clamp(0.0, 1.0);
        let time = if effort > self.carriers { COME } else { GO };
        let keep = (-STEP.0 / time).exp();
        let refilled = STEP.0 * REFILL * self.debt / (HALF_REFILL + self.debt);
        Self {
            carriers: effort + keep * (self.carriers - effort),
            release: hard + keep * (self.release - hard),
            debt: (self.debt - refilled).max(0.0) + effort * STEP.0,
        }
    }

    /// Capacity of uptake that work adds, mmol/kg/min.
    #[must_use]
    pub fn capacity(&self, amplitude: f64) -> f64 {
        amplitude * CAPACITY * self.carriers
    }

    /// Factor on production.
    #[must_use]
    pub fn production_factor(&self, amplitude: f64) -> f64 {
        1.0 + amplitude * RELEASE * self.release
    }

    /// Factor on the insulin that acts on muscle.
    #[must_use]
    pub fn action_factor(&self, amplitude: f64) -> f64 {
        1.0 + amplitude * SENSITIVITY * self.debt / (HALF_DEBT + self.debt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn carriers_follow_the_session_and_the_debt_outlasts_it() {
        let bout = Exercise { vo2max_percent: 50.0, active_muscle_share: 0.5 };
        let during = (0..9).fold(SpentGlycogen::default(), |t, _| t.after_step(Some(bout)));
        assert!((during.capacity(1.0) / (0.5 * CAPACITY) - 1.0).abs() < 0.01); // six time constants
        assert!((during.action_factor(1.0) - 1.28).abs() < 0.03, "{}", during.action_factor(1.0));
        let later = (0..72).fold(during, |t, _| t.after_step(None)); // 6 h
        assert!(later.capacity(1.0) < 1e-5);
        assert!((1.05..1.2).contains(&later.action_factor(1.0)), "{}", later.action_factor(1.0));
        let next_day = (0..288).fold(during, |t, _| t.after_step(None));
        assert!(next_day.action_factor(1.0) < 1.02, "{}", next_day.action_factor(1.0));
        assert_eq!((later.action_factor(0.0), during.capacity(0.0)), (1.0, 0.0));
    }

    #[test]
    fn only_hard_exercise_releases_glucose() {
        let after = |vo2max_percent| {
            let bout = Exercise { vo2max_percent, active_muscle_share: 0.5 };
            SpentGlycogen::default().after_step(Some(bout)).production_factor(1.0)
        };
        assert_eq!(after(65.0), 1.0);
        assert!(after(90.0) > 1.1);
    }
}
