//! Exercise as in Resalat et al. 2019: acute uptake and a sensitivity that outlasts the bout.

use physiology::{Exercise, STEP};

/// Time constant of the peripheral glucose uptake of active tissue Gam, min.
pub const UPTAKE_TIME_CONSTANT: f64 = 30.0;
/// Where the authors' simulator starts Gam at the onset of exercise, mg/min.
pub const UPTAKE_AT_ONSET: f64 = 0.1;
/// Scale of Gam in the multiplier of peripheral uptake, mg/min.
pub const PERIPHERAL_UPTAKE_SCALE: f64 = 35.0;
/// Scale of Gam in the multiplier of hepatic production, mg/min.
pub const HEPATIC_PRODUCTION_SCALE: f64 = 155.0;
/// Gain of peripheral insulin uptake by the active muscle share, unitless.
pub const PERIPHERAL_INSULIN_GAIN: f64 = 2.4;
/// Steps after the last step of exercise at which its effect ends: 5 h.
pub const RECOVERY_STEPS: u32 = 60;

/// Steady uptake of active tissue Gss = max(0, 0.006 v^2 + 1.2264 v - 10.1958), mg/min.
///
/// `v` is the intensity in per cent of maximal oxygen uptake.
#[must_use]
pub fn steady_uptake(v: f64) -> f64 {
    let uptake = 0.006 * v * v + 1.2264 * v - 10.1958;
    if uptake < 0.0 { 0.0 } else { uptake }
}

/// Multipliers of the insulin effects; 1 at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Multipliers {
    /// M_PGU, peripheral glucose uptake: on the sources of X1 and X2.
    pub peripheral_glucose_uptake: f64,
    /// M_PIU, peripheral insulin uptake: on the sources of X1 and X2.
    pub peripheral_insulin_uptake: f64,
    /// M_HGP, hepatic glucose production: on the source of X3.
    ///
    /// It raises X3 and so *lowers* production, against physiology; kept as the authors have it.
    pub hepatic_glucose_production: f64,
}

impl Multipliers {
    /// No exercise within reach: all one.
    pub const REST: Self = Self {
        peripheral_glucose_uptake: 1.0,
        peripheral_insulin_uptake: 1.0,
        hepatic_glucose_production: 1.0,
    };

    /// Factor on the sources of X1 and X2.
    #[inline]
    #[must_use]
    pub fn on_periphery(&self) -> f64 {
        self.peripheral_insulin_uptake * self.peripheral_glucose_uptake
    }
}

impl Default for Multipliers {
    fn default() -> Self {
        Self::REST
    }
}

/// What exercise up to the last step has left behind.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum ExerciseMemory {
    /// None within the last 5 h.
    #[default]
    Rest,
    /// A bout is going on or ended less than 5 h ago.
    Active {
        /// Gam at the start of the last step, mg/min.
        uptake: f64,
        /// Active muscle share of the (last) bout, 0 to 1.
        share: f64,
        /// Steps since the last step of exercise; 0 if the last step was one.
        steps_since: u32,
    },
}

impl ExerciseMemory {
    /// The memory during a step, given the exercise of that step.
    ///
    /// Gam follows dGam/dt = (Gss - Gam)/30 min, solved exactly from step to step, from
    /// [`UPTAKE_AT_ONSET`] where a bout begins at rest; after the last step of exercise it decays
    /// from the value it had at the start of that step (as in the authors' test program) with
    /// the same time constant. Intensity is not clamped.
    #[inline]
    #[must_use]
    pub fn during(self, exercise: Option<Exercise>) -> Self {
        let kept = (-STEP.0 / UPTAKE_TIME_CONSTANT).exp();
        match (self, exercise) {
            (Self::Rest, None) => Self::Rest,
            (before, Some(e)) => {
                let steady = steady_uptake(e.vo2max_percent);
                let uptake = match before {
                    Self::Rest => UPTAKE_AT_ONSET,
                    Self::Active { uptake, .. } => steady + (uptake - steady) * kept,
                };
                Self::Active { uptake, share: e.active_muscle_share, steps_since: 0 }
            }
            (Self::Active { steps_since, .. }, None) if steps_since + 1 >= RECOVERY_STEPS => {
                Self::Rest
            }
            (Self::Active { uptake, share, steps_since }, None) => {
                Self::Active { uptake: uptake * kept, share, steps_since: steps_since + 1 }
            }
        }
    }

    /// The multipliers of a step whose memory is `self` (see [`during`](Self::during)).
    #[inline]
    #[must_use]
    pub fn multipliers(self) -> Multipliers {
        match self {
            Self::Rest => Multipliers::REST,
            Self::Active { uptake, share, steps_since } => Multipliers {
                peripheral_glucose_uptake: 1.0 + uptake * share / PERIPHERAL_UPTAKE_SCALE,
                peripheral_insulin_uptake: if steps_since == 0 {
                    1.0 + PERIPHERAL_INSULIN_GAIN * share
                } else {
                    1.0
                },
                hepatic_glucose_production: 1.0 + uptake * share / HEPATIC_PRODUCTION_SCALE,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUT: Exercise = Exercise { vo2max_percent: 60.0, active_muscle_share: 0.5 };

    fn uptake(memory: ExerciseMemory) -> f64 {
        match memory {
            ExerciseMemory::Rest => 0.0,
            ExerciseMemory::Active { uptake, .. } => uptake,
        }
    }

    #[test]
    fn steady_uptake_is_zero_below_its_root() {
        assert_eq!(steady_uptake(8.0), 0.0);
        assert!(steady_uptake(f64::NAN).is_nan(), "nothing is replaced");
        assert!((steady_uptake(60.0) - 84.9882).abs() < 1e-12); // by hand, rounding
    }

    #[test]
    fn uptake_rises_and_decays_in_closed_form() {
        let mut memory = ExerciseMemory::default();
        let gss = steady_uptake(60.0);
        let mut last = 0.0;
        for k in 0..10 {
            memory = memory.during(Some(BOUT));
            last = gss + (UPTAKE_AT_ONSET - gss) * (-5.0 * f64::from(k) / 30.0).exp();
            assert!((uptake(memory) - last).abs() < 1e-12, "step {k}"); // rounding
            assert_eq!(memory.multipliers().peripheral_insulin_uptake, 2.2);
        }
        for k in 1..60 {
            memory = memory.during(None);
            let expected = last * (-5.0 * f64::from(k) / 30.0).exp();
            assert!((uptake(memory) - expected).abs() < 1e-12, "step {k} after"); // rounding
            assert_eq!(memory.multipliers().peripheral_insulin_uptake, 1.0);
        }
        assert_eq!(memory.during(None), ExerciseMemory::Rest);
    }

    #[test]
    fn a_second_bout_goes_on_from_where_uptake_is() {
        let first = ExerciseMemory::default().during(Some(BOUT)).during(Some(BOUT));
        let resumed = first.during(None).during(Some(BOUT));
        assert!(uptake(resumed) > uptake(first));
    }
}
