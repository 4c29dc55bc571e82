//! The saturating body as a plant, with the effects that act on it.

use ode_sim::OdeError;
use physiology::{
    Compartment, GRAMS_PER_MMOL_GLUCOSE, MgPerDl, MmolPerL, NonFinite, Plant, STEP, States,
    StepInput, UnitsPerHour,
};

use super::equations::{Forcing, derivative, production, uptake};
use super::exertion::SpentGlycogen;
use super::parameters::SaturatingParameters;
use super::state::SaturatingState;
use super::steady_state;
use crate::effects::{Amplitudes, Condition, Effect, LowTrace};
use crate::virtual_body::VirtualBody;
use crate::warp::{Warped, Warps};

/// Runge-Kutta steps within the five minutes: one per minute.
const SUBSTEPS: usize = 5;

/// A saturating body whose parameters change from step to step.
///
/// Fast carbohydrate against a low bypasses the stomach.
#[derive(Debug, Clone)]
pub struct SaturatingBody<'a> {
    parameters: SaturatingParameters,
    conditions: &'a [Condition],
    amplitudes: Amplitudes,
    warped: Option<Warped>,
}

/// State of a [`SaturatingBody`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SaturatingBodyState {
    /// The twelve compartments.
    pub compartments: SaturatingState,
    /// What past exercise still does.
    pub glycogen: SpentGlycogen,
    /// How far a low has activated counter-regulation.
    pub low: LowTrace,
    /// Steps done.
    pub step: usize,
}

impl<'a> SaturatingBody<'a> {
    /// A body under the course of `conditions`, one per step. After their end the body is as drawn.
    #[must_use]
    pub fn new(
        parameters: SaturatingParameters,
        conditions: &'a [Condition],
        amplitudes: Amplitudes,
    ) -> Self {
        Self { parameters, conditions, amplitudes, warped: None }
    }

    /// The body as drawn, without any effect or variability.
    #[must_use]
    pub fn undisturbed(parameters: SaturatingParameters) -> SaturatingBody<'static> {
        SaturatingBody { parameters, conditions: &[], amplitudes: Amplitudes::NONE, warped: None }
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
    fn warped(&self, condition: Condition, state: &SaturatingBodyState) -> Condition {
        match &self.warped {
            Some(warped) => warped.act(condition, &self.report(state)),
            None => condition,
        }
    }

    /// What acts through one step.
    fn forcing(
        &self,
        condition: &Condition,
        glycogen: &SpentGlycogen,
        insulin: UnitsPerHour,
    ) -> Forcing {
        let now = self.amplitudes.of(Effect::Exercise);
        let after = self.amplitudes.of(Effect::PostExerciseSensitivity);
        Forcing {
            insulin: 1000.0 * insulin.0 * condition.bioavailability / 60.0,
            glucose_flux: condition.glucose_flux,
            work: glycogen.capacity(now),
            uptake: condition.uptake,
            production: condition.production * glycogen.production_factor(now),
            action: condition.action * glycogen.action_factor(after),
            liver_action: condition.liver_action,
            insulin_time: condition.insulin_time,
            gut_time: condition.gut_time,
            renal_threshold: condition.renal_threshold,
            renal_slope: condition.renal_slope,
        }
    }
}

impl VirtualBody for SaturatingBody<'_> {
    fn at_rest(&self, glucose: MgPerDl) -> Result<(SaturatingBodyState, UnitsPerHour), OdeError> {
        let (compartments, basal) = steady_state::at_glucose(&self.parameters, glucose)?;
        Ok((SaturatingBodyState { compartments, ..SaturatingBodyState::default() }, basal))
    }
}

impl Plant for SaturatingBody<'_> {
    type State = SaturatingBodyState;

    fn step(
        &self,
        state: &SaturatingBodyState,
        input: &StepInput,
    ) -> Result<SaturatingBodyState, NonFinite> {
        let glucose = self.glucose(state);
        let drawn = self.conditions.get(state.step).unwrap_or(&Condition::AS_DRAWN);
        let low = state.low.after_step(glucose, drawn.low_form, drawn.low_response_time);
        let condition = self.warped(drawn.at_glucose(glucose, &low), state);
        let glycogen = state.glycogen.after_step(drawn.felt(input.exercise));

        let mut x = state.compartments;
        x.stomach += input.carbs.0;
        x.upper += input.rescue.amount.0;
        let forcing = self.forcing(&condition, &glycogen, input.insulin());
        let h = STEP.0 / SUBSTEPS as f64;
        for _ in 0..SUBSTEPS {
            x = runge_kutta_4(&self.parameters, &x, &forcing, h);
        }
        match x.entries().iter().find(|(_, value)| !value.is_finite()) {
            Some((compartment, _)) => Err(NonFinite { compartment: *compartment }),
            None => {
                Ok(SaturatingBodyState { compartments: x, glycogen, low, step: state.step + 1 })
            }
        }
    }

    fn glucose(&self, state: &SaturatingBodyState) -> MgPerDl {
        MmolPerL(state.compartments.plasma).into()
    }

    /// The compartments with the nearest meaning: S1 is the first compartments of both channels, S2
    /// the second of the slow one, X2 the rate at which muscle clears its glucose, X3 the share of
    /// the production without insulin that insulin suppresses, C1 the content of the stomach, C2
    /// the rate of appearance. There is no X1.
    fn report(&self, state: &SaturatingBodyState) -> States {
        let (p, x) = (&self.parameters, &state.compartments);
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

/// One step of the classical Runge-Kutta method.
fn runge_kutta_4(
    p: &SaturatingParameters,
    x: &SaturatingState,
    forcing: &Forcing,
    h: f64,
) -> SaturatingState {
    let slope = |x: &SaturatingState| derivative(p, x, forcing);
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
        let p = SaturatingParameters::nominal();
        for glucose in [70.0, 100.0, 130.0, 180.0, 240.0] {
            let body = SaturatingBody::undisturbed(p);
            let (start, basal) = body.at_rest(MgPerDl(glucose)).expect("a steady state");
            let still = steady_state::residual(&p, &start.compartments, basal);
            assert!(still < 1e-8, "{glucose} mg/dL: {still} per minute"); // bisection to rounding
            let inputs = vec![StepInput { basal, ..StepInput::default() }; 288];
            let run = simulate(&body, start, &mut OpenLoop::new(&inputs), 288).expect("finite");
            let end = body.glucose(&run.states[288]).0;
            assert!((end - glucose).abs() < 1e-5, "{glucose}: {end}"); // a day of such residuals
        }
        let body = SaturatingBody::undisturbed(p);
        assert!(matches!(body.at_rest(MgPerDl(-1.0)), Err(OdeError::Argument { .. })));
        assert!(matches!(body.at_rest(MgPerDl(2000.0)), Err(OdeError::NoBasal { .. })));
    }

    #[test]
    fn twice_the_insulin_does_less_than_twice_the_work() {
        let body = SaturatingBody::undisturbed(SaturatingParameters::nominal());
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
