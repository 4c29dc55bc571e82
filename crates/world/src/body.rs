//! The simulated body: the ODE with a person's parameters at one-minute resolution, and the effects
//! that act on free-living people beyond it.

use ode_sim::equations::{RENAL_RATE, RENAL_THRESHOLD, renal_clearance};
use ode_sim::{EgpMode, Integrator, OdeError, OdeParameters, OdePlant, OdeState, steady_state};
use physiology::{MgPerDl, MmolPerL, NonFinite, Plant, States, StepInput, Units, UnitsPerHour};

use crate::effects::{Amplitudes, Condition, Effect, ExerciseTrace, LowTrace};
use crate::person::BodyParameters;
use crate::virtual_body::VirtualBody;
use crate::warp::{Warped, Warps};

/// Runge-Kutta steps within the five minutes: one per minute.
const SUBSTEPS: u32 = 5;

/// A body whose parameters change from step to step.
///
/// The step is part of the state, so [`physiology::simulate`] drives it like any other plant.
/// Exercise acts through this crate's own [`ExerciseTrace`], not through the multipliers of the
/// ODE's authors.
#[derive(Debug, Clone)]
pub struct Body<'a> {
    parameters: BodyParameters,
    conditions: &'a [Condition],
    amplitudes: Amplitudes,
    warped: Option<Warped>,
}

/// State of a [`Body`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyState {
    /// State of the ODE.
    pub ode: OdeState,
    /// What past exercise still does.
    pub exercise: ExerciseTrace,
    /// How far a low has activated counter-regulation.
    pub low: LowTrace,
    /// Steps done.
    pub step: usize,
}

impl<'a> Body<'a> {
    /// A body under the course of `conditions`, one per step. After their end the body is as drawn.
    #[must_use]
    pub fn new(
        parameters: BodyParameters,
        conditions: &'a [Condition],
        amplitudes: Amplitudes,
    ) -> Self {
        Self { parameters, conditions, amplitudes, warped: None }
    }

    /// The body as drawn, without any effect or variability.
    #[must_use]
    pub fn undisturbed(parameters: BodyParameters) -> Body<'static> {
        Body { parameters, conditions: &[], amplitudes: Amplitudes::NONE, warped: None }
    }

    /// The same body with a form of its own: warped functions.
    ///
    /// # Errors
    /// If it has no steady state at the glucose at which warps are 1.
    pub fn with_warps(self, warps: Warps) -> Result<Self, OdeError> {
        let warped = Warped::of(warps, &self, self.parameters.weight)?;
        Ok(Self { warped, ..self })
    }

    /// A condition with the warps at a state.
    fn warped(&self, condition: Condition, state: &BodyState) -> Condition {
        match &self.warped {
            Some(warped) => warped.act(condition, &self.report(state)),
            None => condition,
        }
    }

    /// The ODE with given parameters.
    fn plant(&self, parameters: OdeParameters) -> OdePlant {
        OdePlant {
            parameters,
            weight: self.parameters.weight,
            integrator: Integrator::RungeKutta4 { substeps: SUBSTEPS },
            egp: EgpMode::NonNegative,
        }
    }

    /// Renal clearance at a glucose (mmol/L) beyond that of the ODE, mmol/kg/min.
    fn renal_excess(&self, condition: &Condition, glucose: f64) -> f64 {
        let threshold = RENAL_THRESHOLD * condition.renal_threshold;
        let rate = RENAL_RATE * condition.renal_slope;
        let v_g = self.parameters.model.v_g;
        rate * (glucose - threshold).max(0.0) * v_g - renal_clearance(glucose, v_g)
    }

    /// The model's parameters in one step.
    fn parameters_in(&self, condition: &Condition, exercise: &ExerciseTrace) -> OdeParameters {
        let drawn = self.parameters.model;
        let after = exercise.action_factor(self.amplitudes.of(Effect::PostExerciseSensitivity));
        OdeParameters {
            egp_0: drawn.egp_0 * condition.production,
            f_01: drawn.f_01 * condition.uptake,
            s_f1: drawn.s_f1 * condition.action * after,
            s_f2: drawn.s_f2 * condition.action * after,
            s_f3: drawn.s_f3 * condition.liver_action,
            t_max_i: drawn.t_max_i * condition.insulin_time,
            t_max_g: drawn.t_max_g * condition.gut_time,
            ..drawn
        }
    }
}

impl VirtualBody for Body<'_> {
    fn at_rest(&self, glucose: MgPerDl) -> Result<(BodyState, UnitsPerHour), OdeError> {
        let found =
            steady_state::at_glucose(&self.parameters.model, self.parameters.weight, glucose)?;
        let state = BodyState {
            ode: found.state,
            exercise: ExerciseTrace::default(),
            low: LowTrace::default(),
            step: 0,
        };
        Ok((state, found.basal))
    }
}

impl Plant for Body<'_> {
    type State = BodyState;

    fn step(&self, state: &BodyState, input: &StepInput) -> Result<BodyState, NonFinite> {
        let glucose = self.glucose(state);
        let drawn = self.conditions.get(state.step).unwrap_or(&Condition::AS_DRAWN);
        let low = state.low.after_step(glucose, drawn.low_form, drawn.low_response_time);
        let condition = &self.warped(drawn.at_glucose(glucose, &low), state);
        let exercise = state.exercise.after_step(drawn.felt(input.exercise));
        let plant = self.plant(self.parameters_in(condition, &exercise));
        let glucose = MmolPerL::from(glucose).0;
        let uptake = exercise.uptake(glucose, self.amplitudes.of(Effect::Exercise));
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
            _ => NonFinite { compartment: physiology::Compartment::Q1 },
        })?;
        Ok(BodyState { ode, exercise, low, step: state.step + 1 })
    }

    fn glucose(&self, state: &BodyState) -> MgPerDl {
        self.plant(self.parameters.model).glucose(&state.ode)
    }

    fn report(&self, state: &BodyState) -> States {
        self.plant(self.parameters.model).report(&state.ode)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use physiology::{Exercise, Grams, Kilograms, OpenLoop, simulate};

    fn nominal() -> BodyParameters {
        BodyParameters { model: OdeParameters::nominal(), weight: Kilograms(76.3) }
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
        let plant = Body::undisturbed(nominal()).plant(nominal().model);
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
