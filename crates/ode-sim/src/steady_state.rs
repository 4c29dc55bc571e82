//! The basal rate and the state that hold a glucose concentration for ever.

use faer::linalg::solvers::{PartialPivLu, Solve};
use faer::{Col, Mat};
use physiology::Compartment::{I, Q1, Q2, S1, S2, X1, X2, X3};
use physiology::{Compartment, Kilograms, MgPerDl, MmolPerL, UnitsPerHour};

use crate::equations::{EgpMode, Forcing, derivative, jacobian};
use crate::error::{OdeError, positive};
use crate::parameters::OdeParameters;
use crate::state::{OdeState, OdeVector, slot};

/// Largest absolute derivative that counts as standing still, per minute in each state's unit.
pub const RESIDUAL_TOLERANCE: f64 = 1e-10;
/// Newton steps after which the search is given up; from the start used here five are enough.
const MAX_ITERATIONS: usize = 50;

/// A steady state without meals, snacks and exercise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SteadyState {
    /// The state.
    pub state: OdeState,
    /// The basal rate that holds it.
    pub basal: UnitsPerHour,
    /// Largest absolute derivative, per minute in each state's unit.
    pub residual: f64,
    /// Newton iterations made.
    pub iterations: usize,
}

/// The seven unknown states; the eighth unknown is the infusion. Glucose is given.
const UNKNOWN: [Compartment; 7] = [S1, S2, I, X1, X2, X3, Q2];
/// The eight equations.
const EQUATIONS: [Compartment; 8] = [S1, S2, I, X1, X2, X3, Q1, Q2];

/// The steady state at a target glucose: eight equations (Eqs. 1a to 1h set to zero) in basal and
/// seven states, by Newton's method with the analytic Jacobian.
///
/// Production is positive at any steady state, so the answer is the same in both
/// [`EgpMode`]s.
///
/// # Errors
/// [`OdeError::Parameter`] or [`OdeError::Argument`] for values that cannot be,
/// [`OdeError::NoBasal`] where glucose would stay below the target even without insulin, and
/// [`OdeError::SteadyState`] if Newton's method does not reach [`RESIDUAL_TOLERANCE`].
///
/// ```
/// use ode_sim::{OdeParameters, steady_state};
/// use physiology::{Kilograms, MgPerDl};
///
/// let nominal = OdeParameters::nominal();
/// let found = steady_state::at_glucose(&nominal, Kilograms(76.3), MgPerDl(115.0))?;
/// assert!(found.residual < 1e-10);
/// assert!((0.5..1.5).contains(&found.basal.0));
/// # Ok::<(), ode_sim::OdeError>(())
/// ```
pub fn at_glucose(
    parameters: &OdeParameters,
    weight: Kilograms,
    glucose: MgPerDl,
) -> Result<SteadyState, OdeError> {
    let p = parameters.validated()?;
    positive("weight", weight.0)?;
    positive("glucose", glucose.0)?;
    let q1 = MmolPerL::from(glucose).0 * p.v_g;
    let without_insulin = derivative(&p, &held_by(&p, q1, 0.0), &Forcing::default(), MODE)[Q1];
    if without_insulin < 0.0 {
        return Err(OdeError::NoBasal { glucose: glucose.0 });
    }

    // Glucose falls steadily with infusion and starts above balance, so Newton's method from zero
    // infusion moves towards the root; a step that would make the residual worse is halved.
    let mut infusion = 0.0;
    let mut x = held_by(&p, q1, infusion);
    let mut residual = largest(&p, &x, infusion);
    for iterations in 0..=MAX_ITERATIONS {
        // Two digits to spare, so that the answer stands when it is evaluated elsewhere.
        if residual < 0.01 * RESIDUAL_TOLERANCE {
            let basal = UnitsPerHour(infusion * weight.0 * 60.0 / 1000.0);
            let state = OdeState::default().with_vector(&x);
            return Ok(SteadyState { state, basal, residual, iterations });
        }
        let step = newton_step(&p, &x, infusion);
        let mut length = 1.0;
        loop {
            let (trial_x, trial_infusion) = moved(&x, infusion, &step, length);
            let trial = largest(&p, &trial_x, trial_infusion);
            if trial < residual || length < 1e-6 {
                (x, infusion, residual) = (trial_x, trial_infusion, trial);
                break;
            }
            length *= 0.5;
        }
        if !residual.is_finite() {
            break;
        }
    }
    Err(OdeError::SteadyState { glucose: glucose.0, residual, iterations: MAX_ITERATIONS })
}

/// The state of [`at_glucose`] alone, some hundred times faster: at a given infusion seven equations
/// have a solution in closed form, and what is left is the root of a falling function of one
/// unknown. Good to about 1e-12 of the infusion.
///
/// # Errors
/// [`OdeError::NoBasal`] where glucose would stay below the target even without insulin;
/// [`OdeError::SteadyState`] if no infusion lowers it. Parameters are not checked.
pub fn state_at_glucose(p: &OdeParameters, glucose: MgPerDl) -> Result<OdeState, OdeError> {
    let q1 = MmolPerL::from(glucose).0 * p.v_g;
    let balance = |infusion: f64| {
        let x = held_by(p, q1, infusion);
        derivative(p, &x, &forcing(infusion), MODE)[Q1]
    };
    let (mut low, mut high) = (0.0, 0.1);
    let mut at_low: f64 = balance(low);
    if at_low < 0.0 {
        return Err(OdeError::NoBasal { glucose: glucose.0 });
    }
    let mut at_high = balance(high);
    while at_high > 0.0 && high < HIGHEST_INFUSION {
        (low, at_low) = (high, at_high);
        high *= 4.0;
        at_high = balance(high);
    }
    if at_high > 0.0 || at_high.is_nan() {
        let (residual, iterations) = (at_high.abs(), 0);
        return Err(OdeError::SteadyState { glucose: glucose.0, residual, iterations });
    }
    // False position with the Illinois rule: an end that stays twice loses half its weight.
    let mut moved_low = None;
    for _ in 0..MAX_ITERATIONS {
        if high - low <= 1e-12 * high || at_low == 0.0 {
            break;
        }
        let trial = (low * at_high - high * at_low) / (at_high - at_low);
        let at_trial = balance(trial);
        let moves_low = at_trial > 0.0;
        if moves_low {
            (low, at_low) = (trial, at_trial);
            at_high *= if moved_low == Some(true) { 0.5 } else { 1.0 };
        } else {
            (high, at_high) = (trial, at_trial);
            at_low *= if moved_low == Some(false) { 0.5 } else { 1.0 };
        }
        if at_trial == 0.0 {
            break;
        }
        moved_low = Some(moves_low);
    }
    let infusion = if at_low == 0.0 { low } else { high };
    Ok(OdeState::default().with_vector(&held_by(p, q1, infusion)))
}

/// Beyond this infusion, mU/kg/min, no body is looked at: a thousand times a usual basal rate.
const HIGHEST_INFUSION: f64 = 200.0;

/// See [`at_glucose`]: either mode gives the same answer; this one has no kink.
const MODE: EgpMode = EgpMode::Reproduction;

/// The states that an `infusion`, mU/kg/min, holds if `q1`, mmol/kg, is held as well; the gut is empty.
///
/// Insulin, its effects and Q2 are those at which Eqs. (1a) to (1f) and (1h) are zero. Parameters are not checked.
#[must_use]
pub fn held_by(p: &OdeParameters, q1: f64, infusion: f64) -> OdeVector {
    let mut x = OdeVector::default();
    x[S1] = infusion * p.t_max_i;
    x[S2] = x[S1];
    x[I] = infusion / (p.v_i * p.k_e);
    x[X1] = p.s_f1 * x[I];
    x[X2] = p.s_f2 * x[I];
    x[X3] = p.s_f3 * x[I];
    x[Q1] = q1;
    x[Q2] = x[X1] * q1 / (p.k_12 + x[X2]);
    x
}

fn forcing(infusion: f64) -> Forcing {
    Forcing { insulin: infusion, ..Forcing::default() }
}

fn largest(p: &OdeParameters, x: &OdeVector, infusion: f64) -> f64 {
    let dx = derivative(p, x, &forcing(infusion), MODE);
    EQUATIONS
        .iter()
        .fold(0.0, |max, c| if dx[*c].is_nan() { f64::NAN } else { dx[*c].abs().max(max) })
}

/// Solves J step = -f; the last entry is the change of the infusion.
fn newton_step(p: &OdeParameters, x: &OdeVector, infusion: f64) -> Col<f64> {
    let dx = derivative(p, x, &forcing(infusion), MODE);
    let slopes = jacobian(p, x, &forcing(infusion), MODE);
    let matrix = Mat::from_fn(8, 8, |row, column| match UNKNOWN.get(column) {
        Some(unknown) => slopes[(EQUATIONS[row], *unknown)],
        // The infusion enters dS1/dt alone, with slope 1 (Eq. 1a).
        None => f64::from(u8::from(EQUATIONS[row] == S1)),
    });
    let right = Col::from_fn(8, |row| -dx.0[slot(EQUATIONS[row])]);
    PartialPivLu::new(matrix.as_ref()).solve(right)
}

fn moved(x: &OdeVector, infusion: f64, step: &Col<f64>, length: f64) -> (OdeVector, f64) {
    let mut trial = *x;
    for (n, compartment) in UNKNOWN.into_iter().enumerate() {
        trial[compartment] += length * step[n];
    }
    (trial, infusion + length * step[UNKNOWN.len()])
}
