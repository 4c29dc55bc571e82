//! The basal rate and the state that hold a glucose concentration.

use ode_sim::OdeError;
use physiology::{MgPerDl, MmolPerL, UnitsPerHour};

use super::equations::{
    SaturatingCompartments, brain, excretion, glucagon_wanted, lost, production, uptake,
};
use super::parameters::SaturatingParameters;
use crate::body::{balancing_insulin, falling, require_possible};

/// Highest plasma insulin that is considered, mU/L.
const MOST_INSULIN: f64 = 600.0;
/// Highest infusion that is considered, mU/min.
const MOST_INFUSION: f64 = 20_000.0;

/// The steady state at a glucose concentration, with its basal rate.
///
/// Net glucose falls with plasma insulin, and plasma insulin rises with the infusion. So each is
/// found by bisection.
///
/// # Errors
/// [`OdeError::Argument`] for an impossible glucose, [`OdeError::Parameter`] for a parameter that
/// is not positive, [`OdeError::NoBasal`] where glucose falls even without insulin, and
/// [`OdeError::SteadyState`] where 600 mU/L do not hold it.
pub(super) fn at_glucose(
    p: &SaturatingParameters,
    glucose: MgPerDl,
) -> Result<(SaturatingCompartments, UnitsPerHour), OdeError> {
    require_possible(glucose, &p.named())?;
    let plasma = MmolPerL::from(glucose).0;
    let surplus = |insulin: f64| {
        let glucagon = glucagon_wanted(p, plasma, insulin);
        let muscle = muscle_at(p, plasma, insulin);
        production(p, insulin, glucagon)
            - brain(p, plasma)
            - excretion(p.k_r, p.g_r, plasma)
            - uptake(p, muscle, insulin, 0.0)
    };
    let insulin = balancing_insulin(glucose, surplus, MOST_INSULIN)?;
    let needed = p.k_e * insulin * p.v_ins * p.weight.0;
    let infusion = falling(|infusion| needed - absorbed(p, infusion), MOST_INFUSION);
    let (slow, fast) = depots(p, infusion);
    let state = SaturatingCompartments {
        plasma,
        muscle: muscle_at(p, plasma, insulin),
        insulin,
        at_muscle: insulin,
        at_liver: insulin,
        glucagon: glucagon_wanted(p, plasma, insulin),
        slow,
        slow_next: slow,
        fast,
        ..SaturatingCompartments::default()
    };
    Ok((state, UnitsPerHour(60.0 * infusion / 1000.0)))
}

/// Glucose around the muscle, mmol/L, at which arrival equals uptake.
fn muscle_at(p: &SaturatingParameters, plasma: f64, insulin: f64) -> f64 {
    falling(|m| p.transport * (plasma - m) - uptake(p, m, insulin, 0.0), plasma)
}

/// Insulin in the first compartments of both channels at an infusion of mU/min, mU.
fn depots(p: &SaturatingParameters, infusion: f64) -> (f64, f64) {
    let held = |rate: f64, arriving: f64| {
        falling(|amount| arriving - rate * amount - lost(p, amount), arriving / rate)
    };
    (held(p.k_a1, p.k * infusion), held(p.k_a2, (1.0 - p.k) * infusion))
}

/// Insulin that reaches plasma at an infusion of mU/min, mU/min.
fn absorbed(p: &SaturatingParameters, infusion: f64) -> f64 {
    let (slow, fast) = depots(p, infusion);
    p.k_a1 * slow + p.k_a2 * fast
}
