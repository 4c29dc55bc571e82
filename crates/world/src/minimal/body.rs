//! How the minimal body lives through a step, with the effects that act on it.

use ode_sim::OdeError;
use physiology::{Compartment, Kilograms, MgPerDl, NonFinite, States, StepInput, UnitsPerHour};
use rand::Rng;

use super::equations::{Forcing, MG_PER_MMOL, MinimalCompartments, derivative, production};
use super::exertion::WorkDone;
use super::parameters::MinimalParameters;
use super::steady_state;
use super::stomach::Stomach;
use crate::body::{Body, BodyModel, Compartments as _, SUBSTEP, SUBSTEPS};
use crate::effects::{Amplitudes, Condition, Effect};
use crate::therapy::{LEAST_FALL, fall_by_a_unit};

/// Half-time of fast carbohydrate in the stomach relative to that of a meal.
const FAST: f64 = 0.3;

/// State of a body of the minimal-model kind.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MinimalState {
    /// The seven compartments.
    pub compartments: MinimalCompartments,
    /// The meals in the stomach.
    pub stomach: Stomach,
    /// What past exercise still does.
    pub work: WorkDone,
}

impl BodyModel for MinimalParameters {
    type State = MinimalState;

    fn draw(rng: &mut (impl Rng + ?Sized)) -> Self {
        Self::draw(rng)
    }

    /// Rules of treatment do not apply to a person who hardly responds.
    fn responds_to_insulin(&self) -> bool {
        fall_by_a_unit(&Body::undisturbed(*self)).is_ok_and(|fall| fall >= LEAST_FALL)
    }

    fn weight(&self) -> Kilograms {
        self.weight
    }

    fn at_rest(&self, glucose: MgPerDl) -> Result<(MinimalState, UnitsPerHour), OdeError> {
        let (compartments, basal) = steady_state::at_glucose(self, glucose)?;
        Ok((MinimalState { compartments, ..MinimalState::default() }, basal))
    }

    fn advance(
        &self,
        state: &MinimalState,
        input: &StepInput,
        condition: &Condition,
        amplitudes: &Amplitudes,
    ) -> Result<MinimalState, NonFinite> {
        let work = state.work.after_step(input.exercise);
        let mut stomach = state.stomach;
        stomach.eat(1000.0 * input.carbs.0, 1.0);
        stomach.eat(1000.0 * input.rescue.amount.0, FAST);

        let after = amplitudes.of(Effect::PostExerciseSensitivity);
        let mut forcing = Forcing {
            insulin: input.insulin().0 * condition.bioavailability / 60.0,
            emptied: 0.0,
            work: work.net_uptake(amplitudes.of(Effect::Exercise)),
            condition: Condition {
                action: condition.action * work.action_factor(after),
                ..*condition
            },
        };
        let mut x = state.compartments;
        for _ in 0..SUBSTEPS {
            // The stomach is solved exactly; its outflow is held through the minute.
            let half_time = self.t_half * condition.gut_time;
            forcing.emptied = stomach.pass(SUBSTEP, half_time, self.beta) / SUBSTEP;
            x = x.runge_kutta_4(SUBSTEP, |x| derivative(self, x, &forcing));
        }
        if !stomach.is_finite() {
            return Err(NonFinite { compartment: Compartment::C1 });
        }
        Ok(MinimalState { compartments: x.finite()?, stomach, work })
    }

    fn glucose(&self, state: &MinimalState) -> MgPerDl {
        MgPerDl(state.compartments.glucose)
    }

    /// The compartments with the nearest meaning: S1 and S2 are the insulin under the skin, X2 the
    /// clearance that insulin causes, X3 the share of P_0 that it suppresses, C1 the content of the
    /// stomach, C2 the rate of appearance. There is no X1 and no Q2.
    fn report(&self, state: &MinimalState) -> States {
        let (p, x) = (self, &state.compartments);
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

#[cfg(test)]
mod tests {
    use super::*;
    use physiology::{OpenLoop, Plant, Units, simulate};

    #[test]
    fn a_steady_state_stands_still() {
        let p = MinimalParameters::nominal();
        for glucose in [70.0, 100.0, 130.0, 180.0, 240.0] {
            let body = Body::undisturbed(p);
            let (start, basal) = body.at_rest(MgPerDl(glucose)).expect("a steady state");
            let (condition, insulin) = (Condition::AS_DRAWN, basal.0 / 60.0);
            let forcing = Forcing { condition, insulin, emptied: 0.0, work: 0.0 };
            let slope = derivative(&p, &start.model.compartments, &forcing);
            // Bisection to rounding.
            let still = slope.entries().all(|(_, rate)| rate.abs() < 1e-10);
            assert!(still, "{glucose} mg/dL: {slope:?} per minute");
            let inputs = vec![StepInput { basal, ..StepInput::default() }; 288];
            let run = simulate(&body, start, &mut OpenLoop::new(&inputs), 288).expect("finite");
            let end = body.glucose(&run.states[288]).0;
            assert!((end - glucose).abs() < 1e-6, "{glucose}: {end}"); // a day of such residuals
        }
        let body = Body::undisturbed(p);
        assert!(matches!(body.at_rest(MgPerDl(-1.0)), Err(OdeError::Argument { .. })));
        assert!(matches!(body.at_rest(MgPerDl(2000.0)), Err(OdeError::NoBasal { .. })));
    }

    #[test]
    fn a_large_bolus_is_absorbed_more_slowly_than_a_small_one() {
        let p = MinimalParameters::nominal();
        let body = Body::undisturbed(p);
        let share_left = |dose: f64| {
            let (start, basal) = body.at_rest(MgPerDl(200.0)).expect("a steady state");
            let mut inputs = [StepInput { basal, ..StepInput::default() }; 24];
            inputs[0].bolus = Units(dose);
            let run = simulate(&body, start, &mut OpenLoop::new(&inputs), 24).expect("finite");
            let end = &run.states[24].model.compartments;
            let rest = &start.model.compartments;
            (end.bound + end.free - rest.bound - rest.free) / dose
        };
        let (small, large) = (share_left(1.0), share_left(12.0));
        assert!(large > small + 0.03, "{small} {large}");
    }
}
