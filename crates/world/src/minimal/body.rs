//! The minimal body as a plant, with the effects that act on it.

use ode_sim::OdeError;
use physiology::{
    Compartment, GRAMS_PER_MMOL_GLUCOSE, MgPerDl, NonFinite, Plant, STEP, States, StepInput,
    UnitsPerHour,
};

use super::equations::{Forcing, derivative, production};
use super::exertion::WorkDone;
use super::parameters::MinimalParameters;
use super::state::MinimalState;
use super::steady_state;
use super::stomach::Stomach;
use crate::effects::{Amplitudes, Condition, Effect, LowTrace};
use crate::virtual_body::VirtualBody;
use crate::warp::{Warped, Warps};

/// Runge-Kutta steps within the five minutes: one per minute.
const SUBSTEPS: usize = 5;
/// Mass of one millimole of glucose, mg.
const MG_PER_MMOL: f64 = 1000.0 * GRAMS_PER_MMOL_GLUCOSE;
/// Half-time of fast carbohydrate in the stomach relative to that of a meal.
const FAST: f64 = 0.3;

/// A body of the minimal-model kind whose parameters change from step to step.
#[derive(Debug, Clone)]
pub struct MinimalBody<'a> {
    parameters: MinimalParameters,
    conditions: &'a [Condition],
    amplitudes: Amplitudes,
    warped: Option<Warped>,
}

/// State of a [`MinimalBody`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MinimalBodyState {
    /// The seven compartments.
    pub compartments: MinimalState,
    /// The meals in the stomach.
    pub stomach: Stomach,
    /// What past exercise still does.
    pub work: WorkDone,
    /// How far a low has activated counter-regulation.
    pub low: LowTrace,
    /// Steps done.
    pub step: usize,
}

impl<'a> MinimalBody<'a> {
    /// A body under the course of `conditions`, one per step. After their end the body is as drawn.
    #[must_use]
    pub fn new(
        parameters: MinimalParameters,
        conditions: &'a [Condition],
        amplitudes: Amplitudes,
    ) -> Self {
        Self { parameters, conditions, amplitudes, warped: None }
    }

    /// The body as drawn, without any effect or variability.
    #[must_use]
    pub fn undisturbed(parameters: MinimalParameters) -> MinimalBody<'static> {
        MinimalBody { parameters, conditions: &[], amplitudes: Amplitudes::NONE, warped: None }
    }

    /// The same body with warped functions.
    ///
    /// # Errors
    /// If it has no steady state at the glucose at which warps are 1.
    pub fn with_warps(self, warps: Warps) -> Result<Self, OdeError> {
        let warped = Warped::of(warps, &self, self.parameters.weight)?;
        Ok(Self { warped, ..self })
    }

    /// A condition with the warps at a state.
    fn warped(&self, condition: Condition, state: &MinimalBodyState) -> Condition {
        match &self.warped {
            Some(warped) => warped.act(condition, &self.report(state)),
            None => condition,
        }
    }

    /// What acts through one step, except what leaves the stomach.
    fn forcing(&self, condition: &Condition, work: &WorkDone, insulin: UnitsPerHour) -> Forcing {
        let after = self.amplitudes.of(Effect::PostExerciseSensitivity);
        Forcing {
            insulin: insulin.0 * condition.bioavailability / 60.0,
            emptied: 0.0,
            glucose_flux: condition.glucose_flux * MG_PER_MMOL,
            work: work.net_uptake(self.amplitudes.of(Effect::Exercise)),
            uptake: condition.uptake,
            production: condition.production,
            action: condition.action * work.action_factor(after),
            liver_action: condition.liver_action,
            insulin_time: condition.insulin_time,
            gut_time: condition.gut_time,
            renal_threshold: condition.renal_threshold,
            renal_slope: condition.renal_slope,
        }
    }
}

impl VirtualBody for MinimalBody<'_> {
    fn at_rest(&self, glucose: MgPerDl) -> Result<(MinimalBodyState, UnitsPerHour), OdeError> {
        let (compartments, basal) = steady_state::at_glucose(&self.parameters, glucose)?;
        Ok((MinimalBodyState { compartments, ..MinimalBodyState::default() }, basal))
    }
}

impl Plant for MinimalBody<'_> {
    type State = MinimalBodyState;

    fn step(
        &self,
        state: &MinimalBodyState,
        input: &StepInput,
    ) -> Result<MinimalBodyState, NonFinite> {
        let p = &self.parameters;
        let glucose = self.glucose(state);
        let drawn = self.conditions.get(state.step).unwrap_or(&Condition::AS_DRAWN);
        let low = state.low.after_step(glucose, drawn.low_form, drawn.low_response_time);
        let condition = self.warped(drawn.at_glucose(glucose, &low), state);
        let work = state.work.after_step(drawn.felt(input.exercise));

        let mut stomach = state.stomach;
        stomach.eat(1000.0 * input.carbs.0, 1.0);
        stomach.eat(1000.0 * input.rescue.amount.0, FAST);

        let mut forcing = self.forcing(&condition, &work, input.insulin());
        let mut x = state.compartments;
        let h = STEP.0 / SUBSTEPS as f64;
        for _ in 0..SUBSTEPS {
            // The stomach is solved exactly; its outflow is held through the minute.
            forcing.emptied = stomach.pass(h, p.t_half * condition.gut_time, p.beta) / h;
            x = runge_kutta_4(p, &x, &forcing, h);
        }
        let fault = x.entries().into_iter().find(|(_, value)| !value.is_finite());
        if let Some((compartment, _)) = fault {
            return Err(NonFinite { compartment });
        }
        if !stomach.is_finite() {
            return Err(NonFinite { compartment: Compartment::C1 });
        }
        Ok(MinimalBodyState { compartments: x, stomach, work, low, step: state.step + 1 })
    }

    fn glucose(&self, state: &MinimalBodyState) -> MgPerDl {
        MgPerDl(state.compartments.glucose)
    }

    /// The compartments with the nearest meaning: S1 and S2 are the insulin under the skin, X2 the
    /// clearance that insulin causes, X3 the share of P_0 that it suppresses, C1 the content of the
    /// stomach, C2 the rate of appearance. There is no X1 and no Q2.
    fn report(&self, state: &MinimalBodyState) -> States {
        let (p, x) = (&self.parameters, &state.compartments);
        let per_kg = 1.0 / (p.weight.0 * MG_PER_MMOL);
        let mut states = States::default();
        states[Compartment::S1] = 1000.0 * x.bound / p.weight.0;
        states[Compartment::S2] = 1000.0 * x.free / p.weight.0;
        states[Compartment::I] = x.insulin;
        states[Compartment::X2] = x.x;
        states[Compartment::X3] = 1.0 - production(p, x.y) / p.p_0;
        states[Compartment::Q1] = x.glucose;
        states[Compartment::C1] = state.stomach.content() * per_kg;
        states[Compartment::C2] = p.f * p.k_abs * x.intestine * per_kg;
        states
    }
}

/// One step of the classical Runge-Kutta method.
fn runge_kutta_4(
    p: &MinimalParameters,
    x: &MinimalState,
    forcing: &Forcing,
    h: f64,
) -> MinimalState {
    let slope = |x: &MinimalState| derivative(p, x, forcing);
    let k1 = slope(x);
    let k2 = slope(&x.plus(0.5 * h, &k1));
    let k3 = slope(&x.plus(0.5 * h, &k2));
    let k4 = slope(&x.plus(h, &k3));
    x.plus(h / 6.0, &k1).plus(h / 3.0, &k2).plus(h / 3.0, &k3).plus(h / 6.0, &k4)
}

#[cfg(test)]
mod tests {
    use super::*;
    use physiology::{OpenLoop, Units, simulate};

    #[test]
    fn a_steady_state_stands_still() {
        let p = MinimalParameters::nominal();
        for glucose in [70.0, 100.0, 130.0, 180.0, 240.0] {
            let body = MinimalBody::undisturbed(p);
            let (start, basal) = body.at_rest(MgPerDl(glucose)).expect("a steady state");
            let still = steady_state::residual(&p, &start.compartments, basal);
            assert!(still < 1e-10, "{glucose} mg/dL: {still} per minute"); // bisection to rounding
            let inputs = vec![StepInput { basal, ..StepInput::default() }; 288];
            let run = simulate(&body, start, &mut OpenLoop::new(&inputs), 288).expect("finite");
            let end = body.glucose(&run.states[288]).0;
            assert!((end - glucose).abs() < 1e-6, "{glucose}: {end}"); // a day of such residuals
        }
        let body = MinimalBody::undisturbed(p);
        assert!(matches!(body.at_rest(MgPerDl(-1.0)), Err(OdeError::Argument { .. })));
        assert!(matches!(body.at_rest(MgPerDl(2000.0)), Err(OdeError::NoBasal { .. })));
    }

    #[test]
    fn a_large_bolus_is_absorbed_more_slowly_than_a_small_one() {
        let p = MinimalParameters::nominal();
        let body = MinimalBody::undisturbed(p);
        let share_left = |dose: f64| {
            let (start, basal) = body.at_rest(MgPerDl(200.0)).expect("a steady state");
            let mut inputs = [StepInput { basal, ..StepInput::default() }; 24];
            inputs[0].bolus = Units(dose);
            let run = simulate(&body, start, &mut OpenLoop::new(&inputs), 24).expect("finite");
            let end = &run.states[24].compartments;
            let rest = &start.compartments;
            (end.bound + end.free - rest.bound - rest.free) / dose
        };
        let (small, large) = (share_left(1.0), share_left(12.0));
        assert!(large > small + 0.03, "{small} {large}");
    }
}
