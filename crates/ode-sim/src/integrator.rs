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
use crate::error::{OdeError, positive};
use crate::gut::{GutPair, RESCUE_T_MAX};
use crate::parameters::OdeParameters;
use crate::state::OdeVector;

/// Numerical method for one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Integrator {
    /// One forward Euler step of 5 min: reproduces the authors' simulator and is the scheme of the
    /// network (paper, Eq. of the individual model).
    ///
    /// Unstable where a rate exceeds 0.4/min, which X1 does under very large doses.
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
    /// What is held through the step: all but rescue carbohydrate.
    pub(crate) held: Forcing,
    pub(crate) meals: GutPair,
    pub(crate) rescue: GutPair,
}

impl Flow<'_> {
    /// The forcing `time` min into the step.
    #[inline]
    pub(crate) fn forcing(&self, time: f64) -> Forcing {
        let rescue = self.rescue.after(time, RESCUE_T_MAX.0).appearance(RESCUE_T_MAX.0);
        Forcing { glucose_flux: self.held.glucose_flux + rescue, ..self.held }
    }

    /// `x` with the gut entries as they are `time` min into the step.
    #[inline]
    pub(crate) fn with_gut(&self, time: f64, mut x: OdeVector) -> OdeVector {
        let gut = self.meals.after(time, self.parameters.t_max_g);
        x[C1] = gut.c1;
        x[C2] = gut.c2;
        x
    }

    #[inline]
    pub(crate) fn slope(&self, time: f64, x: OdeVector) -> OdeVector {
        derivative(self.parameters, &self.with_gut(time, x), &self.forcing(time), self.egp)
    }
}

impl Integrator {
    /// Carries `x` through `duration` min of `flow`; the gut entries of the result are exact.
    #[inline]
    pub(crate) fn advance(
        self,
        flow: &Flow<'_>,
        x: OdeVector,
        duration: f64,
    ) -> Result<OdeVector, OdeError> {
        let end = match self {
            Self::ForwardEuler => plus(x, duration, &flow.slope(0.0, x)),
            Self::RungeKutta4 { substeps } => runge_kutta_4(flow, x, duration, substeps.max(1)),
            Self::Adaptive { rtol, atol } => dormand_prince(flow, x, duration, rtol, atol)?,
        };
        Ok(flow.with_gut(duration, end))
    }
}

/// `x + h * slope`, entry by entry.
#[inline]
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
) -> Result<OdeVector, OdeError> {
    positive("rtol", rtol)?;
    positive("atol", atol)?;
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
    solver.integrate().map_err(|error| OdeError::Integration {
        rtol,
        atol,
        reason: error.to_string(),
    })?;
    Ok(solver.y_out().last().map_or(x, widen))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::steady_state;
    use physiology::{Kilograms, MgPerDl};

    /// The end of 40 min after a meal, a snack and a bolus, in steps of `h` min.
    ///
    /// Glucose stays between the kinks at 4.5 and 9 mmol/L, where the equations are smooth.
    fn end(integrator: Integrator, h: f64) -> OdeVector {
        let p = OdeParameters::nominal();
        let start = steady_state::at_glucose(&p, Kilograms(76.3), MgPerDl(100.0)).expect("steady");
        let mut x = start.state.vector();
        x[C1] = 1.2;
        let mut rescue = GutPair::default().fed(0.5);
        for step in 0..(40.0 / h) as u32 {
            let insulin = if f64::from(step) * h < 20.0 { 2.0 } else { 0.2 };
            let flow = Flow {
                parameters: &p,
                egp: EgpMode::Reproduction,
                held: Forcing { insulin, glucose_flux: 0.001, ..Forcing::default() },
                meals: GutPair { c1: x[C1], c2: x[C2] },
                rescue,
            };
            x = integrator.advance(&flow, x, h).expect("integrates");
            rescue = rescue.after(h, RESCUE_T_MAX.0);
            let glucose = x[physiology::Compartment::Q1] / p.v_g;
            assert!((4.5..9.0).contains(&glucose), "the case is smooth: {glucose} mmol/L");
        }
        x
    }

    /// Largest difference of the eight states, each over its size.
    fn distance(a: &OdeVector, b: &OdeVector) -> f64 {
        let pairs = a.0.iter().zip(&b.0).take(8);
        pairs.fold(0.0, |max, (a, b)| ((a - b) / b).abs().max(max))
    }

    fn exact() -> OdeVector {
        end(Integrator::RungeKutta4 { substeps: 64 }, 5.0)
    }

    #[test]
    fn euler_is_of_first_order() {
        let exact = exact();
        let error = |h| distance(&end(Integrator::ForwardEuler, h), &exact);
        for h in [0.25, 0.125, 0.0625] {
            let order = (error(h) / error(h / 2.0)).log2();
            assert!((order - 1.0).abs() < 0.2, "order {order} at {h} min");
        }
    }

    #[test]
    fn runge_kutta_is_of_fourth_order() {
        let exact = exact();
        let error = |substeps| distance(&end(Integrator::RungeKutta4 { substeps }, 5.0), &exact);
        // From 1.25 min, below which the leading term rules, to 0.3 min; finer steps come near
        // the rounding of the reference.
        for substeps in [4, 8] {
            let order = (error(substeps) / error(2 * substeps)).log2();
            assert!((order - 4.0).abs() < 0.2, "order {order} at {substeps} substeps");
        }
    }

    #[test]
    fn dormand_prince_keeps_its_tolerance() {
        let exact = exact();
        for rtol in [1e-4, 1e-6, 1e-8, 1e-10] {
            let adaptive = Integrator::Adaptive { rtol, atol: 1e-3 * rtol };
            let error = distance(&end(adaptive, 5.0), &exact);
            // Eight steps, each within the tolerance.
            assert!(error < 8.0 * rtol, "error {error} at rtol {rtol}");
        }
    }

    #[test]
    fn no_substeps_count_as_one() {
        let one = end(Integrator::RungeKutta4 { substeps: 1 }, 5.0);
        assert_eq!(end(Integrator::RungeKutta4 { substeps: 0 }, 5.0), one);
    }

    #[test]
    fn the_adaptive_method_refuses_what_cannot_be() {
        let p = OdeParameters::nominal();
        let flow = Flow {
            parameters: &p,
            egp: EgpMode::Reproduction,
            held: Forcing { insulin: f64::NAN, ..Forcing::default() },
            meals: GutPair::default(),
            rescue: GutPair::default(),
        };
        let x = OdeVector::default();
        let adaptive = |rtol, atol| Integrator::Adaptive { rtol, atol };
        let error = adaptive(1e-6, 1e-9).advance(&flow, x, 5.0).expect_err("not a number");
        assert_eq!(error, OdeError::NonFinite { compartment: physiology::Compartment::S1 });
        let error = adaptive(0.0, 1e-9).advance(&flow, x, 5.0).expect_err("no tolerance");
        assert!(matches!(error, OdeError::Argument { name: "rtol", .. }));
        let held = Forcing { insulin: 1.0, ..Forcing::default() };
        let finite = Flow { held, ..flow };
        let error = adaptive(1e-300, 1e-300).advance(&finite, x, 5.0).expect_err("out of reach");
        assert!(matches!(error, OdeError::Integration { .. }));
    }
}
