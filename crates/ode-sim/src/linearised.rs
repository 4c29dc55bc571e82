//! One step of the plant together with its derivative by the state, for filters and smoothers.

use physiology::Compartment::{C1, C2};
use physiology::{STEP, StepInput};

use crate::equations::jacobian;
use crate::error::OdeError;
use crate::integrator::{Flow, Integrator, plus};
use crate::plant::OdePlant;
use crate::state::{OdeMatrix, OdeState, OdeVector};

/// Substeps whose derivative stands in for that of the adaptive integrator, which has none of its
/// own (its step sequence jumps). At X1 = 0.3/min, the fastest that large boluses bring about, four
/// substeps are 1e-3 off and sixteen 1e-5.
const SUBSTEPS_FOR_ADAPTIVE: u32 = 16;

impl OdePlant {
    /// The state one step later and the matrix d(state after)/d(state before) over the ten
    /// compartments, unitless in matching units.
    ///
    /// For [`Integrator::ForwardEuler`] and [`Integrator::RungeKutta4`] the matrix is the exact
    /// derivative of the discrete step; for [`Integrator::Adaptive`] that of an RK4 step fine
    /// enough. Rescue carbohydrate and exercise memory are treated as known.
    ///
    /// # Errors
    /// As [`advance`](OdePlant::advance).
    pub fn linearised(
        &self,
        state: &OdeState,
        input: &StepInput,
        glucose_flux: f64,
    ) -> Result<(OdeState, OdeMatrix), OdeError> {
        let following = self.advance(state, input, glucose_flux)?;
        let fed = self.fed(state, input);
        let flow = self.flow(&fed, input, glucose_flux);
        let x = fed.vector();
        let transition = match self.integrator {
            Integrator::ForwardEuler => with_exact_gut(
                &flow,
                STEP.0,
                OdeMatrix::identity().plus_scaled(STEP.0, &slope_of(&flow, 0.0, &x)),
            ),
            Integrator::RungeKutta4 { substeps } => runge_kutta_4(&flow, x, substeps.max(1)),
            Integrator::Adaptive { .. } => runge_kutta_4(&flow, x, SUBSTEPS_FOR_ADAPTIVE),
        };
        Ok((following, transition))
    }
}

fn slope_of(flow: &Flow<'_>, time: f64, x: &OdeVector) -> OdeMatrix {
    jacobian(flow.parameters, &flow.with_gut(time, *x), &flow.forcing(time), flow.egp)
}

/// `m` with the gut rows of the exact flow after `time` min.
fn with_exact_gut(flow: &Flow<'_>, time: f64, mut m: OdeMatrix) -> OdeMatrix {
    let t_max = flow.parameters.t_max_g;
    let left = (-time / t_max).exp();
    m[(C1, C1)] = left;
    m[(C2, C1)] = left * time / t_max;
    m[(C2, C2)] = left;
    m
}

/// The variational equation dM/dt = J(x(t)) M by the same method as the state.
fn runge_kutta_4(flow: &Flow<'_>, mut x: OdeVector, substeps: u32) -> OdeMatrix {
    let h = STEP.0 / f64::from(substeps);
    let mut m = OdeMatrix::identity();
    for substep in 0..substeps {
        let t = f64::from(substep) * h;
        let stage = |time: f64, x: &OdeVector, m: OdeMatrix| {
            slope_of(flow, time, x).times(&with_exact_gut(flow, time, m))
        };
        let k1 = flow.slope(t, x);
        let m1 = stage(t, &x, m);
        let x2 = plus(x, 0.5 * h, &k1);
        let k2 = flow.slope(t + 0.5 * h, x2);
        let m2 = stage(t + 0.5 * h, &x2, m.plus_scaled(0.5 * h, &m1));
        let x3 = plus(x, 0.5 * h, &k2);
        let k3 = flow.slope(t + 0.5 * h, x3);
        let m3 = stage(t + 0.5 * h, &x3, m.plus_scaled(0.5 * h, &m2));
        let x4 = plus(x, h, &k3);
        let k4 = flow.slope(t + h, x4);
        let m4 = stage(t + h, &x4, m.plus_scaled(h, &m3));
        for n in 0..x.0.len() {
            x.0[n] += h / 6.0 * (k1.0[n] + 2.0 * k2.0[n] + 2.0 * k3.0[n] + k4.0[n]);
        }
        m = m
            .plus_scaled(h / 6.0, &m1)
            .plus_scaled(h / 3.0, &m2)
            .plus_scaled(h / 3.0, &m3)
            .plus_scaled(h / 6.0, &m4);
    }
    with_exact_gut(flow, STEP.0, m)
}
