//! The basal rate and the state that hold a glucose concentration.

use ode_sim::OdeError;
use physiology::{MgPerDl, UnitsPerHour};

#[cfg(test)]
use super::equations::{Forcing, derivative};
use super::equations::{disposal, excretion, production};
use super::parameters::MinimalParameters;
use super::state::MinimalState;

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
) -> Result<(MinimalState, UnitsPerHour), OdeError> {
    if !(glucose.0.is_finite() && glucose.0 > 0.0) {
        let requirement = "positive and finite";
        return Err(OdeError::Argument { name: "glucose", value: glucose.0, requirement });
    }
    let wrong = p.named().into_iter().find(|(_, value)| !(value.is_finite() && *value > 0.0));
    if let Some((name, value)) = wrong {
        return Err(OdeError::Parameter { name, value });
    }
    let surplus = |insulin: f64| {
        production(p, p.s_l * insulin)
            - disposal(p, glucose.0, p.s_i * insulin, 1.0)
            - excretion(p.k_r, p.g_r, glucose.0)
    };
    if surplus(0.0) < 0.0 {
        return Err(OdeError::NoBasal { glucose: glucose.0 });
    }
    let unheld =
        |residual: f64| OdeError::SteadyState { glucose: glucose.0, residual, iterations: 0 };
    if surplus(MOST_INSULIN) > 0.0 {
        return Err(unheld(surplus(MOST_INSULIN)));
    }
    let (mut low, mut high) = (0.0, MOST_INSULIN);
    // After some sixty halvings the interval reaches the spacing of the numbers.
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if surplus(middle) > 0.0 { low = middle } else { high = middle }
    }
    // U/min: clearance equals absorption.
    let infusion = p.clearance * high * p.weight.0 / 1000.0;
    if infusion >= 0.9 * p.k_a * p.d_50 {
        return Err(unheld(surplus(high)));
    }
    let state = MinimalState {
        glucose: glucose.0,
        x: p.s_i * high,
        y: p.s_l * high,
        insulin: high,
        bound: infusion / p.k_h,
        free: infusion / (p.k_a - infusion / p.d_50),
        intestine: 0.0,
    };
    Ok((state, UnitsPerHour(60.0 * infusion)))
}

/// Largest absolute derivative of a state under an infusion, per minute in each state's unit.
#[cfg(test)]
pub(super) fn residual(p: &MinimalParameters, state: &MinimalState, basal: UnitsPerHour) -> f64 {
    let slope = derivative(p, state, &Forcing { insulin: basal.0 / 60.0, ..Forcing::NONE });
    slope.entries().iter().fold(0.0_f64, |largest, (_, rate)| largest.max(rate.abs()))
}
