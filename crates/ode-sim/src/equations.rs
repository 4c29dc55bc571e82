//! The model equations, term by term: Eq. (1) of the paper, completed from Resalat et al. 2019.
//!
//! The paper leaves F01c and F_R undefined; they follow Hovorka et al. 2004 with the constants of
//! the authors' simulator. All functions are pure and work on bare numbers in the units named.
//!
//! They are written once over a [`Scalar`]: with `f64` they step the plant, with [`Dual`] they give
//! exact derivatives by states or by parameters.

use physiology::Compartment::{C1, C2, I, Q1, Q2, S1, S2, X1, X2, X3};

use crate::dual::{Dual, Scalar};
use crate::exercise::Multipliers;
use crate::parameters::OdeParameters;
use crate::state::{OdeMatrix, OdeVector};

/// Glucose below which non-insulin uptake falls in proportion, mmol/L (Hovorka et al. 2004).
pub const UPTAKE_SATURATION: f64 = 4.5;
/// Glucose above which the kidneys clear glucose, mmol/L (Hovorka et al. 2004).
pub const RENAL_THRESHOLD: f64 = 9.0;
/// Renal clearance rate above the threshold, 1/min (Hovorka et al. 2004).
pub const RENAL_RATE: f64 = 0.003;

/// What to do where insulin effect on the liver exceeds one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EgpMode {
    /// EGP0 (1 - X3) as it stands in Eq. (1g): may go negative, as in the authors' code.
    Reproduction,
    /// EGP0 max(0, 1 - X3): production never takes glucose up.
    NonNegative,
}

/// What acts on the compartments at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Forcing {
    /// Insulin infusion u_I, mU/kg/min.
    pub insulin: f64,
    /// Glucose flux into Q1 besides C2 (rescue carbohydrate, a disturbance), mmol/kg/min.
    pub glucose_flux: f64,
    /// Exercise multipliers.
    pub exercise: Multipliers,
}

/// Non-insulin-mediated uptake F01c, mmol/kg/min: F01 from 4.5 mmol/L on, F01 G/4.5 below.
///
/// `g` glucose in mmol/L, `f_01` in mmol/kg/min.
#[inline]
#[must_use]
pub fn non_insulin_uptake<T: Scalar>(g: T, f_01: T) -> T {
    if g >= UPTAKE_SATURATION { f_01 } else { f_01 * g / T::from(UPTAKE_SATURATION) }
}

/// Renal clearance F_R, mmol/kg/min: 0.003 (G - 9) V_G from 9 mmol/L on, 0 below.
///
/// `g` glucose in mmol/L, `v_g` in L/kg.
#[inline]
#[must_use]
pub fn renal_clearance<T: Scalar>(g: T, v_g: T) -> T {
    if g >= RENAL_THRESHOLD {
        T::from(RENAL_RATE) * (g - T::from(RENAL_THRESHOLD)) * v_g
    } else {
        T::from(0.0)
    }
}

/// Endogenous-glucose-production term EGP0 (1 - X3) of Eq. (1g), mmol/kg/min.
///
/// `x3` is unitless. Negative only in [`EgpMode::Reproduction`].
#[inline]
#[must_use]
pub fn endogenous_production<T: Scalar>(x3: T, egp_0: T, mode: EgpMode) -> T {
    match mode {
        EgpMode::NonNegative if x3 > 1.0 => T::from(0.0),
        EgpMode::Reproduction | EgpMode::NonNegative => egp_0 * (T::from(1.0) - x3),
    }
}

/// Insulin infusion u_I of Eq. (1a), mU/kg/min, from a rate in U/h and a weight in kg.
#[inline]
#[must_use]
pub fn infusion(units_per_hour: f64, weight: f64) -> f64 {
    units_per_hour * 1000.0 / 60.0 / weight
}

/// Rate of change of the ten compartments, per minute.
///
/// Eqs. (1a) to (1h), and dC1 = -C1/t_max,G, dC2 = (C1 - C2)/t_max,G with U_G = C2/t_max,G
/// (Eq. U_G; eating is a jump of C1 and not part of the derivative). `x` in the units of
/// [`OdeState`](crate::OdeState).
#[inline]
#[must_use]
pub fn derivative<T: Scalar>(
    p: &OdeParameters<T>,
    x: &OdeVector<T>,
    forcing: &Forcing,
    egp: EgpMode,
) -> OdeVector<T> {
    let g = x[Q1] / p.v_g;
    let periphery = T::from(forcing.exercise.on_periphery());
    let liver = T::from(forcing.exercise.hepatic_glucose_production);
    let mut dx = OdeVector([T::from(0.0); 10]);
    dx[S1] = T::from(forcing.insulin) - x[S1] / p.t_max_i; // (1a)
    dx[S2] = (x[S1] - x[S2]) / p.t_max_i; // (1b)
    dx[I] = x[S2] / (p.t_max_i * p.v_i) - p.k_e * x[I]; // (1c)
    dx[X1] = p.k_a1 * (periphery * p.s_f1 * x[I] - x[X1]); // (1d)
    dx[X2] = p.k_a2 * (periphery * p.s_f2 * x[I] - x[X2]); // (1e)
    dx[X3] = p.k_a3 * (liver * p.s_f3 * x[I] - x[X3]); // (1f)
    dx[Q1] = -x[X1] * x[Q1] - non_insulin_uptake(g, p.f_01) - renal_clearance(g, p.v_g)
        + p.k_12 * x[Q2]
        + x[C2] / p.t_max_g
        + T::from(forcing.glucose_flux)
        + endogenous_production(x[X3], p.egp_0, egp); // (1g)
    dx[Q2] = x[X1] * x[Q1] - (p.k_12 + x[X2]) * x[Q2]; // (1h)
    dx[C1] = -x[C1] / p.t_max_g; // (U_G)
    dx[C2] = (x[C1] - x[C2]) / p.t_max_g; // (U_G)
    dx
}

/// Jacobian of [`derivative`] by the ten compartments: `j[(Q1, X1)]` is d(dQ1/dt)/dX1, 1/min in
/// matching units.
///
/// At the kinks (4.5 and 9 mmol/L, X3 = 1 in [`EgpMode::NonNegative`]) the slope from above for
/// glucose and from below for X3.
#[inline]
#[must_use]
pub fn jacobian(p: &OdeParameters, x: &OdeVector, forcing: &Forcing, egp: EgpMode) -> OdeMatrix {
    let constants = p.map(Dual::<10>::from);
    let variables = std::array::from_fn(|k| Dual::variable(x.0[k], k));
    let rates = derivative(&constants, &OdeVector(variables), forcing, egp);
    OdeMatrix(rates.0.map(|rate| rate.slopes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uptake_and_clearance_by_hand_and_without_jumps() {
        let p = OdeParameters::nominal();
        // (glucose mmol/L, F01c, F_R), mmol/kg/min
        let cases = [
            (0.0, 0.0, 0.0),
            (2.25, 0.00485, 0.0),
            (4.5, 0.0097, 0.0),
            (9.0, 0.0097, 0.0),
            (19.0, 0.0097, 0.0048),
        ];
        for (g, uptake, clearance) in cases {
            assert!((non_insulin_uptake(g, p.f_01) - uptake).abs() < 1e-16, "{g}"); // rounding
            assert!((renal_clearance(g, p.v_g) - clearance).abs() < 1e-16, "{g}"); // rounding
        }
        let below = 1.0 - 1e-12;
        assert!((non_insulin_uptake(4.5 * below, p.f_01) - p.f_01).abs() < 1e-13);
        assert_eq!(renal_clearance(9.0 * below, p.v_g), 0.0);
    }

    #[test]
    fn production_is_clamped_in_one_mode_only() {
        for (x3, free, clamped) in [(0.0, 2.0, 2.0), (0.5, 1.0, 1.0), (1.5, -1.0, 0.0)] {
            assert_eq!(endogenous_production(x3, 2.0, EgpMode::Reproduction), free);
            assert_eq!(endogenous_production(x3, 2.0, EgpMode::NonNegative), clamped);
        }
        for mode in [EgpMode::Reproduction, EgpMode::NonNegative] {
            assert!(endogenous_production(f64::NAN, 2.0, mode).is_nan(), "nothing is replaced");
        }
    }

    #[test]
    fn an_infusion_is_a_rate_per_body_weight() {
        assert_eq!(infusion(3.0, 50.0), 1.0); // 3000 mU / 60 min / 50 kg
    }
}
