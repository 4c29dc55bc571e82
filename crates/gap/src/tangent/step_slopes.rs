//! Derivatives of one step of the model by its parameters and by the fields of a modulation, written down.
//!
//! They follow the equations of [`ode_sim::equations::derivative`], the gut's exact flow and the sensor's lag:
//! a design asks for hundreds of thousands of them, and differences would take a step each.

use effects::{Field, Modulation};
use ode_sim::equations::{
    RENAL_RATE, RENAL_THRESHOLD, UPTAKE_SATURATION, endogenous_production, infusion,
    non_insulin_uptake,
};
use ode_sim::{EgpMode, OdeParameters, OdeState, slot};
use physiology::Compartment;
use physiology::{MG_PER_DL_PER_MMOL_PER_L, Plant as _, STEP, StepInput};

use super::Parameter;
use crate::augmented::{Acting, AugmentedModel, AugmentedState, Euler, INTERSTITIAL, low_depth};

/// The derivative of some states after a step, in the order of [`changed`] or [`reached`]; 0 after their last.
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
pub(super) struct StepSlopes<'a> {
    /// Parameters, modulated and not.
    p: &'a OdeParameters,
    plain: &'a OdeParameters,
    body: &'a OdeState,
    modulation: &'a Modulation,
    egp: EgpMode,
    /// Insulin on record, mU/kg/min.
    infusion: f64,
    /// What a gram adds to the gut, mmol/kg.
    gram: f64,
    /// Carbohydrate on record, g.
    logged: f64,
    /// What is eaten, mmol/kg.
    meal: f64,
    /// Share of the gut's content that stays through the step.
    left: f64,
    /// Share of the distance between interstitial and plasma glucose that is left after the step.
    lag_decay: f64,
    /// Time constant of the lag on record, min.
    lag: f64,
    /// Plasma glucose that interstitial glucose follows, mg/dL.
    plasma: f64,
    /// Interstitial glucose before the step over that, mg/dL.
    ahead: f64,
    /// Share of counter-regulation that is called up.
    depth: f64,
}

impl<'a> StepSlopes<'a> {
    /// Of the step from `state` to `following`; `None` where a difference has to be taken, as for any body
    /// but the ODE. `room` is for what acts under a modulation.
    pub(super) fn of(
        model: &'a AugmentedModel,
        state: &'a AugmentedState,
        input: &StepInput,
        modulation: &'a Modulation,
        following: &AugmentedState,
        room: &'a mut Option<Acting>,
    ) -> Option<Self> {
        let (body, plain) = (&state.body, model.plant());
        let own = model.euler().filter(|_| Euler::covers(body, input))?;
        let (p, euler, carbs, lag_decay) = if modulation.is_neutral() {
            (&plain.parameters, own, input.carbs, model.lag_decay())
        } else {
            let acting = room.insert(model.acting(state, input, modulation));
            (&acting.plant.parameters, &acting.euler, acting.input.carbs, acting.lag_decay)
        };
        let plasma = 0.5 * (plain.glucose(body).0 + plain.glucose(&following.body).0);
        Some(Self {
            p,
            plain: &plain.parameters,
            body,
            modulation,
            egp: plain.egp,
            infusion: infusion(input.insulin().0, plain.weight.0),
            gram: euler.per_gram,
            logged: input.carbs.0,
            meal: euler.per_gram * carbs.0,
            left: euler.gut_left,
            lag_decay,
            lag: model.noise().interstitial_lag,
            plasma,
            ahead: state.interstitial.0 - plasma,
            depth: low_depth(state.interstitial),
        })
    }

    /// By the logarithm of a parameter.
    pub(super) fn by_parameter(&self, parameter: Parameter) -> Slope {
        let (p, x) = (self.p, self.body);
        match parameter {
            Parameter::Action => {
                let [x1, x2, x3] = self.action(p);
                [x1, x2, x3, 0.0]
            }
            Parameter::Egp0 => self.glucose(self.production(p.egp_0)),
            Parameter::F01 => self.glucose(-non_insulin_uptake(x.q1 / p.v_g, p.f_01)),
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
                let g = x.q1 / p.v_g;
                // The same amount is a lower concentration.
                let uptake =
                    if g < UPTAKE_SATURATION { non_insulin_uptake(g, p.f_01) } else { 0.0 };
                let threshold = self.renal_threshold();
                let cleared =
                    if g > threshold { self.renal_rate() * threshold * p.v_g } else { 0.0 };
                let mut slope = self.glucose(uptake + cleared);
                slope[1] -= (1.0 - self.lag_decay) * self.plasma;
                slope
            }
        }
    }

    /// By a field that changes the state.
    pub(super) fn by_field(&self, field: Field) -> Slope {
        let p = self.p;
        let factor = self.modulation[field];
        match field {
            Field::InsulinInput => one(STEP.0 * self.infusion),
            Field::InsulinTime => self.insulin_time().map(|value| value / factor),
            Field::Action => {
                let [x1, x2, _] = self.action(self.plain);
                [x1, x2, 0.0, 0.0]
            }
            Field::LiverAction => one(self.action(self.plain)[2]),
            Field::Production => {
                let counter = 1.0 + self.modulation[Field::LowGlucoseProduction] * self.depth;
                self.glucose(self.production(self.plain.egp_0 * counter))
            }
            Field::GutTime => self.gut_time().map(|value| value / factor),
            Field::CarbAmount => self.eaten(self.logged * self.gram),
            Field::ExtraCarbs => self.eaten(self.gram),
            Field::Flux => self.glucose(1.0),
            Field::LowGlucoseProduction => {
                let full = self.plain.egp_0 * self.modulation[Field::Production];
                self.glucose(self.production(full * self.depth))
            }
            Field::RenalRate => self.glucose(-RENAL_RATE * self.over_threshold() * p.v_g),
            Field::RenalThreshold => {
                let cleared = self.over_threshold() > 0.0;
                let rate = if cleared { self.renal_rate() } else { 0.0 };
                self.glucose(rate * p.v_g / MG_PER_DL_PER_MMOL_PER_L)
            }
            Field::SensorLag => {
                one(self.ahead * self.lag_decay * STEP.0 / (self.lag * factor * factor))
            }
            // What changes the reading alone.
            Field::SensorGain | Field::SensorOffset => [0.0; 4],
        }
    }

    /// A flux into Q1, mmol/kg/min, and what interstitial glucose makes of it.
    fn glucose(&self, flux: f64) -> Slope {
        let gained = STEP.0 * flux;
        let share = 0.5 * (1.0 - self.lag_decay) * MG_PER_DL_PER_MMOL_PER_L / self.p.v_g;
        [gained, share * gained, 0.0, 0.0]
    }

    /// Endogenous production, mmol/kg/min.
    fn production(&self, egp_0: f64) -> f64 {
        endogenous_production(self.body.x3, egp_0, self.egp)
    }

    /// By a common factor on the three sensitivities, on X1, X2 and X3.
    fn action(&self, p: &OdeParameters) -> [f64; 3] {
        [p.k_a1 * p.s_f1, p.k_a2 * p.s_f2, p.k_a3 * p.s_f3].map(|rate| STEP.0 * rate * self.body.i)
    }

    /// By the logarithm of the time of insulin absorption.
    fn insulin_time(&self) -> Slope {
        let (p, x) = (self.p, self.body);
        [
            STEP.0 * x.s1 / p.t_max_i,
            STEP.0 * (x.s2 - x.s1) / p.t_max_i,
            -STEP.0 * x.s2 / (p.t_max_i * p.v_i),
            0.0,
        ]
    }

    /// By the logarithm of the time of meal absorption.
    fn gut_time(&self) -> Slope {
        let (p, x) = (self.p, self.body);
        let (turns, fed) = (STEP.0 / p.t_max_g, x.meals.c1 + self.meal);
        let mut slope = self.glucose(-x.meals.c2 / p.t_max_g);
        slope[2] = self.left * turns * fed;
        slope[3] = self.left * turns * (x.meals.c2 + fed * turns - fed);
        slope
    }

    /// Carbohydrate eaten at the start of the step, mmol/kg.
    fn eaten(&self, amount: f64) -> Slope {
        let left = self.left * amount;
        [left, left * STEP.0 / self.p.t_max_g, 0.0, 0.0]
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
        (self.body.q1 / self.p.v_g - self.renal_threshold()).max(0.0)
    }
}

fn one(value: f64) -> Slope {
    [value, 0.0, 0.0, 0.0]
}
