//! A forward Euler step of the ODE with everything worked out beforehand that does not change between steps.
//!
//! It is [`OdePlant::advance`] without exercise and rescue carbohydrate, to rounding, where production is never
//! negative. A filter takes the same step hundreds of thousands of times, and divisions and exponentials would take
//! most of its time.

use ode_sim::equations::{RENAL_RATE, RENAL_THRESHOLD, UPTAKE_SATURATION, infusion};
use ode_sim::gut::glucose_dose;
use ode_sim::{ExerciseMemory, OdePlant, OdeState, slot};
use physiology::{Compartment, Grams, STEP, StepInput};

use crate::filter::transition::BodySlopes;

/// Number of compartments.
pub(crate) const COMPARTMENTS: usize = slot(Compartment::C2) + 1;

/// The step of one body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Euler {
    /// Shares of S1 and S2 that stay and that move on.
    depot_left: f64,
    pub(crate) depot_on: f64,
    /// mU/L in plasma per mU/kg of S2; share of I that stays.
    pub(crate) plasma_on: f64,
    plasma_left: f64,
    /// X1, X2, X3 per mU/L of insulin; shares that stay.
    pub(crate) effect_on: [f64; 3],
    effect_left: [f64; 3],
    /// Uptake of Q1 besides insulin, mmol/kg: at most, and per mmol/kg of Q1.
    uptake: f64,
    uptake_slope: f64,
    /// Q1 above which the kidneys clear, mmol/kg.
    renal_from: f64,
    /// Share of Q2 that returns.
    returning: f64,
    /// Production without insulin, mmol/kg.
    production: f64,
    /// Share of C1 and C2 that stays; C2 per C1 over that, which is also the share of C2 that appears in Q1 by the rate
    /// at the start of the step.
    pub(crate) gut_left: f64,
    pub(crate) gut_on: f64,
    /// What U/h add to S1, mU/kg, and a gram to C1, mmol/kg.
    per_rate: f64,
    pub(crate) per_gram: f64,
}

/// The share of the clearance of a step, over the threshold.
const RENAL: f64 = STEP.0 * RENAL_RATE;

impl Euler {
    pub(crate) fn of(plant: &OdePlant) -> Self {
        let (p, h) = (&plant.parameters, STEP.0);
        let depot_on = h / p.t_max_i;
        let uptake = h * p.f_01;
        Self {
            depot_left: 1.0 - depot_on,
            depot_on,
            plasma_on: depot_on / p.v_i,
            plasma_left: 1.0 - h * p.k_e,
            effect_on: [h * p.k_a1 * p.s_f1, h * p.k_a2 * p.s_f2, h * p.k_a3 * p.s_f3],
            effect_left: [1.0 - h * p.k_a1, 1.0 - h * p.k_a2, 1.0 - h * p.k_a3],
            uptake,
            uptake_slope: uptake / (UPTAKE_SATURATION * p.v_g),
            renal_from: RENAL_THRESHOLD * p.v_g,
            returning: h * p.k_12,
            production: h * p.egp_0,
            gut_left: (-h / p.t_max_g).exp(),
            gut_on: h / p.t_max_g,
            per_rate: h * infusion(1.0, plant.weight.0),
            per_gram: p.a_g * glucose_dose(Grams(1.0), plant.weight),
        }
    }

    /// The step of a body that differs from this one's in what a modulation changes.
    #[inline]
    pub(crate) fn modulated(&self, own: &OdePlant, changed: &OdePlant) -> Self {
        let (before, p, h) = (&own.parameters, &changed.parameters, STEP.0);
        if p.t_max_g != before.t_max_g {
            return Self::of(changed);
        }
        let mut step = *self;
        if p.t_max_i != before.t_max_i {
            let depot_on = h / p.t_max_i;
            step.depot_left = 1.0 - depot_on;
            step.depot_on = depot_on;
            step.plasma_on = depot_on / p.v_i;
        }
        step.effect_on = [h * p.k_a1 * p.s_f1, h * p.k_a2 * p.s_f2, h * p.k_a3 * p.s_f3];
        step.production = h * p.egp_0;
        step
    }

    /// Whether a step is one of these: without exercise and rescue carbohydrate.
    #[inline]
    pub(crate) fn covers(state: &OdeState, input: &StepInput) -> bool {
        state.exercise == ExerciseMemory::Rest
            && input.exercise.is_none()
            && state.rescue.is_empty()
            && input.rescue.amount.0 == 0.0
    }

    /// What enters S1, mU/kg, and C1, mmol/kg.
    #[inline]
    pub(crate) fn doses(&self, input: &StepInput) -> [f64; 2] {
        [self.per_rate * input.insulin().0, self.per_gram * input.carbs.0]
    }

    /// The ten compartments one step later; `flux` is added to dQ1/dt, mmol/kg/min.
    #[inline(always)]
    pub(crate) fn step(
        &self,
        x: &[f64; COMPARTMENTS],
        doses: [f64; 2],
        flux: f64,
    ) -> [f64; COMPARTMENTS] {
        let [s1, s2, i, x1, x2, x3, q1, q2, c1, c2] = *x;
        let [infused, eaten] = doses;
        let free = if x3 > 1.0 { 0.0 } else { 1.0 - x3 };
        let moving = STEP.0 * x1 * q1;
        let low = self.uptake_slope * q1;
        let uptake = if low < self.uptake { low } else { self.uptake };
        let over = q1 - self.renal_from;
        let cleared = if over > 0.0 { RENAL * over } else { 0.0 };
        let returned = self.returning * q2;
        let fed = c1 + eaten;
        [
            self.depot_left * s1 + infused,
            self.depot_left * s2 + self.depot_on * s1,
            self.plasma_left * i + self.plasma_on * s2,
            self.effect_left[0] * x1 + self.effect_on[0] * i,
            self.effect_left[1] * x2 + self.effect_on[1] * i,
            self.effect_left[2] * x3 + self.effect_on[2] * i,
            q1 + ((self.production * free + self.gut_on * c2 + STEP.0 * flux) - uptake - cleared)
                + (returned - moving),
            q2 + moving - returned - STEP.0 * x2 * q2,
            self.gut_left * fed,
            self.gut_left * (c2 + self.gut_on * fed),
        ]
    }

    /// The derivative of the step by the compartments and by a flux.
    ///
    /// At the kinks (4.5 and 9 mmol/L, X3 = 1) the slope from above for glucose and from below for X3, as in
    /// [`jacobian`](ode_sim::equations::jacobian).
    pub(crate) fn slopes(&self, x: &[f64; COMPARTMENTS]) -> BodySlopes {
        let ([by_x1, by_x3, by_q1], distant) = self.varying_slopes(x);
        let Self { depot_left: stays, depot_on: moves, plasma_on, plasma_left, .. } = *self;
        let ([e1, e2, e3], [l1, l2, l3]) = (self.effect_on, self.effect_left);
        let (left, on) = (self.gut_left, self.gut_on);
        BodySlopes {
            insulin: [stays, moves, stays, plasma_on, plasma_left, e1, l1, e2, l2, e3, l3],
            glucose: [by_x1, by_x3, by_q1, self.returning, on, STEP.0],
            distant,
            gut: [left, left * on, left],
        }
    }

    /// The part of [`slopes`](Self::slopes) that depends on the state: of Q1 by X1, X3 and Q1; of Q2 by X1, X2, Q1
    /// and Q2.
    #[inline(always)]
    pub(super) fn varying_slopes(&self, x: &[f64; COMPARTMENTS]) -> ([f64; 3], [f64; 4]) {
        let [_, _, _, x1, x2, x3, q1, q2, _, _] = *x;
        let by_x3 = if x3 > 1.0 { 0.0 } else { -self.production };
        let taken = if self.uptake_slope * q1 < self.uptake { self.uptake_slope } else { 0.0 };
        let cleared = if q1 >= self.renal_from { RENAL } else { 0.0 };
        let (moving, gone) = (STEP.0 * x1, STEP.0 * q1);
        let kept = 1.0 - moving - taken - cleared;
        let distant = [gone, -STEP.0 * q2, moving, 1.0 - self.returning - STEP.0 * x2];
        ([-gone, by_x3, kept], distant)
    }
}

/// A body let loose, with the flux and interstitial glucose that go with it.
pub(crate) struct PlainRun<'a> {
    pub(super) model: &'a super::AugmentedModel,
    pub(super) euler: &'a Euler,
    pub(super) body: [f64; COMPARTMENTS],
    /// mmol/kg/min.
    pub(super) flux: f64,
    /// mg/dL.
    pub(crate) interstitial: f64,
}

impl PlainRun<'_> {
    /// Carries the run through a step for each of the [`doses`](Euler::doses).
    pub(crate) fn advance(&mut self, doses: &[[f64; 2]]) {
        const Q1: usize = slot(Compartment::Q1);
        let model = self.model;
        let half = 0.5 * model.glucose_per_q1();
        let (mut x, mut flux, mut interstitial) = (self.body, self.flux, self.interstitial);
        for doses in doses {
            let following = self.euler.step(&x, *doses, flux);
            let plasma = half * (x[Q1] + following[Q1]);
            interstitial = plasma + (interstitial - plasma) * model.lag_decay;
            flux *= model.flux_decay;
            x = following;
        }
        (self.body, self.flux, self.interstitial) = (x, flux, interstitial);
    }

    /// Whether the run has not broken.
    pub(crate) fn is_finite(&self) -> bool {
        self.body.iter().chain([&self.interstitial]).all(|value| value.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use ode_sim::equations::{Forcing, jacobian};
    use ode_sim::{EgpMode, OdeParameters, OdeVector};
    use physiology::Compartment::{C2, I, Q1, Q2, S1, S2, X1, X2, X3};
    use physiology::{Kilograms, Units, UnitsPerHour};
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn it_is_the_step_of_the_plant(
            insulin in prop::array::uniform3(0.0..30.0f64), x1 in 0.0..0.05f64, x2 in 0.0..0.05f64,
            x3 in 0.0..1.6f64, q1 in 0.2..4.0f64, q2 in 0.2..4.0f64,
            gut in prop::array::uniform2(0.0..5.0f64), carbs in 0.0..90.0f64, bolus in 0.0..9.0f64,
            flux in -0.02..0.02f64, times in prop::array::uniform2(0.5..2.0f64),
        ) {
            let nominal = OdeParameters::nominal();
            let parameters = OdeParameters {
                t_max_i: nominal.t_max_i * times[0],
                t_max_g: nominal.t_max_g * times[1],
                ..nominal
            };
            let plant = OdePlant {
                egp: EgpMode::NonNegative,
                ..OdePlant::reproduction(parameters, Kilograms(71.0))
            };
            let [s1, s2, i] = insulin;
            let x = [s1, s2, i, x1, x2, x3, q1, q2, gut[0], gut[1]];
            let state = OdeState::default().with_vector(&OdeVector(x));
            let input = StepInput {
                basal: UnitsPerHour(1.1), bolus: Units(bolus), carbs: Grams(carbs),
                ..StepInput::default()
            };
            let euler = Euler::of(&plant);
            prop_assert!(Euler::covers(&state, &input));
            let found = euler.step(&x, euler.doses(&input), flux);
            let expected = plant.advance(&state, &input, flux).expect("finite").vector();
            for (found, expected) in found.iter().zip(expected.0) {
                // Rounding of sums whose terms are at most some hundred.
                prop_assert!((found - expected).abs() < 1e-12, "{} against {}", found, expected);
            }
            let forcing = Forcing::default();
            let j = jacobian(&parameters, &OdeVector(x), &forcing, plant.egp);
            let BodySlopes { insulin, glucose, distant, .. } = euler.slopes(&x);
            let rates = [
                (insulin[0] - 1.0, j[(S1, S1)]), (insulin[1], j[(S2, S1)]), (insulin[2] - 1.0, j[(S2, S2)]),
                (insulin[3], j[(I, S2)]), (insulin[4] - 1.0, j[(I, I)]), (insulin[5], j[(X1, I)]),
                (insulin[6] - 1.0, j[(X1, X1)]), (insulin[7], j[(X2, I)]), (insulin[8] - 1.0, j[(X2, X2)]),
                (insulin[9], j[(X3, I)]), (insulin[10] - 1.0, j[(X3, X3)]), (glucose[0], j[(Q1, X1)]),
                (glucose[1], j[(Q1, X3)]), (glucose[2] - 1.0, j[(Q1, Q1)]), (glucose[3], j[(Q1, Q2)]),
                (glucose[4], j[(Q1, C2)]), (distant[0], j[(Q2, X1)]), (distant[1], j[(Q2, X2)]),
                (distant[2], j[(Q2, Q1)]), (distant[3] - 1.0, j[(Q2, Q2)]),
            ];
            for (index, (found, rate)) in rates.into_iter().enumerate() {
                let expected = STEP.0 * rate;
                prop_assert!((found - expected).abs() < 1e-12, "{}: {} against {}", index, found, expected);
            }
        }
    }

    #[test]
    fn exercise_and_rescues_are_left_to_the_plant() {
        let rest = (OdeState::default(), StepInput::default());
        assert!(Euler::covers(&rest.0, &rest.1));
        let bout = physiology::Exercise { vo2max_percent: 50.0, active_muscle_share: 0.5 };
        assert!(!Euler::covers(&rest.0, &StepInput { exercise: Some(bout), ..rest.1 }));
        let mut snack = rest.1;
        snack.rescue.amount = Grams(15.0);
        assert!(!Euler::covers(&rest.0, &snack));
        let mut later = rest.0;
        later.rescue.c2 = 0.1;
        assert!(!Euler::covers(&later, &rest.1));
    }
}
