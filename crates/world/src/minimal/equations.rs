//! The equations of the minimal body, term by term.
//!
//! Pure functions on bare `f64`; glucose in mg/dL and mg/kg/min, insulin in U, U/min and mU/L, time
//! in min.

use physiology::GRAMS_PER_MMOL_GLUCOSE;

use super::parameters::MinimalParameters;
use crate::body::compartments;
use crate::effects::Condition;

/// Scale of glucose below which the zero-order uptake vanishes, mg/dL.
const SCARCE: f64 = 20.0;
/// Width over which the kidneys begin to lose glucose, mg/dL (splay).
const SPLAY: f64 = 15.0;
/// Milliunits of one unit.
const MILLI: f64 = 1000.0;

/// Mass of one millimole of glucose, mg.
pub(super) const MG_PER_MMOL: f64 = 1000.0 * GRAMS_PER_MMOL_GLUCOSE;

compartments! {
    /// The seven compartments, and their rates of change.
    MinimalCompartments {
        /// Glucose G, mg/dL.
        glucose: Q1,
        /// Remote insulin X, the clearance of glucose that it causes, 1/min.
        x: X2,
        /// Remote insulin of the liver Y, the fall of production as a logarithm, unitless.
        y: X3,
        /// Insulin in plasma I, mU/L.
        insulin: I,
        /// Insulin under the skin that is not yet monomeric, U.
        bound: S1,
        /// Insulin under the skin that can be absorbed, U.
        free: S2,
        /// Carbohydrate in the intestine, mg.
        intestine: C2,
    }
}

/// What acts on the compartments through one step. All factors are 1 in the body as drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Forcing {
    /// Circumstances, with what exercise does to them.
    pub(super) condition: Condition,
    /// Insulin that arrives under the skin, U/min.
    pub(super) insulin: f64,
    /// Carbohydrate that leaves the stomach, mg/min.
    pub(super) emptied: f64,
    /// Glucose that working muscle takes up, mg/kg/min.
    pub(super) work: f64,
}

/// Endogenous production, mg/kg/min: P_0 exp(-Y).
#[must_use]
pub(super) fn production(p: &MinimalParameters, y: f64) -> f64 {
    p.p_0 * (-y).exp()
}

/// Disposal, mg/kg/min: u (R_d0 (1 - exp(-G/20)) + k_g V_G G) + X V_G G with a factor `u`.
#[must_use]
pub(super) fn disposal(p: &MinimalParameters, glucose: f64, x: f64, factor: f64) -> f64 {
    let without = p.r_d0 * (1.0 - (-glucose / SCARCE).exp()) + p.k_g * p.v_g * glucose;
    factor * without + x * p.v_g * glucose
}

/// Renal excretion, mg/kg/min: k_r 15 ln(1 + exp((G - G_r)/15)).
#[must_use]
pub(super) fn excretion(k_r: f64, threshold: f64, glucose: f64) -> f64 {
    let above = (glucose - threshold) / SPLAY;
    k_r * SPLAY * if above > 30.0 { above } else { above.exp().ln_1p() }
}

/// Insulin absorbed into plasma, U/min: k_a D/(1 + D/D_50).
#[must_use]
pub(super) fn absorbed(p: &MinimalParameters, free: f64) -> f64 {
    p.k_a * free / (1.0 + free.max(0.0) / p.d_50)
}

/// Rate of change of the compartments, per minute.
#[must_use]
pub(super) fn derivative(
    p: &MinimalParameters,
    s: &MinimalCompartments,
    forcing: &Forcing,
) -> MinimalCompartments {
    let c = &forcing.condition;
    let depot = 1.0 / c.insulin_time;
    let (loosened, taken) = (depot * p.k_h * s.bound, depot * absorbed(p, s.free));
    let appearing = p.k_abs / c.gut_time * s.intestine;
    let renal = excretion(p.k_r * c.renal_slope, p.g_r * c.renal_threshold, s.glucose);
    // Work takes less at low glucose.
    let work = forcing.work * (s.glucose / 80.0).min(1.0);
    let net = c.production * production(p, s.y)
        + p.f * appearing / p.weight.0
        + c.glucose_flux * MG_PER_MMOL
        - disposal(p, s.glucose, s.x, c.uptake)
        - renal
        - work;
    MinimalCompartments {
        glucose: net / p.v_g,
        x: -p.p_2 * (s.x - c.action * p.s_i * s.insulin),
        y: -p.p_l * (s.y - c.liver_action * p.s_l * s.insulin),
        insulin: (MILLI * taken / p.weight.0 - p.clearance * s.insulin) / p.v_i,
        bound: forcing.insulin - loosened,
        free: loosened - taken,
        intestine: forcing.emptied - appearing,
    }
}
