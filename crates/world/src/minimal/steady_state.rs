//! The basal rate and the state that hold a glucose concentration.

use ode_sim::OdeError;
use physiology::{MgPerDl, UnitsPerHour};

use super::equations::{MinimalCompartments, disposal, excretion, production};
use super::parameters::MinimalParameters;
use crate::body::{balancing_insulin, require_possible};

/// Highest plasma insulin that is considered, mU/L.
const MOST_INSULIN: f64 = 600.0;

/// The steady state at a glucose concentration, with its basal rate.
///
/// Production falls and disposal rises with insulin, so bisection finds the plasma insulin that
/// balances them. Everything else follows from it in closed form.
///
/// # Errors
/// [`OdeError::Argument`] for an impossible glucose, [`OdeError::Parameter`] for a parameter that
/// is not positive, [`OdeError::NoBasal`] where disposal exceeds production without insulin, and
/// [`OdeError::SteadyState`] where neither 600 mU/L nor the largest possible absorption holds it.
pub(super) fn at_glucose(
    p: &MinimalParameters,
    glucose: MgPerDl,
) -> Result<(MinimalCompartments, UnitsPerHour), OdeError> {
    require_possible(glucose, &p.named())?;
    let surplus = |insulin: f64| {
        production(p, p.s_l * insulin)
            - disposal(p, glucose.0, p.s_i * insulin, 1.0)
            - excretion(p.k_r, p.g_r, glucose.0)
    };
    let insulin = balancing_insulin(glucose, surplus, MOST_INSULIN)?;
    // U/min: clearance equals absorption.
    let infusion = p.clearance * insulin * p.weight.0 / 1000.0;
    if infusion >= 0.9 * p.k_a * p.d_50 {
        let residual = surplus(insulin);
        return Err(OdeError::SteadyState { glucose: glucose.0, residual, iterations: 0 });
    }
    let state = MinimalCompartments {
        glucose: glucose.0,
        x: p.s_i * insulin,
        y: p.s_l * insulin,
        insulin,
        bound: infusion / p.k_h,
        free: infusion / (p.k_a - infusion / p.d_50),
        intestine: 0.0,
    };
    Ok((state, UnitsPerHour(60.0 * infusion)))
}
