//! The basal rate and the state that hold a glucose concentration.

use ode_sim::OdeError;
use physiology::{MgPerDl, UnitsPerHour};

use super::equations::{PadovaCompartments, Prepared, brain_uptake, excretion, production, uptake};
use super::parameters::PadovaParameters;
use crate::body::{balancing_insulin, falling, require_possible};

/// Insulin of one unit, pmol.
pub(crate) const PMOL_PER_UNIT: f64 = 6000.0;
/// Highest plasma insulin that is considered, pmol/L.
const MOST_INSULIN: f64 = 4000.0;
/// Largest net glucose flux of a state that counts as steady, mg/kg/min.
const TOLERANCE: f64 = 1e-9;

/// The steady state at a glucose concentration, with its basal rate.
///
/// Production falls and uptake rises with insulin, so bisection finds the plasma insulin that
/// balances them. Everything else follows from it in closed form.
///
/// # Errors
/// [`OdeError::Argument`] for an impossible glucose, [`OdeError::NoBasal`] where uptake exceeds
/// production without insulin, and [`OdeError::SteadyState`] where 4,000 pmol/L do not hold it.
pub(super) fn at_glucose(
    body: &Prepared,
    glucose: MgPerDl,
) -> Result<(PadovaCompartments, UnitsPerHour), OdeError> {
    let p = &body.p;
    require_possible(glucose, &p.named())?;
    let surplus = |insulin: f64| net(body, glucose.0, insulin).0;
    let insulin = balancing_insulin(glucose, surplus, MOST_INSULIN)?;
    let (residual, g_t) = net(body, glucose.0, insulin);
    if residual.abs() > TOLERANCE {
        return Err(OdeError::SteadyState { glucose: glucose.0, residual, iterations: 80 });
    }
    Ok(held_by(p, glucose.0, insulin, g_t))
}

/// Net glucose flux (mg/kg/min) with plasma insulin held at `insulin`, and the G_t that goes with
/// it.
fn net(body: &Prepared, glucose: f64, insulin: f64) -> (f64, f64) {
    let p = &body.p;
    let g_p = glucose * p.v_g;
    let x = insulin - p.i_b;
    // k_1 G_p - k_2 G_t = U_id(G_t) rises in G_t on the right and falls on the left.
    let inflow = |g_t: f64| p.k_1 * g_p - p.k_2 * g_t;
    let g_t = falling(|g_t| inflow(g_t) - uptake(body, glucose, g_t, x, 1.0), p.k_1 * g_p / p.k_2);
    let flux = production(body, g_p, insulin)
        - brain_uptake(p, glucose)
        - excretion(p.k_e1, p.k_e2, g_p)
        - p.k_1 * g_p
        + p.k_2 * g_t;
    (flux, g_t)
}

/// The state of a plasma insulin and its infusion as a rate.
fn held_by(
    p: &PadovaParameters,
    glucose: f64,
    insulin: f64,
    g_t: f64,
) -> (PadovaCompartments, UnitsPerHour) {
    let i_p = insulin * p.v_i;
    let i_l = p.m_2 * i_p / (p.m_1 + p.m_3);
    let infusion = (p.m_2 + p.m_4) * i_p - p.m_1 * i_l; // what is absorbed is what is infused
    let i_sc1 = infusion / (p.k_a1 + p.k_d);
    let state = PadovaCompartments {
        g_p: glucose * p.v_g,
        g_t,
        i_p,
        i_l,
        i_1: insulin,
        x_l: insulin,
        x: insulin - p.i_b,
        i_sc1,
        i_sc2: p.k_d * i_sc1 / p.k_a2,
        ..PadovaCompartments::default()
    };
    (state, UnitsPerHour(infusion * p.weight.0 * 60.0 / PMOL_PER_UNIT))
}
