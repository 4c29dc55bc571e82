//! The model inside the filter: a body, an unexplained glucose flux, interstitial glucose and a sensor
//! error. The body is the ODE plant or another [`Body`].
//!
//! What effects change in a step enters as a [`Modulation`].
//!
//! Fourteen states: the ten compartments, an Ornstein-Uhlenbeck flux into Q1, interstitial glucose
//! that follows plasma glucose with a first-order lag, and the sensor error of this step and of the
//! one before, an autoregression of order two. A reading is interstitial glucose plus sensor error plus
//! white noise.

mod euler;

use std::sync::Arc;

use effects::{Field, Modulation};
use ode_sim::equations::{RENAL_RATE, RENAL_THRESHOLD, infusion, renal_clearance};
use ode_sim::steady_state::held_by;
use ode_sim::{EgpMode, Integrator, OdeError, OdeParameters, OdePlant, OdeState, OdeVector, slot};
use physiology::Compartment::{C1, C2, I, Q1, Q2, S1, S2, X1, X2, X3};
use physiology::{
    Grams, Kilograms, MG_PER_DL_PER_MMOL_PER_L, MgPerDl, Plant as _, States, StepInput, Units,
    UnitsPerHour,
};

use self::euler::COMPARTMENTS;
pub(crate) use self::euler::{Euler, PlainRun};
use crate::filter::body::{Body, OtherBody, Slopes};
use crate::filter::covariance::Covariance;
use crate::filter::noise::NoiseModel;
use crate::filter::state::{AugmentedState, FLUX, INTERSTITIAL, SENSOR, SENSOR_BEFORE, STATES};
use crate::filter::transition::{BodySlopes, Transition};

/// Glucose below which a correction by the filter is cut off; sensors end at 40 mg/dL.
pub const GLUCOSE_FLOOR: MgPerDl = MgPerDl(30.0);

/// Interstitial glucose below which counter-regulation adds production, mg/dL, and the depth at which
/// it does so in full.
const LOW_GLUCOSE: f64 = 70.0;
const LOW_DEPTH: f64 = 20.0;

/// Standard deviation of what each gut compartment may hold before the first reading, mmol/kg.
const GUT_SD: f64 = 0.3;

/// Which body moves, and what it needs for a step.
#[derive(Debug, Clone)]
pub(crate) enum Stepper {
    /// The ODE, with everything that does not change between steps.
    Ode(Euler),
    /// Another body.
    Other(Arc<OtherBody>),
}

impl Stepper {
    /// The body alone one step later; `flux` is added to dQ1/dt, mmol/kg/min.
    #[inline(always)]
    fn advance(
        &self,
        person: &OdePlant,
        body: &OdeState,
        input: &StepInput,
        flux: f64,
    ) -> Result<OdeState, OdeError> {
        let euler = match self {
            Self::Ode(euler) => euler,
            Self::Other(other) => {
                return Ok(other.step(person, body, input, flux, Slopes::Skip)?.0);
            }
        };
        if Euler::covers(body, input) {
            let x = OdeVector(euler.step(&body.vector().0, euler.doses(input), flux));
            if x.first_non_finite().is_none() {
                return Ok(body.with_vector(&x));
            }
        }
        person.advance(body, input, flux)
    }

    /// The body alone one step later and the derivative by its compartments; that of the ODE is without exercise and
    /// rescue carbohydrate.
    #[inline]
    fn linearised(
        &self,
        person: &OdePlant,
        body: &OdeState,
        input: &StepInput,
        flux: f64,
    ) -> Result<(OdeState, BodySlopes), OdeError> {
        match self {
            Self::Ode(euler) => {
                let following = self.advance(person, body, input, flux)?;
                Ok((following, euler.slopes(&body.vector().0)))
            }
            Self::Other(other) => other.step(person, body, input, flux, Slopes::Take),
        }
    }

    /// What comes into S1 and into C1 in a step.
    #[inline(always)]
    fn doses(&self, person: &OdePlant, input: &StepInput) -> [f64; 2] {
        match self {
            Self::Ode(euler) => euler.doses(input),
            Self::Other(other) => other.doses(person, input),
        }
    }
}

/// What acts in one step under a modulation.
pub(crate) struct Acting {
    pub(crate) person: OdePlant,
    pub(crate) stepper: Stepper,
    pub(crate) input: StepInput,
    pub(crate) flux: f64,
    pub(crate) lag_decay: f64,
}

/// Share of counter-regulation that is called up at an interstitial glucose.
pub(crate) fn low_depth(interstitial: MgPerDl) -> f64 {
    ((LOW_GLUCOSE - interstitial.0) / LOW_DEPTH).clamp(0.0, 1.0)
}

/// A body at 5-minute Euler steps with a flux, a lag and a sensor.
#[derive(Debug, Clone)]
pub struct AugmentedModel {
    person: OdePlant,
    stepper: Stepper,
    /// The derivative of the ODE's step at the state zero, which most of its entries share with that at other
    /// states; `None` for another body.
    resting: Option<Transition>,
    noise: NoiseModel,
    flux_decay: f64,
    lag_decay: f64,
    sensor_coefficients: [f64; 2],
    sensor_noise: f64,
}

impl AugmentedModel {
    /// A person's model. Endogenous production never turns negative.
    #[must_use]
    pub fn new(parameters: OdeParameters, weight: Kilograms, noise: NoiseModel) -> Self {
        let (integrator, egp) = (Integrator::ForwardEuler, EgpMode::NonNegative);
        let person = OdePlant { parameters, weight, integrator, egp };
        let model = Self {
            person,
            stepper: Stepper::Ode(Euler::of(&person)),
            resting: None,
            noise,
            flux_decay: noise.flux_decay(),
            lag_decay: noise.lag_decay(),
            sensor_coefficients: noise.sensor_coefficients(),
            sensor_noise: noise.sensor_noise(),
        };
        model.prepared()
    }

    /// With what does not change between steps.
    fn prepared(mut self) -> Self {
        if let Stepper::Ode(euler) = &mut self.stepper {
            *euler = Euler::of(&self.person);
            let slopes = euler.slopes(&[0.0; COMPARTMENTS]);
            self.resting = Some(self.transition(&slopes, self.lag_decay));
        }
        self
    }

    /// The same filter around another body.
    #[must_use]
    pub fn with_body(self, body: Arc<dyn Body>) -> Self {
        Self { stepper: Stepper::Other(Arc::new(OtherBody::new(body))), resting: None, ..self }
    }

    /// The person's parameters and weight, as the ODE plant at 5-minute Euler steps. For another body the ratios of
    /// the parameters to the nominal ones are factors at its ports ([`Body`]).
    #[must_use]
    pub fn person(&self) -> &OdePlant {
        &self.person
    }

    /// The same model of a person with other parameters.
    #[must_use]
    pub fn with_parameters(&self, change: impl Fn(&OdeParameters) -> OdeParameters) -> Self {
        let parameters = change(&self.person.parameters);
        Self { person: OdePlant { parameters, ..self.person }, ..self.clone() }.prepared()
    }

    /// The same model with a lag between plasma and interstitial glucose that is `factor` times as long.
    #[must_use]
    pub fn with_lag(&self, factor: f64) -> Self {
        let interstitial_lag = self.noise.interstitial_lag * factor;
        let noise = NoiseModel { interstitial_lag, ..self.noise };
        Self { noise, lag_decay: noise.lag_decay(), ..self.clone() }.prepared()
    }

    /// The step of the body, where it is the ODE.
    pub(crate) fn euler(&self) -> Option<&Euler> {
        match &self.stepper {
            Stepper::Ode(euler) => Some(euler),
            Stepper::Other(_) => None,
        }
    }

    /// Share of the distance between interstitial and plasma glucose that is left after one step.
    pub(crate) fn lag_decay(&self) -> f64 {
        self.lag_decay
    }

    /// A free run from a state. `euler` is the model's step.
    pub(crate) fn plain_run<'a>(
        &'a self,
        euler: &'a Euler,
        state: &AugmentedState,
    ) -> PlainRun<'a> {
        let (body, interstitial) = (state.body.vector().0, state.interstitial.0);
        PlainRun { model: self, euler, body, flux: state.flux, interstitial }
    }

    /// The noise settings.
    #[must_use]
    pub fn noise(&self) -> &NoiseModel {
        &self.noise
    }

    /// The expected reading of a state, mg/dL.
    #[inline(always)]
    #[must_use]
    pub fn reading(&self, state: &AugmentedState, modulation: &Modulation) -> f64 {
        state.interstitial.0 * modulation[Field::SensorGain]
            + modulation[Field::SensorOffset]
            + state.sensor.0
    }

    /// The expected state one step later.
    ///
    /// The flux is held through the step and then decays; interstitial glucose follows the mean of
    /// plasma glucose at both ends of the step.
    ///
    /// # Errors
    /// As [`ode_sim::OdePlant::advance`].
    #[inline]
    pub fn step(
        &self,
        state: &AugmentedState,
        input: &StepInput,
        modulation: &Modulation,
    ) -> Result<AugmentedState, OdeError> {
        if modulation.is_neutral() {
            let body = self.stepper.advance(&self.person, &state.body, input, state.flux)?;
            return Ok(self.around(state, body, self.lag_decay));
        }
        let acting = self.acting(state, input, modulation);
        let Acting { person, stepper, input, flux, .. } = &acting;
        let body = stepper.advance(person, &state.body, input, *flux)?;
        Ok(self.around(state, body, acting.lag_decay))
    }

    /// The expected state one step later and the derivative by the state before.
    ///
    /// What a modulation makes depend on glucose (counter-regulation, the kidneys) is held while the
    /// derivative is taken: it acts above its share in few steps, and the gains need no more.
    ///
    /// # Errors
    /// As [`ode_sim::OdePlant::linearised`].
    #[inline]
    pub fn linearised(
        &self,
        state: &AugmentedState,
        input: &StepInput,
        modulation: &Modulation,
    ) -> Result<(AugmentedState, Transition), OdeError> {
        let mut transition = Transition::default();
        let following = self.linearised_into(state, input, modulation, &mut transition)?;
        Ok((following, transition))
    }

    /// As [`linearised`](Self::linearised); `transition` becomes the derivative.
    #[inline(always)]
    pub(crate) fn linearised_into(
        &self,
        state: &AugmentedState,
        input: &StepInput,
        modulation: &Modulation,
        transition: &mut Transition,
    ) -> Result<AugmentedState, OdeError> {
        if let (Stepper::Ode(euler), Some(resting)) = (&self.stepper, &self.resting)
            && modulation.is_neutral()
            && Euler::covers(&state.body, input)
        {
            let x = state.body.vector();
            let following = OdeVector(euler.step(&x.0, euler.doses(input), state.flux));
            if following.first_non_finite().is_none() {
                let (glucose, distant) = euler.varying_slopes(&x.0);
                *transition = *resting;
                transition.vary(glucose, distant, self.share_at(self.lag_decay));
                let body = state.body.with_vector(&following);
                return Ok(self.around(state, body, self.lag_decay));
            }
        }
        let (following, found) = self.linearised_afresh(state, input, modulation)?;
        *transition = found;
        Ok(following)
    }

    #[inline(never)]
    fn linearised_afresh(
        &self,
        state: &AugmentedState,
        input: &StepInput,
        modulation: &Modulation,
    ) -> Result<(AugmentedState, Transition), OdeError> {
        if modulation.is_neutral() {
            let (body, slopes) =
                self.stepper.linearised(&self.person, &state.body, input, state.flux)?;
            let transition = self.transition(&slopes, self.lag_decay);
            return Ok((self.around(state, body, self.lag_decay), transition));
        }
        let Acting { person, stepper, input, flux, lag_decay } =
            self.acting(state, input, modulation);
        let (body, slopes) = stepper.linearised(&person, &state.body, &input, flux)?;
        let transition = self.transition(&slopes, lag_decay);
        Ok((self.around(state, body, lag_decay), transition))
    }

    /// The body's derivative with those of the flux, the lag and the sensor around it.
    #[inline]
    fn transition(&self, slopes: &BodySlopes, lag_decay: f64) -> Transition {
        let share = self.share_at(lag_decay);
        Transition::of(slopes, self.flux_decay, lag_decay, share, self.sensor_coefficients)
    }

    /// The state corrected by `gain` times `innovation`, cut off at [`GLUCOSE_FLOOR`].
    #[inline(always)]
    #[must_use]
    pub fn corrected(
        &self,
        state: &AugmentedState,
        gain: &[f64; STATES],
        innovation: f64,
    ) -> AugmentedState {
        let mut x = state.body.vector();
        for (value, k) in x.0.iter_mut().zip(gain) {
            *value += k * innovation;
        }
        x[Q1] = x[Q1].max(self.person.q1_at(GLUCOSE_FLOOR));
        AugmentedState {
            body: state.body.with_vector(&x),
            flux: state.flux + gain[FLUX] * innovation,
            interstitial: MgPerDl(state.interstitial.0 + gain[INTERSTITIAL] * innovation),
            sensor: MgPerDl(state.sensor.0 + gain[SENSOR] * innovation),
            sensor_before: MgPerDl(state.sensor_before.0 + gain[SENSOR_BEFORE] * innovation),
        }
    }

    /// Uncertainty of what is eaten at the start of a step; enters before it is propagated.
    #[inline(always)]
    pub fn add_meal_noise(&self, p: &mut Covariance, input: &StepInput) {
        let [_, eaten] = self.stepper.doses(&self.person, input);
        let sd = self.noise.carb_count_cv * eaten;
        p.add(slot(C1), sd * sd);
    }

    /// Noise that comes in during a step; enters after propagation to `following`.
    #[inline(always)]
    pub fn add_process_noise(
        &self,
        p: &mut Covariance,
        input: &StepInput,
        following: &AugmentedState,
    ) {
        let noise = &self.noise;
        let [infused, _] = self.stepper.doses(&self.person, input);
        p.add(slot(S1), (noise.insulin_cv * infused).powi(2));
        let x = following.body.vector();
        for effect in [X1, X2, X3] {
            p.add(slot(effect), (noise.effect_cv * x[effect]).powi(2));
        }
        p.add(slot(Q1), noise.glucose_sd.powi(2));
        p.add(FLUX, noise.flux_sd.powi(2) * (1.0 - self.flux_decay.powi(2)));
        p.add(SENSOR, self.sensor_noise);
    }

    /// A start for the filter: insulin at rest under `basal`, glucose as read, the gut empty.
    ///
    /// The standard deviations are wide (30 % of insulin and its effects, 20 mg/dL of glucose,
    /// 0.3 mmol/kg in each gut compartment, about 4 g); the first hours are not scored.
    #[must_use]
    pub fn start(&self, basal: UnitsPerHour, glucose: MgPerDl) -> (AugmentedState, Covariance) {
        let OdePlant { parameters, weight, .. } = &self.person;
        let q1 = self.person.q1_at(glucose);
        let mut x = held_by(parameters, q1, infusion(basal.0, weight.0));
        let mut gut_sd = [GUT_SD; 2];
        if let Stepper::Other(body) = &self.stepper {
            x = body.at_rest(&self.person, x, basal);
            gut_sd = body.gut_sd(&self.person, GUT_SD);
        }
        let mut sd = [0.0; STATES];
        for compartment in [S1, S2, I, X1, X2, X3, Q2] {
            sd[slot(compartment)] = 0.3 * x[compartment].abs();
        }
        sd[slot(Q1)] = self.person.q1_at(MgPerDl(20.0));
        [sd[slot(C1)], sd[slot(C2)]] = gut_sd;
        sd[FLUX] = self.noise.flux_sd;
        sd[INTERSTITIAL] = 20.0;
        sd[SENSOR] = self.noise.sensor_sd;
        sd[SENSOR_BEFORE] = self.noise.sensor_sd;
        let mut covariance = Covariance::diagonal(&sd);
        let linked = self.noise.sensor_sd.powi(2) * self.noise.sensor_correlation;
        covariance.link(SENSOR, SENSOR_BEFORE, linked);
        let body = OdeState::default().with_vector(&x);
        (AugmentedState { body, interstitial: glucose, ..AugmentedState::default() }, covariance)
    }

    /// mg/dL that interstitial glucose gains in a step per mmol/kg of Q1 at both of its ends, halved, where a share
    /// of its distance to plasma glucose is left after the step.
    #[inline(always)]
    pub(crate) fn share_at(&self, lag_decay: f64) -> f64 {
        0.5 * (1.0 - lag_decay) * self.glucose_per_q1()
    }

    #[inline(always)]
    fn glucose_per_q1(&self) -> f64 {
        MG_PER_DL_PER_MMOL_PER_L / self.person.parameters.v_g
    }

    /// Person, input and flux of a step under a modulation.
    pub(crate) fn acting(
        &self,
        state: &AugmentedState,
        input: &StepInput,
        modulation: &Modulation,
    ) -> Acting {
        let p = self.person.parameters;
        let depth = low_depth(state.interstitial);
        let counter = 1.0 + modulation[Field::LowGlucoseProduction] * depth;
        let parameters = OdeParameters {
            t_max_i: p.t_max_i * modulation[Field::InsulinTime],
            t_max_g: p.t_max_g * modulation[Field::GutTime],
            s_f1: p.s_f1 * modulation[Field::Action],
            s_f2: p.s_f2 * modulation[Field::Action],
            s_f3: p.s_f3 * modulation[Field::LiverAction],
            egp_0: p.egp_0 * modulation[Field::Production] * counter,
            ..p
        };
        let delivered = modulation[Field::InsulinInput];
        let input = StepInput {
            basal: UnitsPerHour(input.basal.0 * delivered),
            bolus: Units(input.bolus.0 * delivered),
            carbs: Grams(
                input.carbs.0 * modulation[Field::CarbAmount] + modulation[Field::ExtraCarbs],
            ),
            ..*input
        };
        let g = state.body.q1 / p.v_g;
        let shift = modulation[Field::RenalThreshold] / MG_PER_DL_PER_MMOL_PER_L;
        let cleared = modulation[Field::RenalRate]
            * RENAL_RATE
            * (g - RENAL_THRESHOLD - shift).max(0.0)
            * p.v_g
            - renal_clearance(g, p.v_g);
        let person = OdePlant { parameters, ..self.person };
        let stepper = match &self.stepper {
            Stepper::Ode(euler) => Stepper::Ode(euler.modulated(&self.person, &person)),
            other => other.clone(),
        };
        Acting {
            person,
            stepper,
            input,
            flux: state.flux + modulation[Field::Flux] - cleared,
            lag_decay: match modulation[Field::SensorLag] {
                1.0 => self.lag_decay,
                factor => self.lag_decay.powf(1.0 / factor),
            },
        }
    }

    /// The state in reporting units; plasma glucose is reported.
    pub fn report(&self, state: &AugmentedState) -> States {
        match &self.stepper {
            Stepper::Ode(_) => self.person.report(&state.body),
            Stepper::Other(body) => body.report(&self.person, &state.body),
        }
    }

    #[inline(always)]
    fn around(&self, state: &AugmentedState, body: OdeState, lag_decay: f64) -> AugmentedState {
        let plasma = 0.5 * (self.person.glucose(&state.body).0 + self.person.glucose(&body).0);
        let [first, second] = self.sensor_coefficients;
        AugmentedState {
            body,
            flux: state.flux * self.flux_decay,
            interstitial: MgPerDl(plasma + (state.interstitial.0 - plasma) * lag_decay),
            sensor: MgPerDl(first * state.sensor.0 + second * state.sensor_before.0),
            sensor_before: state.sensor,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn model() -> AugmentedModel {
        AugmentedModel::new(OdeParameters::nominal(), Kilograms(76.3), NoiseModel::working())
    }

    proptest! {
        #[test]
        fn the_transition_is_the_derivative_of_the_step(
            glucose in 45.0..380.0f64, basal in 0.3..3.0f64, flux in -0.01..0.01f64,
            gut in 0.0..5.0f64, carbs in 0.0..90.0f64, bolus in 0.0..10.0f64,
        ) {
            // Away from the kinks of uptake (81 mg/dL) and renal clearance (162 mg/dL).
            prop_assume!((glucose - 81.0).abs() > 1.0 && (glucose - 162.0).abs() > 1.0);
            let model = model();
            let (mut state, _) = model.start(UnitsPerHour(basal), MgPerDl(glucose));
            prop_assume!((state.body.x3 - 1.0).abs() > 0.01);
            state.flux = flux;
            state.body.meals.c1 = gut;
            state.body.meals.c2 = 0.5 * gut;
            state.interstitial = MgPerDl(glucose - 10.0);
            state.sensor = MgPerDl(4.0);
            state.sensor_before = MgPerDl(3.0);
            let input = StepInput {
                basal: UnitsPerHour(basal), bolus: Units(bolus), carbs: Grams(carbs),
                ..StepInput::default()
            };
            let (following, transition) = model.linearised(&state, &input, &Modulation::NEUTRAL).expect("finite");
            prop_assert_eq!(following, model.step(&state, &input, &Modulation::NEUTRAL).expect("finite"));
            let afresh = model.linearised_afresh(&state, &input, &Modulation::NEUTRAL).expect("finite");
            prop_assert_eq!((following, transition), afresh);
            let x = state.vector();
            for column in 0..STATES {
                // A step that balances truncation (the model is quadratic) against rounding.
                let h = 1e-4 * x[column].abs().max(1e-3);
                let moved = |by: f64| {
                    let mut y = x;
                    y[column] += by;
                    model.step(&state.with_vector(&y), &input, &Modulation::NEUTRAL).expect("finite").vector()
                };
                let (above, below) = (moved(h), moved(-h));
                for row in 0..STATES {
                    let slope = (above[row] - below[row]) / (2.0 * h);
                    let found = transition.get(row, column);
                    // Rounding of values up to 400 over 2h.
                    let tolerance = 1e-6 * found.abs().max(1.0) + 1e-13 * 400.0 / h;
                    prop_assert!((slope - found).abs() < tolerance,
                        "row {} column {}: {} against {}", row, column, found, slope);
                    if !Transition::NONZERO[row].contains(&column) {
                        prop_assert_eq!(found, 0.0, "row {} column {}", row, column);
                    }
                }
            }
        }
    }

    #[test]
    fn a_start_at_rest_stays_at_rest_in_insulin() {
        let model = model();
        let (start, _) = model.start(UnitsPerHour(1.0), MgPerDl(120.0));
        let input = StepInput { basal: UnitsPerHour(1.0), ..StepInput::default() };
        let next = model.step(&start, &input, &Modulation::NEUTRAL).expect("finite");
        for compartment in [S1, S2, I, X1, X2, X3] {
            let (a, b) = (start.body.vector()[compartment], next.body.vector()[compartment]);
            assert!((a - b).abs() <= 1e-12 * a.abs(), "{compartment}: {a} to {b}"); // rounding
        }
    }

    #[test]
    fn a_correction_does_not_push_glucose_below_the_floor() {
        let model = model();
        let (start, _) = model.start(UnitsPerHour(1.0), MgPerDl(60.0));
        let mut gain = [0.0; STATES];
        gain[slot(Q1)] = 1.0;
        let low = model.corrected(&start, &gain, -50.0);
        assert!((model.person().glucose(&low.body).0 - GLUCOSE_FLOOR.0).abs() < 1e-12);
    }
}
