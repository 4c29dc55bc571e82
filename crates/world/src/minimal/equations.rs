//! The equations of the minimal body, term by term.
//!
//! Pure functions on bare `f64`; glucose in mg/dL and mg/kg/min, insulin in U, U/min and mU/L, time
//! in min.

use super::parameters::MinimalParameters;
use super::state::MinimalState;

/// Scale of glucose below which the zero-order uptake vanishes, mg/dL.
const SCARCE: f64 = 20.0;
/// Width over which the kidneys begin to lose glucose, mg/dL (splay).
const SPLAY: f64 = 15.0;
/// Milliunits of one unit.
const MILLI: f64 = 1000.0;

/// What acts on the compartments through one step. All factors are 1 in the body as drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Forcing {
    /// Insulin that arrives under the skin, U/min.
    pub(super) insulin: f64,
    /// Carbohydrate that leaves the stomach, mg/min.
    pub(super) emptied: f64,
    /// Glucose that enters plasma besides meals and production, mg/kg/min.
    pub(super) glucose_flux: f64,
    /// Glucose that working muscle takes up, mg/kg/min.
    pub(super) work: f64,
    /// Factor on the uptake that needs no insulin.
    pub(super) uptake: f64,
    /// Factor on production.
    pub(super) production: f64,
    /// Factor on the insulin that acts on disposal.
    pub(super) action: f64,
    /// Factor on the insulin that acts on production.
    pub(super) liver_action: f64,
    /// Factor on the times of insulin absorption.
    pub(super) insulin_time: f64,
    /// Factor on the time of absorption from the intestine.
    pub(super) gut_time: f64,
    /// Factor on the renal threshold.
    pub(super) renal_threshold: f64,
    /// Factor on the renal clearance above it.
    pub(super) renal_slope: f64,
}

#[cfg(test)]
impl Forcing {
    /// Nothing acts on the body as drawn.
    pub(super) const NONE: Self = Self {
        insulin: 0.0,
        emptied: 0.0,
        glucose_flux: 0.0,
        work: 0.0,
        uptake: 1.0,
        production: 1.0,
        action: 1.0,
        liver_action: 1.0,
        insulin_time: 1.0,
        gut_time: 1.0,
        renal_threshold: 1.0,
        renal_slope: 1.0,
    };
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
    s: &MinimalState,
    forcing: &Forcing,
) -> MinimalState {
    let depot = 1.0 / forcing.insulin_time;
    let (loosened, taken) = (depot * p.k_h * s.bound, depot * absorbed(p, s.free));
    let appearing = p.k_abs / forcing.gut_time * s.intestine;
    let renal = excretion(p.k_r * forcing.renal_slope, p.g_r * forcing.renal_threshold, s.glucose);
    // Work takes less at low glucose.
    let work = forcing.work * (s.glucose / 80.0).min(1.0);
    let net = forcing.production * production(p, s.y)
        + p.f * appearing / p.weight.0
        + forcing.glucose_flux
        - disposal(p, s.glucose, s.x, forcing.uptake)
        - renal
        - work;
    MinimalState {
        glucose: net / p.v_g,
        x: -p.p_2 * (s.x - forcing.action * p.s_i * s.insulin),
        y: -p.p_l * (s.y - forcing.liver_action * p.s_l * s.insulin),
        insulin: (MILLI * taken / p.weight.0 - p.clearance * s.insulin) / p.v_i,
        bound: forcing.insulin - loosened,
        free: loosened - taken,
        intestine: forcing.emptied - appearing,
    }
}
