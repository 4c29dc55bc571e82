//! What exercise does to the minimal body.
//!
//! It acts at the same points as in Roy and Parker (J Diabetes Sci Technol 2007;1:338), who
//! extended the minimal model by it: uptake by muscle and release by the liver follow the intensity
//! with their own rates, as fluxes besides those of insulin. There the intensity is that above rest
//! in per cent of VO2max, as here.

use physiology::{Exercise, STEP};

/// Uptake at full intensity in steady state, mg/kg/min: half more than a_3/a_4 of Roy and
/// Parker (4.0). With it glucose falls by 40 to 60 mg/dL in 45 min at half of it (Riddell et al., Lancet
/// Diabetes Endocrinol 2017;5:377).
const UPTAKE: f64 = 6.0;
/// Rate of the uptake a_4, 1/min.
const UPTAKE_RATE: f64 = 0.0485;
/// Release at full intensity as a share of the uptake, and its rate a_2, 1/min. In the original it
/// is seven tenths. Insulin under the skin does not fall in exercise and suppresses it.
const RELEASE: f64 = 0.15;
const RELEASE_RATE: f64 = 0.056;
/// Largest rise of the insulin sensitivity of disposal, and the work (intensity times minutes) at
/// half of it: 28 % after 45 min at half intensity (20 to 50 % in McMahon et al., J Clin Endocrinol
/// Metab 2007;92:963).
const SENSITIVITY: f64 = 0.60;
const HALF_WORK: f64 = 24.0;
/// Minutes after which half of the work is forgotten; the decay begins slowly.
const FORGETTING: f64 = 420.0;

/// What past and present exercise does to the body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WorkDone {
    /// Uptake relative to that at full intensity.
    uptake: f64,
    /// Release relative to that at full intensity.
    release: f64,
    /// Work remembered in full, and in part, intensity times minutes.
    fresh: f64,
    waning: f64,
}

impl WorkDone {
    /// One step later, with `exercise` held through the step.
    #[must_use]
    pub fn after_step(self, exercise: Option<Exercise>) -> Self {
        let intensity = (exercise.map_or(0.0, |e| e.vo2max_percent) / 100.0).clamp(0.0, 1.0);
        let follow =
            |value: f64, rate: f64| intensity + (value - intensity) * (-rate * STEP.0).exp();
        // Two stages of equal rate: their sum is at half after 1.68 of their time constants.
        let keep = (-1.68 * STEP.0 / FORGETTING).exp();
        Self {
            uptake: follow(self.uptake, UPTAKE_RATE),
            release: follow(self.release, RELEASE_RATE),
            fresh: keep * self.fresh + intensity * STEP.0,
            waning: keep * (self.waning + (1.0 - keep) / keep * self.fresh),
        }
    }

    /// Glucose that leaves plasma for muscle minus what the liver releases for it, mg/kg/min.
    #[must_use]
    pub fn net_uptake(&self, amplitude: f64) -> f64 {
        amplitude * UPTAKE * (self.uptake - RELEASE * self.release)
    }

    /// Factor on the insulin sensitivity of disposal.
    #[must_use]
    pub fn action_factor(&self, amplitude: f64) -> f64 {
        let work = self.fresh + self.waning;
        1.0 + amplitude * SENSITIVITY * work / (HALF_WORK + work)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uptake_follows_the_session_and_sensitivity_outlasts_it() {
        let bout = Exercise { vo2max_percent: 50.0, active_muscle_share: 0.5 };
        let during = (0..9).fold(WorkDone::default(), |t, _| t.after_step(Some(bout)));
        // 45 min are 2.2 time constants: a tenth short of the steady value.
        let steady = UPTAKE * 0.5 * (1.0 - RELEASE);
        assert!((during.net_uptake(1.0) / steady - 0.9).abs() < 0.03);
        assert!((during.action_factor(1.0) - 1.28).abs() < 0.03, "{}", during.action_factor(1.0));
        let later = (0..72).fold(during, |t, _| t.after_step(None)); // 6 h
        assert!(later.net_uptake(1.0).abs() < 1e-4);
        assert!((1.1..1.25).contains(&later.action_factor(1.0)), "{}", later.action_factor(1.0));
        let next_day = (0..288).fold(during, |t, _| t.after_step(None));
        assert!(next_day.action_factor(1.0) < 1.03, "{}", next_day.action_factor(1.0));
        assert_eq!((later.action_factor(0.0), during.net_uptake(0.0)), (1.0, 0.0));
    }
}
