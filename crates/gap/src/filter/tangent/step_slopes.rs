//! Derivatives of one step of the model by its parameters and by the fields of a modulation, written down.
//!
//! They follow the equations of [`ode_sim::equations::derivative`], the gut's exact flow and the sensor's lag:
//! a design asks for hundreds of thousands of them, and differences would take a step each.

use effects::{Field, Modulation};
use ode_sim::equations::{
    RENAL_RATE, RENAL_THRESHOLD, UPTAKE_SATURATION, endogenous_production, infusion,
    non_insulin_uptake,
};
use ode_sim::{OdeParameters, slot};
use physiology::{Compartment, MG_PER_DL_PER_MMOL_PER_L, Plant as _, STEP, StepInput};

use super::Parameter;
use crate::filter::augmented::{Acting, AugmentedModel, Euler, Stepper, low_depth};
use crate::filter::state::{AugmentedState, INTERSTITIAL};

/// The derivative of some states after a step, in the order of [`changed`] or [`reached`]; what comes after their last
/// is not read.
type Slope = [f64; 4];

const S1: usize = slot(Compartment::S1);
const S2: usize = slot(Compartment::S2);
const I: usize = slot(Compartment::I);
const X1: usize = slot(Compartment::X1);
const X2: usize = slot(Compartment::X2);
const X3: usize = slot(Compartment::X3);
const Q1: usize = slot(Compartment::Q1);
const Q2: usize = slot(Compartment::Q2);
const C1: usize = slot(Compartment::C1);
const C2: usize = slot(Compartment::C2);

/// The states that a parameter changes within a step.
pub(super) const fn changed(parameter: Parameter) -> &'static [usize] {
    match parameter {
        Parameter::Action => &[X1, X2, X3],
        Parameter::Egp0 | Parameter::F01 | Parameter::VG => &[Q1, INTERSTITIAL],
        Parameter::TMaxG => &[Q1, INTERSTITIAL, C1, C2],
        Parameter::TMaxI => &[S1, S2, I],
        Parameter::AG => &[C1, C2],
        Parameter::KA1 => &[X1],
        Parameter::KA2 => &[X2],
        Parameter::KA3 => &[X3],
        Parameter::K12 => &[Q1, INTERSTITIAL, Q2],
        Parameter::KE => &[I],
    }
}

/// The states that a field changes within a step.
pub(super) const fn reached(field: Field) -> &'static [usize] {
    match field {
        Field::InsulinInput => &[S1],
        Field::InsulinTime => &[S1, S2, I],
        Field::Action => &[X1, X2],
        Field::LiverAction => &[X3],
        Field::GutTime => &[Q1, INTERSTITIAL, C1, C2],
        Field::CarbAmount | Field::ExtraCarbs => &[C1, C2],
        Field::Production
        | Field::Flux
        | Field::LowGlucoseProduction
        | Field::RenalRate
        | Field::RenalThreshold => &[Q1, INTERSTITIAL],
        Field::SensorLag => &[INTERSTITIAL],
        Field::SensorGain | Field::SensorOffset => &[],
    }
}

/// A step without exercise and rescue carbohydrate.
///
/// It is made for every step of every run that carries directions along: what few of them need is worked out when it is
/// asked for.
pub(super) struct StepSlopes<'a> {
    model: &'a AugmentedModel,
    state: &'a AugmentedState,
    input: &'a StepInput,
    modulation: &'a Modulation,
    following: &'a AugmentedState,
    /// Parameters and step, modulated and not.
    p: &'a OdeParameters,
    euler: &'a Euler,
    own: &'a Euler,
    /// What is eaten, mmol/kg.
    meal: f64,
    /// Share of the distance between interstitial and plasma glucose that is left after the step.
    lag_decay: f64,
    /// mg/dL of interstitial glucose in a mmol/kg that Q1 has gained at the end of the step.
    share: f64,
}

impl<'a> StepSlopes<'a> {
    /// Of the step from `state` to `following`; `None` where a difference has to be taken, as for any body
    /// but the ODE. `scratch` keeps what acts under a modulation.
    #[inline(always)]
    pub(super) fn of(
        model: &'a AugmentedModel,
        state: &'a AugmentedState,
        input: &'a StepInput,
        modulation: &'a Modulation,
        following: &'a AugmentedState,
        scratch: &'a mut Option<Acting>,
    ) -> Option<Self> {
        let own = model.euler().filter(|_| Euler::covers(&state.body, input))?;
        let (p, euler, carbs, lag_decay) = if modulation.is_neutral() {
            (&model.person().parameters, own, input.carbs, model.lag_decay())
        } else {
            let acting = scratch.insert(model.acting(state, input, modulation));
            let Stepper::Ode(euler) = &acting.stepper else { return None };
            (&acting.person.parameters, euler, acting.input.carbs, acting.lag_decay)
        };
        Some(Self {
            model,
            state,
            input,
            modulation,
            following,
            p,
            euler,
            own,
            meal: euler.per_gram * carbs.0,
            lag_decay,
            share: model.share_at(lag_decay),
        })
    }

    /// By the logarithm of a parameter.
    #[inline(always)]
    pub(super) fn by_parameter(&self, parameter: Parameter) -> Slope {
        let (p, x) = (self.p, &self.state.body);
        match parameter {
            Parameter::Action => self.action(self.euler),
            Parameter::Egp0 => self.glucose(self.production(p.egp_0)),
            Parameter::F01 => self.glucose(-non_insulin_uptake(self.concentration(), p.f_01)),
            Parameter::TMaxI => self.insulin_time(),
            Parameter::AG => self.eaten(self.meal),
            Parameter::TMaxG => self.gut_time(),
            Parameter::KA1 => one(STEP.0 * p.k_a1 * (p.s_f1 * x.i - x.x1)),
            Parameter::KA2 => one(STEP.0 * p.k_a2 * (p.s_f2 * x.i - x.x2)),
            Parameter::KA3 => one(STEP.0 * p.k_a3 * (p.s_f3 * x.i - x.x3)),
            Parameter::K12 => {
                let flow = p.k_12 * x.q2;
                let mut slope = self.glucose(flow);
                slope[2] = -STEP.0 * flow;
                slope
            }
            Parameter::KE => one(-STEP.0 * p.k_e * x.i),
            Parameter::VG => {
                let g = self.concentration();
                // The same amount is a lower concentration.
                let uptake =
                    if g < UPTAKE_SATURATION { non_insulin_uptake(g, p.f_01) } else { 0.0 };
                let threshold = self.renal_threshold();
                let cleared =
                    if g > threshold { self.renal_rate() * threshold * p.v_g } else { 0.0 };
                let mut slope = self.glucose(uptake + cleared);
                slope[1] -= (1.0 - self.lag_decay) * self.plasma();
                slope
            }
        }
    }

    /// By a field that changes the state.
    pub(super) fn by_field(&self, field: Field) -> Slope {
        let (p, plain) = (self.p, self.model.person());
        let factor = self.modulation[field];
        match field {
            Field::InsulinInput => one(STEP.0 * infusion(self.input.insulin().0, plain.weight.0)),
            Field::InsulinTime => self.insulin_time().map(|value| value / factor),
            Field::Action => self.action(self.own),
            Field::LiverAction => one(self.action(self.own)[2]),
            Field::Production => {
                let depth = low_depth(self.state.interstitial);
                let counter = 1.0 + self.modulation[Field::LowGlucoseProduction] * depth;
                self.glucose(self.production(plain.parameters.egp_0 * counter))
            }
            Field::GutTime => self.gut_time().map(|value| value / factor),
            Field::CarbAmount => self.eaten(self.input.carbs.0 * self.euler.per_gram),
            Field::ExtraCarbs => self.eaten(self.euler.per_gram),
            Field::Flux => self.glucose(1.0),
            Field::LowGlucoseProduction => {
                let full = plain.parameters.egp_0 * self.modulation[Field::Production];
                self.glucose(self.production(full * low_depth(self.state.interstitial)))
            }
            Field::RenalRate => self.glucose(-RENAL_RATE * self.over_threshold() * p.v_g),
            Field::RenalThreshold => {
                let rate = if self.over_threshold() > 0.0 { self.renal_rate() } else { 0.0 };
                self.glucose(rate * p.v_g / MG_PER_DL_PER_MMOL_PER_L)
            }
            Field::SensorLag => {
                let ahead = self.state.interstitial.0 - self.plasma();
                let lag = self.model.noise().interstitial_lag;
                one(ahead * self.lag_decay * STEP.0 / (lag * factor * factor))
            }
            // What changes the reading alone.
            Field::SensorGain | Field::SensorOffset => [0.0; 4],
        }
    }

    /// A flux into Q1, mmol/kg/min, and what interstitial glucose makes of it.
    #[inline(always)]
    fn glucose(&self, flux: f64) -> Slope {
        let gained = STEP.0 * flux;
        [gained, self.share * gained, 0.0, 0.0]
    }

    /// Plasma glucose before the step, mmol/L.
    #[inline(always)]
    fn concentration(&self) -> f64 {
        self.state.body.q1 / self.p.v_g
    }

    /// Plasma glucose that interstitial glucose follows, mg/dL.
    fn plasma(&self) -> f64 {
        let person = self.model.person();
        0.5 * (person.glucose(&self.state.body).0 + person.glucose(&self.following.body).0)
    }

    /// Endogenous production, mmol/kg/min.
    #[inline(always)]
    fn production(&self, egp_0: f64) -> f64 {
        endogenous_production(self.state.body.x3, egp_0, self.model.person().egp)
    }

    /// By a common factor on the three sensitivities, on X1, X2 and X3.
    #[inline(always)]
    fn action(&self, euler: &Euler) -> Slope {
        let (i, [first, second, third]) = (self.state.body.i, euler.effect_on);
        [first * i, second * i, third * i, 0.0]
    }

    /// By the logarithm of the time of insulin absorption.
    #[inline(always)]
    fn insulin_time(&self) -> Slope {
        let (x, euler) = (&self.state.body, self.euler);
        [euler.depot_on * x.s1, euler.depot_on * (x.s2 - x.s1), -euler.plasma_on * x.s2, 0.0]
    }

    /// By the logarithm of the time of meal absorption.
    #[inline(always)]
    fn gut_time(&self) -> Slope {
        let (x, euler) = (&self.state.body, self.euler);
        let (turns, left, fed) = (euler.gut_on, euler.gut_left, x.meals.c1 + self.meal);
        let appearing = -turns * x.meals.c2;
        [
            appearing,
            self.share * appearing,
            left * turns * fed,
            left * turns * (x.meals.c2 + fed * turns - fed),
        ]
    }

    /// Carbohydrate eaten at the start of the step, mmol/kg.
    #[inline(always)]
    fn eaten(&self, amount: f64) -> Slope {
        let left = self.euler.gut_left * amount;
        [left, left * self.euler.gut_on, 0.0, 0.0]
    }

    /// Renal clearance, 1/min.
    fn renal_rate(&self) -> f64 {
        self.modulation[Field::RenalRate] * RENAL_RATE
    }

    /// Glucose above which the kidneys clear it, mmol/L.
    fn renal_threshold(&self) -> f64 {
        RENAL_THRESHOLD + self.modulation[Field::RenalThreshold] / MG_PER_DL_PER_MMOL_PER_L
    }

    /// Glucose over that, mmol/L; 0 below.
    fn over_threshold(&self) -> f64 {
        (self.concentration() - self.renal_threshold()).max(0.0)
    }
}

fn one(value: f64) -> Slope {
    [value, 0.0, 0.0, 0.0]
}

#[cfg(test)]
mod tests {
    use ode_sim::equations::{Forcing, derivative, infusion};
    use ode_sim::{Dual, EgpMode, OdeState, OdeVector};
    use physiology::{Grams, Kilograms, MgPerDl, Units, UnitsPerHour};
    use proptest::prelude::*;

    use super::*;
    use crate::filter::noise::NoiseModel;

    const PARAMETERS: [Parameter; 12] = [
        Parameter::Action,
        Parameter::Egp0,
        Parameter::TMaxG,
        Parameter::TMaxI,
        Parameter::AG,
        Parameter::F01,
        Parameter::KA1,
        Parameter::KA2,
        Parameter::KA3,
        Parameter::K12,
        Parameter::KE,
        Parameter::VG,
    ];

    proptest! {
        #[test]
        fn by_parameters_they_are_the_derivatives_of_the_equations(
            insulin in prop::array::uniform3(0.0..30.0f64), x1 in 0.0..0.05f64, x2 in 0.0..0.05f64,
            x3 in 0.0..1.6f64, q1 in 0.2..4.0f64, q2 in 0.2..4.0f64,
            gut in prop::array::uniform2(0.0..5.0f64), bolus in 0.0..9.0f64, flux in -0.02..0.02f64,
        ) {
            let (p, weight) = (OdeParameters::nominal(), Kilograms(71.0));
            let model = AugmentedModel::new(p, weight, NoiseModel::working());
            let [s1, s2, i] = insulin;
            let x = [s1, s2, i, x1, x2, x3, q1, q2, gut[0], gut[1]];
            let (start, _) = model.start(UnitsPerHour(1.0), MgPerDl(120.0));
            let body = OdeState::default().with_vector(&OdeVector(x));
            let state = AugmentedState { body, flux, ..start };
            let input = StepInput {
                basal: UnitsPerHour(1.1), bolus: Units(bolus), carbs: Grams(0.0), ..StepInput::default()
            };
            let following = model.step(&state, &input, &Modulation::NEUTRAL).expect("finite");
            let mut scratch = None;
            let known = StepSlopes::of(&model, &state, &input, &Modulation::NEUTRAL, &following, &mut scratch)
                .expect("an Euler step");
            let insulin = infusion(input.insulin().0, weight.0);
            let forcing = Forcing { insulin, glucose_flux: flux, ..Forcing::default() };
            for parameter in PARAMETERS {
                let varied = parameter.times(&p.map(Dual::<1>::from), Dual::variable(1.0, 0));
                let rates = derivative(&varied, &OdeVector(x.map(Dual::from)), &forcing, EgpMode::NonNegative);
                let states = changed(parameter).iter().zip(known.by_parameter(parameter));
                let mut found = [0.0; C1];
                // The gut's flow is exact, and interstitial glucose is no compartment.
                for (state, slope) in states.filter(|(state, _)| **state < C1) {
                    found[*state] = slope;
                }
                for (state, found) in found.into_iter().enumerate() {
                    let expected = STEP.0 * rates.0[state].slopes[0];
                    prop_assert!((found - expected).abs() < 1e-12 * expected.abs().max(1.0),
                        "{parameter:?}, state {state}: {found} against {expected}");
                }
            }
        }
    }
}
