//! How the Hovorka body lives through a step: the ODE with a person's parameters, and the effects
//! that act on free-living people beyond it.

use ode_sim::equations::{RENAL_RATE, RENAL_THRESHOLD, renal_clearance};
use ode_sim::{EgpMode, Integrator, OdeError, OdeParameters, OdePlant, OdeState, steady_state};
use physiology::{
    Compartment, Kilograms, MgPerDl, MmolPerL, NonFinite, Plant, States, StepInput, Units,
    UnitsPerHour,
};
use rand::Rng;

use super::exertion::ExerciseTrace;
use super::parameters::HovorkaParameters;
use crate::body::{BodyModel, SUBSTEPS};
use crate::effects::{Amplitudes, Condition, Effect};

/// State of a body of the ODE.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HovorkaState {
    /// State of the ODE.
    pub ode: OdeState,
    /// What past exercise still does.
    pub exercise: ExerciseTrace,
}

impl HovorkaParameters {
    /// The ODE with given parameters.
    fn plant(&self, parameters: OdeParameters) -> OdePlant {
        OdePlant {
            parameters,
            weight: self.weight,
            integrator: Integrator::RungeKutta4 { substeps: SUBSTEPS },
            egp: EgpMode::NonNegative,
        }
    }

    /// Renal clearance at a glucose (mmol/L) beyond that of the ODE, mmol/kg/min.
    fn renal_excess(&self, condition: &Condition, glucose: f64) -> f64 {
        let threshold = RENAL_THRESHOLD * condition.renal_threshold;
        let rate = RENAL_RATE * condition.renal_slope;
        let v_g = self.model.v_g;
        rate * (glucose - threshold).max(0.0) * v_g - renal_clearance(glucose, v_g)
    }

    /// The parameters of the ODE in one step, in which exercise of the past multiplies insulin
    /// action by `trained`.
    fn in_step(&self, condition: &Condition, trained: f64) -> OdeParameters {
        let drawn = self.model;
        OdeParameters {
            egp_0: drawn.egp_0 * condition.production,
            f_01: drawn.f_01 * condition.uptake,
            s_f1: drawn.s_f1 * condition.action * trained,
            s_f2: drawn.s_f2 * condition.action * trained,
            s_f3: drawn.s_f3 * condition.liver_action,
            t_max_i: drawn.t_max_i * condition.insulin_time,
            t_max_g: drawn.t_max_g * condition.gut_time,
            ..drawn
        }
    }
}

impl BodyModel for HovorkaParameters {
    type State = HovorkaState;

    fn draw(rng: &mut (impl Rng + ?Sized)) -> Self {
        Self::draw(rng)
    }

    fn weight(&self) -> Kilograms {
        self.weight
    }

    fn at_rest(&self, glucose: MgPerDl) -> Result<(HovorkaState, UnitsPerHour), OdeError> {
        let found = steady_state::at_glucose(&self.model, self.weight, glucose)?;
        Ok((HovorkaState { ode: found.state, exercise: ExerciseTrace::default() }, found.basal))
    }

    /// Exercise acts through this crate's own [`ExerciseTrace`], not through the multipliers of
    /// the ODE's authors.
    fn advance(
        &self,
        state: &HovorkaState,
        input: &StepInput,
        condition: &Condition,
        amplitudes: &Amplitudes,
    ) -> Result<HovorkaState, NonFinite> {
        let exercise = state.exercise.after_step(input.exercise);
        let trained = exercise.action_factor(amplitudes.of(Effect::PostExerciseSensitivity));
        let plant = self.plant(self.in_step(condition, trained));
        let glucose = MmolPerL::from(self.glucose(state)).0;
        let uptake = exercise.uptake(glucose, amplitudes.of(Effect::Exercise));
        let flux = condition.glucose_flux - uptake - self.renal_excess(condition, glucose);
        let absorbed = StepInput {
            basal: UnitsPerHour(input.basal.0 * condition.bioavailability),
            bolus: Units(input.bolus.0 * condition.bioavailability),
            exercise: None,
            ..*input
        };
        let ode = plant.advance(&state.ode, &absorbed, flux).map_err(|error| match error {
            OdeError::NonFinite { compartment } => NonFinite { compartment },
            // Runge-Kutta steps fail in no other way. If they did, glucose would be what is lost.
            _ => NonFinite { compartment: Compartment::Q1 },
        })?;
        Ok(HovorkaState { ode, exercise })
    }

    fn glucose(&self, state: &HovorkaState) -> MgPerDl {
        self.plant(self.model).glucose(&state.ode)
    }

    fn report(&self, state: &HovorkaState) -> States {
        self.plant(self.model).report(&state.ode)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Body;
    use physiology::{Exercise, Grams, OpenLoop, simulate};

    fn nominal() -> HovorkaParameters {
        HovorkaParameters { model: OdeParameters::nominal(), weight: Kilograms(76.3) }
    }

    /// Glucose after each step of four hours from 150 mg/dL, with a meal and its bolus at the
    /// start.
    fn course(
        condition: Condition,
        amplitudes: Amplitudes,
        exercise: Option<Exercise>,
    ) -> Vec<f64> {
        let course = [condition; 48];
        let body = Body::new(nominal(), &course, amplitudes);
        let (start, basal) = body.at_rest(MgPerDl(150.0)).expect("a steady state");
        let mut inputs = [StepInput { basal, exercise, ..StepInput::default() }; 48];
        inputs[0].carbs = Grams(40.0);
        inputs[0].bolus = Units(3.0);
        let run = simulate(&body, start, &mut OpenLoop::new(&inputs), 48).expect("finite");
        run.glucose(&body).iter().skip(1).map(|g| g.0).collect()
    }

    fn mean(course: &[f64]) -> f64 {
        course.iter().sum::<f64>() / course.len() as f64
    }

    #[test]
    fn the_undisturbed_body_is_the_ode() {
        let body = course(Condition::AS_DRAWN, Amplitudes::NONE, None);
        let plant = nominal().plant(nominal().model);
        let start = steady_state::at_glucose(&plant.parameters, plant.weight, MgPerDl(150.0))
            .expect("a steady state");
        let mut inputs = [StepInput { basal: start.basal, ..StepInput::default() }; 48];
        inputs[0].carbs = Grams(40.0);
        inputs[0].bolus = Units(3.0);
        let run = simulate(&plant, start.state, &mut OpenLoop::new(&inputs), 48).expect("finite");
        let ode: Vec<f64> = run.glucose(&plant).iter().skip(1).map(|g| g.0).collect();
        assert!(body == ode);
    }

    #[test]
    fn every_condition_moves_glucose_the_way_it_should() {
        let drawn = Condition::AS_DRAWN;
        let plain = course(drawn, Amplitudes::NONE, None);
        let cases = [
            ("production", Condition { production: 1.2, ..drawn }, 1.0),
            ("action", Condition { action: 1.2, ..drawn }, -1.0),
            ("liver action", Condition { liver_action: 1.2, ..drawn }, -1.0),
            ("insulin time", Condition { insulin_time: 1.3, ..drawn }, 1.0),
            ("bioavailability", Condition { bioavailability: 0.8, ..drawn }, 1.0),
        ];
        for (name, condition, sign) in cases {
            let moved = mean(&course(condition, Amplitudes::NONE, None)) - mean(&plain);
            assert!(sign * moved > 1.0, "{name}: {moved} mg/dL");
        }
        // A slower gut gives less in the first hour.
        let slow = course(Condition { gut_time: 1.5, ..drawn }, Amplitudes::NONE, None);
        assert!(mean(&slow[..12]) < mean(&plain[..12]) - 5.0);
    }

    #[test]
    fn exercise_acts_through_its_two_effects_alone() {
        let bout = Some(Exercise { vo2max_percent: 55.0, active_muscle_share: 0.5 });
        let drawn = Condition::AS_DRAWN;
        let rest = course(drawn, Amplitudes::NONE, None);
        assert!(course(drawn, Amplitudes::NONE, bout) == rest);
        for effect in [Effect::Exercise, Effect::PostExerciseSensitivity] {
            let one = course(drawn, Amplitudes::NONE.with(effect, 1.0), bout);
            assert!(mean(&one) < mean(&rest) - 2.0, "{}", effect.name());
        }
    }
}
