//! How the saturating body lives through a step, with the effects that act on it.

use ode_sim::OdeError;
use physiology::{
    Compartment, GRAMS_PER_MMOL_GLUCOSE, Kilograms, MgPerDl, MmolPerL, NonFinite, States,
    StepInput, UnitsPerHour,
};
use rand::Rng;

use super::equations::{Forcing, SaturatingCompartments, derivative, production, uptake};
use super::exertion::SpentGlycogen;
use super::parameters::SaturatingParameters;
use super::steady_state;
use crate::body::{Body, BodyModel, Compartments as _, SUBSTEP, SUBSTEPS};
use crate::effects::{Amplitudes, Condition, Effect};
use crate::therapy::{LEAST_FALL, fall_by_a_unit};

/// State of a saturating body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SaturatingState {
    /// The twelve compartments.
    pub compartments: SaturatingCompartments,
    /// What past exercise still does.
    pub glycogen: SpentGlycogen,
}

impl BodyModel for SaturatingParameters {
    type State = SaturatingState;

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

    fn at_rest(&self, glucose: MgPerDl) -> Result<(SaturatingState, UnitsPerHour), OdeError> {
        let (compartments, basal) = steady_state::at_glucose(self, glucose)?;
        Ok((SaturatingState { compartments, ..SaturatingState::default() }, basal))
    }

    /// Fast carbohydrate against a low bypasses the stomach.
    fn advance(
        &self,
        state: &SaturatingState,
        input: &StepInput,
        condition: &Condition,
        amplitudes: &Amplitudes,
    ) -> Result<SaturatingState, NonFinite> {
        let glycogen = state.glycogen.after_step(input.exercise);
        let mut x = state.compartments;
        x.stomach += input.carbs.0;
        x.upper += input.rescue.amount.0;

        let now = amplitudes.of(Effect::Exercise);
        let after = amplitudes.of(Effect::PostExerciseSensitivity);
        let forcing = Forcing {
            insulin: 1000.0 * input.insulin().0 * condition.bioavailability / 60.0,
            work: glycogen.capacity(now),
            condition: Condition {
                production: condition.production * glycogen.production_factor(now),
                action: condition.action * glycogen.action_factor(after),
                ..*condition
            },
        };
        for _ in 0..SUBSTEPS {
            x = x.runge_kutta_4(SUBSTEP, |x| derivative(self, x, &forcing));
        }
        Ok(SaturatingState { compartments: x.finite()?, glycogen })
    }

    fn glucose(&self, state: &SaturatingState) -> MgPerDl {
        MmolPerL(state.compartments.plasma).into()
    }

    /// The compartments with the nearest meaning: S1 is the first compartments of both channels, S2
    /// the second of the slow one, X2 the rate at which muscle clears its glucose, X3 the share of
    /// the production without insulin that insulin suppresses, C1 the content of the stomach, C2
    /// the rate of appearance. There is no X1.
    fn report(&self, state: &SaturatingState) -> States {
        let (p, x) = (self, &state.compartments);
        let per_kg = 1.0 / p.weight.0;
        let mut states = States::default();
        states[Compartment::S1] = (x.slow + x.fast) * per_kg;
        states[Compartment::S2] = x.slow_next * per_kg;
        states[Compartment::I] = x.insulin;
        let clearance = uptake(p, x.muscle, x.at_muscle, 0.0) / (p.v_m * x.muscle.max(1e-9));
        states[Compartment::X2] = clearance;
        let free = production(p, 0.0, x.glucagon);
        states[Compartment::X3] = 1.0 - production(p, x.at_liver, x.glucagon) / free;
        states[Compartment::Q1] = self.glucose(state).0;
        states[Compartment::Q2] = x.muscle * p.v_m;
        states[Compartment::C1] = x.stomach * per_kg / GRAMS_PER_MMOL_GLUCOSE;
        states[Compartment::C2] = p.f * p.k_l * x.lower * per_kg / GRAMS_PER_MMOL_GLUCOSE;
        states
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use physiology::{OpenLoop, Plant, Units, simulate};

    #[test]
    fn a_steady_state_stands_still() {
        let p = SaturatingParameters::nominal();
        for glucose in [70.0, 100.0, 130.0, 180.0, 240.0] {
            let body = Body::undisturbed(p);
            let (start, basal) = body.at_rest(MgPerDl(glucose)).expect("a steady state");
            let (condition, insulin) = (Condition::AS_DRAWN, 1000.0 * basal.0 / 60.0);
            let forcing = Forcing { condition, insulin, work: 0.0 };
            let slope = derivative(&p, &start.model.compartments, &forcing);
            // Bisection to rounding.
            let still = slope.entries().all(|(_, rate)| rate.abs() < 1e-8);
            assert!(still, "{glucose} mg/dL: {slope:?} per minute");
            let inputs = vec![StepInput { basal, ..StepInput::default() }; 288];
            let run = simulate(&body, start, &mut OpenLoop::new(&inputs), 288).expect("finite");
            let end = body.glucose(&run.states[288]).0;
            assert!((end - glucose).abs() < 1e-5, "{glucose}: {end}"); // a day of such residuals
        }
        let body = Body::undisturbed(p);
        assert!(matches!(body.at_rest(MgPerDl(-1.0)), Err(OdeError::Argument { .. })));
        assert!(matches!(body.at_rest(MgPerDl(2000.0)), Err(OdeError::NoBasal { .. })));
    }

    #[test]
    fn twice_the_insulin_does_less_than_twice_the_work() {
        let body = Body::undisturbed(SaturatingParameters::nominal());
        let fall = |dose: f64| {
            let (start, basal) = body.at_rest(MgPerDl(250.0)).expect("a steady state");
            let mut inputs = [StepInput { basal, ..StepInput::default() }; 36];
            inputs[0].bolus = Units(dose);
            let run = simulate(&body, start, &mut OpenLoop::new(&inputs), 36).expect("finite");
            250.0 - body.glucose(&run.states[36]).0
        };
        let (single, double) = (fall(3.0), fall(6.0));
        assert!(single > 20.0 && double > single && double < 1.9 * single, "{single} {double}");
    }

    #[test]
    fn glucagon_rises_in_a_low_and_falls_with_insulin() {
        let p = SaturatingParameters::nominal();
        let wanted =
            |glucose, insulin| super::super::equations::glucagon_wanted(&p, glucose, insulin);
        assert!(wanted(3.0, 10.0) > 1.12 * wanted(6.0, 10.0));
        assert!(wanted(6.0, 60.0) < 0.7 * wanted(6.0, 10.0));
    }
}
