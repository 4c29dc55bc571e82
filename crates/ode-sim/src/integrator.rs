//! How the plant is carried over one step: forward Euler, classical Runge-Kutta, Dormand-Prince.
//!
//! Doses and meals act at step boundaries, so every integrator starts afresh there and none steps
//! across a jump. The gut is advanced exactly by [`GutPair`], and each stage reads it at its own
//! time; Euler on the other eight states therefore is the authors' scheme, whose U_G is the closed
//! form.

use ode_solvers::dop_shared::OutputType;
use ode_solvers::{Dopri5, SVector, System};
use physiology::Compartment::{C1, C2};

use crate::equations::{EgpMode, Forcing, derivative};
use crate::error::OdeError;
use crate::exercise::Multipliers;
use crate::gut::{GutPair, RESCUE_T_MAX};
use crate::parameters::OdeParameters;
use crate::state::OdeVector;

/// Numerical method for one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Integrator {
    /// One forward Euler step of 5 min: reproduces the authors' simulator and is the scheme of the
    /// network (paper, Eq. of the individual model).
    ForwardEuler,
    /// The classical fourth-order Runge-Kutta method.
    RungeKutta4 {
        /// Equal substeps within a step of 5 min; 0 counts as 1.
        substeps: u32,
    },
    /// Dormand-Prince 5(4) with step control, through the `ode_solvers` crate.
    Adaptive {
        /// Relative tolerance, positive.
        rtol: f64,
        /// Absolute tolerance in each state's own unit, positive.
        atol: f64,
    },
}

/// The forces of one step, with the gut at its start.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Flow<'a> {
    pub(crate) parameters: &'a OdeParameters,
    pub(crate) egp: EgpMode,
    pub(crate) insulin: f64,
    pub(crate) glucose_flux: f64,
    pub(crate) exercise: Multipliers,
    pub(crate) meals: GutPair,
    pub(crate) rescue: GutPair,
}

impl Flow<'_> {
    /// The forcing `time` min into the step.
    pub(crate) fn forcing(&self, time: f64) -> Forcing {
        let rescue = self.rescue.after(time, RESCUE_T_MAX.0).appearance(RESCUE_T_MAX.0);
        Forcing {
            insulin: self.insulin,
            glucose_flux: self.glucose_flux + rescue,
            exercise: self.exercise,
        }
    }

    /// `x` with the gut entries as they are `time` min into the step.
    pub(crate) fn with_gut(&self, time: f64, mut x: OdeVector) -> OdeVector {
        let gut = self.meals.after(time, self.parameters.t_max_g);
        x[C1] = gut.c1;
        x[C2] = gut.c2;
        x
    }

    fn slope(&self, time: f64, x: OdeVector) -> OdeVector {
        derivative(self.parameters, &self.with_gut(time, x), &self.forcing(time), self.egp)
    }
}

impl Integrator {
    /// Carries `x` through `duration` min of `flow`; the gut entries of the result are exact.
    ///
    /// Returns the number of evaluations of the derivative beside the state.
    pub(crate) fn advance(
        self,
        flow: &Flow<'_>,
        x: OdeVector,
        duration: f64,
    ) -> Result<(OdeVector, u32), OdeError> {
        let (end, evaluations) = match self {
            Self::ForwardEuler => (plus(x, duration, &flow.slope(0.0, x)), 1),
            Self::RungeKutta4 { substeps } => {
                let substeps = substeps.max(1);
                (runge_kutta_4(flow, x, duration, substeps), 4 * substeps)
            }
            Self::Adaptive { rtol, atol } => dormand_prince(flow, x, duration, rtol, atol)?,
        };
        Ok((flow.with_gut(duration, end), evaluations))
    }
}

/// `x + h * slope`, entry by entry.
pub(crate) fn plus(mut x: OdeVector, h: f64, slope: &OdeVector) -> OdeVector {
    for (value, rate) in x.0.iter_mut().zip(&slope.0) {
        *value += h * rate;
    }
    x
}

fn runge_kutta_4(flow: &Flow<'_>, mut x: OdeVector, duration: f64, substeps: u32) -> OdeVector {
    let h = duration / f64::from(substeps);
    for substep in 0..substeps {
        let t = f64::from(substep) * h;
        let k1 = flow.slope(t, x);
        let k2 = flow.slope(t + 0.5 * h, plus(x, 0.5 * h, &k1));
        let k3 = flow.slope(t + 0.5 * h, plus(x, 0.5 * h, &k2));
        let k4 = flow.slope(t + h, plus(x, h, &k3));
        for n in 0..x.0.len() {
            x.0[n] += h / 6.0 * (k1.0[n] + 2.0 * k2.0[n] + 2.0 * k3.0[n] + k4.0[n]);
        }
    }
    x
}

/// The eight states that are integrated; the gut is known.
type Eight = SVector<f64, 8>;

struct EightStates<'a>(&'a Flow<'a>);

impl System<f64, Eight> for EightStates<'_> {
    fn system(&self, time: f64, y: &Eight, dy: &mut Eight) {
        let slope = self.0.slope(time, widen(y));
        dy.copy_from_slice(&slope.0[..8]);
    }
}

fn widen(y: &Eight) -> OdeVector {
    let mut x = OdeVector::default();
    x.0[..8].copy_from_slice(y.as_slice());
    x
}

fn dormand_prince(
    flow: &Flow<'_>,
    x: OdeVector,
    duration: f64,
    rtol: f64,
    atol: f64,
) -> Result<(OdeVector, u32), OdeError> {
    for (name, value) in [("rtol", rtol), ("atol", atol)] {
        if !(value.is_finite() && value > 0.0) {
            return Err(OdeError::Argument { name, value, requirement: "positive and finite" });
        }
    }
    // The solver would spend its whole step budget on a derivative that is not a number.
    if let Some(compartment) = flow.slope(0.0, x).first_non_finite() {
        return Err(OdeError::NonFinite { compartment });
    }
    let start = Eight::from_column_slice(&x.0[..8]);
    // Safety factor, beta and the bounds on step growth are the crate's defaults; the first trial
    // is the whole step, since at ordinary tolerances one or two suffice.
    let mut solver = Dopri5::from_param(
        EightStates(flow),
        0.0,
        duration,
        duration,
        start,
        rtol,
        atol,
        0.9,
        0.04,
        0.2,
        10.0,
        duration,
        duration,
        10_000,
        1_000,
        OutputType::Sparse,
    );
    let stats = solver.integrate().map_err(|error| OdeError::Integration {
        rtol,
        atol,
        reason: error.to_string(),
    })?;
    let end = solver.y_out().last().map_or(x, widen);
    Ok((end, stats.num_eval + 1))
}
