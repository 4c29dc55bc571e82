//! Bodies other than the ODE inside the filter, and where calibration and effects act on them.
//!
//! The filter keeps its states for every plant. A [`Body`] tells the rates of the ten compartments; it
//! needs no parameters. What is personal, and what effects change, acts at its *ports*: a factor on a time
//! of absorption slows the compartments of the depot, a factor on insulin action multiplies the insulin that
//! the networks of X1 and X2 see, production is a flux into Q1. The factors are those of
//! [`OdeParameters`] over the nominal ones, so that the same six numbers calibrate every plant, and a body
//! with the rates of the nominal ODE is that ODE under all of them (tested).
//!
//! Its ten values stand in [`OdeState`], in the units of [`States`] except for Q1, which is an amount in
//! mmol/kg at the nominal volume.

use std::fmt::Debug;
use std::sync::Arc;

use ode_sim::equations::{endogenous_production, infusion, non_insulin_uptake};
use ode_sim::gut::glucose_dose;
use ode_sim::steady_state::held_by;
use ode_sim::{EgpMode, OdeError, OdeParameters, OdePlant, OdeState, OdeVector, slot};
use physiology::Compartment::{C1, C2, I, Q1, Q2, S1, S2, X1, X2, X3};
use physiology::{
    Compartment, Grams, Kilograms, MG_PER_DL_PER_MMOL_PER_L, MgPerDl, STEP, STEPS_PER_HOUR, States,
    StepInput, Units, UnitsPerHour,
};

use crate::filter::transition::{BodySlopes, Transition};

/// A body of the ten compartments that is not the ODE: a network, or a network with a person's residual.
///
/// A step is forward Euler at 5 min, as networks of this kind are defined. States are in the units of
/// [`Compartment::unit`].
pub trait Body: Debug + Send + Sync {
    /// Rate of change of one compartment through a step, in its unit per minute.
    ///
    /// It may depend on the inputs and on the states that the compartment's equation has ([`sees`]).
    /// A rate that is not a finite number ends the run of the person.
    fn rate(&self, compartment: Compartment, x: &States, input: &StepInput) -> f64;

    /// The rate and its slopes by the states, per minute in matching units; 0 for states that it does not see.
    ///
    /// Central differences unless the body knows better.
    fn slopes(&self, compartment: Compartment, x: &States, input: &StepInput) -> (f64, States) {
        let mut slopes = States::default();
        for state in sees(compartment) {
            // The cube root of the rounding of a double, at the scale of the state.
            let by = 1e-5 * x[state].abs().max(usual(state));
            let at = |value: f64| {
                let mut moved = *x;
                moved[state] = value;
                self.rate(compartment, &moved, input)
            };
            slopes[state] = (at(x[state] + by) - at(x[state] - by)) / (2.0 * by);
        }
        (self.rate(compartment, x, input), slopes)
    }

    /// Where glucose is confined after each step, mg/dL; `None` where it runs free.
    fn glucose_range(&self) -> Option<(MgPerDl, MgPerDl)> {
        None
    }
}

/// The states that the rate of a compartment may depend on: those of its equation (paper, Eq. 1 and 2).
pub fn sees(compartment: Compartment) -> impl Iterator<Item = Compartment> {
    let columns = Transition::NONZERO[slot(compartment)];
    Compartment::ALL.into_iter().filter(move |state| columns.contains(&slot(*state)))
}

/// Usual size of a state, in its unit.
fn usual(state: Compartment) -> f64 {
    match state {
        S1 | S2 | I => 10.0,
        X1 | X2 | C2 => 0.01,
        X3 => 0.5,
        Q1 => 100.0,
        Q2 | C1 => 1.0,
    }
}

/// Hours through which a body settles before a filter starts.
const SETTLING: usize = 24 * STEPS_PER_HOUR;
/// The bite and the insulin with which it is found what a body makes of its inputs.
const BITE: Grams = Grams(50.0);
const DOSE: Units = Units(1.0);

/// A body with what the filter has to know of it.
#[derive(Debug)]
pub(crate) struct OtherBody {
    body: Arc<dyn Body>,
    nominal: OdeParameters,
    /// What C1 gains in a step per gram eaten.
    c1_per_gram: f64,
    /// The highest that C2 rises per gram eaten.
    c2_per_gram: f64,
    /// What S1 gains in a step per U/h, mU/kg.
    s1_per_rate: f64,
}

/// Calibration and modulations at the ports of a body: factors on the nominal parameters.
struct Ports {
    insulin_time: f64,
    insulin_clearance: f64,
    /// Of X1, X2, X3: insulin that acts, and speed.
    action: [(f64, f64); 3],
    gut_time: f64,
    carbs: f64,
    return_flow: f64,
}

/// Whether slopes are wanted too; they cost as much again.
#[derive(Clone, Copy)]
pub(crate) enum Slopes {
    Skip,
    Take,
}

impl OtherBody {
    pub(crate) fn new(body: Arc<dyn Body>) -> Self {
        let nominal = OdeParameters::nominal();
        let mut other =
            Self { body, nominal, c1_per_gram: 0.0, c2_per_gram: 0.0, s1_per_rate: 0.0 };
        let resting = StepInput { basal: UnitsPerHour(1.0), ..StepInput::default() };
        let guess = OdePlant::reproduction(nominal, Kilograms(70.0));
        let infused = infusion(resting.basal.0, guess.weight.0);
        let start = held_by(&nominal, guess.q1_at(MgPerDl(120.0)), infused);
        let mut x = other.at_rest(&guess, start, resting.basal);
        let gained = |compartment: Compartment, input: &StepInput| {
            let physical = other.states(&x);
            let of = |input: &StepInput| other.body.rate(compartment, &physical, input);
            STEP.0 * (of(input) - of(&resting))
        };
        let fed = StepInput { carbs: BITE, ..resting };
        let dosed = StepInput { bolus: DOSE, ..resting };
        let (c1, s1) = (gained(C1, &fed), gained(S1, &dosed));
        // The gut alone, in a loop of its own: `physiology::simulate` would compute the other eight rates too.
        let (mut highest, before) = (0.0f64, x[C2]);
        for step in 0..6 * STEPS_PER_HOUR {
            let input = if step == 0 { &fed } else { &resting };
            let physical = other.states(&x);
            let rates = [C1, C2].map(|c| (c, other.body.rate(c, &physical, input)));
            for (compartment, rate) in rates {
                x[compartment] += STEP.0 * rate;
            }
            highest = highest.max((x[C2] - before).abs());
        }
        other.c1_per_gram = c1.abs() / BITE.0;
        other.c2_per_gram = highest / BITE.0;
        other.s1_per_rate = s1.abs() / DOSE.over(STEP).0;
        other
    }

    /// The ten compartments one step later, and the derivative of the step by them where it is wanted. `flux` is added to
    /// dQ1/dt, mmol/kg/min.
    ///
    /// # Errors
    /// [`OdeError::NonFinite`] with the compartment.
    pub(crate) fn step(
        &self,
        person: &OdePlant,
        state: &OdeState,
        input: &StepInput,
        flux: f64,
        wanted: Slopes,
    ) -> Result<(OdeState, BodySlopes), OdeError> {
        let mut x = state.vector();
        let (rates, slopes) = self.rates(person, &x, input, flux, wanted);
        let mut slopes = slopes.of_a_step();
        for (value, rate) in x.0.iter_mut().zip(rates.0) {
            *value += STEP.0 * rate;
        }
        if let Some(compartment) = x.first_non_finite() {
            return Err(OdeError::NonFinite { compartment });
        }
        if let Some((lowest, highest)) = self.body.glucose_range() {
            let amount = |glucose: MgPerDl| glucose.0 / MG_PER_DL_PER_MMOL_PER_L * self.nominal.v_g;
            let confined = x[Q1].clamp(amount(lowest), amount(highest));
            if confined != x[Q1] {
                x[Q1] = confined;
                slopes.glucose = [0.0; 6];
            }
        }
        Ok((state.with_vector(&x), slopes))
    }

    /// The body after a day of `basal` with glucose held as it stands in `start`; the gut empties. The loop is no
    /// simulation: [`simulate`](physiology::simulate) would move glucose.
    pub(crate) fn at_rest(
        &self,
        person: &OdePlant,
        start: OdeVector,
        basal: UnitsPerHour,
    ) -> OdeVector {
        let (ports, mut x) = (self.ports(person), start);
        let input = StepInput { basal, ..StepInput::default() };
        for _ in 0..SETTLING {
            let physical = self.states(&x);
            for (compartment, rate) in self.rates_around_glucose(&ports, &physical, &input) {
                x[compartment] += STEP.0 * rate;
            }
        }
        x
    }

    /// Standard deviations of C1 and C2 where `amount` mmol/kg, absorbed share included, may be in the gut.
    pub(crate) fn gut_sd(&self, person: &OdePlant, amount: f64) -> [f64; 2] {
        let per_gram = self.nominal.a_g * glucose_dose(Grams(1.0), person.weight);
        [self.c1_per_gram, self.c2_per_gram].map(|gain| gain * amount / per_gram)
    }

    /// What comes into S1 and into C1 in a step.
    pub(crate) fn doses(&self, person: &OdePlant, input: &StepInput) -> [f64; 2] {
        let eaten = self.c1_per_gram * input.carbs.0 * person.parameters.a_g / self.nominal.a_g;
        [self.s1_per_rate * input.insulin().0, eaten]
    }

    /// The state in reporting units; glucose as the person's volume dilutes it.
    pub(crate) fn report(&self, person: &OdePlant, state: &OdeState) -> States {
        let mut states = self.states(&state.vector());
        states[Q1] = state.q1 / person.parameters.v_g * MG_PER_DL_PER_MMOL_PER_L;
        states
    }

    fn states(&self, x: &OdeVector) -> States {
        let mut states = States::default();
        for compartment in Compartment::ALL {
            states[compartment] = x[compartment];
        }
        states[Q1] = x[Q1] / self.nominal.v_g * MG_PER_DL_PER_MMOL_PER_L;
        states
    }

    fn ports(&self, person: &OdePlant) -> Ports {
        let (p, n) = (&person.parameters, &self.nominal);
        Ports {
            insulin_time: p.t_max_i / n.t_max_i,
            insulin_clearance: p.k_e / n.k_e,
            action: [
                (p.s_f1 / n.s_f1, p.k_a1 / n.k_a1),
                (p.s_f2 / n.s_f2, p.k_a2 / n.k_a2),
                (p.s_f3 / n.s_f3, p.k_a3 / n.k_a3),
            ],
            gut_time: p.t_max_g / n.t_max_g,
            carbs: p.a_g / n.a_g,
            return_flow: p.k_12 / n.k_12,
        }
    }

    /// Rates at the ports, in physical units, glucose as an amount; and their slopes.
    fn rates(
        &self,
        person: &OdePlant,
        x: &OdeVector,
        input: &StepInput,
        flux: f64,
        wanted: Slopes,
    ) -> (OdeVector, BodySlopes) {
        let (ports, p) = (self.ports(person), &person.parameters);
        // Production and uptake beyond those of the nominal parameters, mmol/kg/min.
        let (egp_0, f_01) = (p.egp_0 - self.nominal.egp_0, p.f_01 - self.nominal.f_01);
        let mut input = *input;
        input.carbs.0 *= ports.carbs;
        input.rescue.amount.0 *= ports.carbs;
        let physical = self.states(x);
        let mut values = OdeVector::default();
        for (compartment, rate) in self.rates_around_glucose(&ports, &physical, &input) {
            values[compartment] = rate;
        }
        let into_amount = self.nominal.v_g / MG_PER_DL_PER_MMOL_PER_L;
        let at_glucose = ports.at_glucose(&physical);
        let g = x[Q1] / p.v_g;
        let (own, slopes) = match wanted {
            Slopes::Skip => (self.body.rate(Q1, &at_glucose, &input), BodySlopes::default()),
            Slopes::Take => {
                let (own, by) = self.body.slopes(Q1, &at_glucose, &input);
                let mut slopes = self.slopes_around_glucose(&ports, &physical, &input);
                let open = x[X3] <= 1.0;
                let defended = non_insulin_uptake(1.0, f_01) / p.v_g;
                let low = g < ode_sim::equations::UPTAKE_SATURATION;
                slopes.glucose = [
                    into_amount * by[X1],
                    into_amount * by[X3] - if open { egp_0 } else { 0.0 },
                    by[Q1] - if low { defended } else { 0.0 },
                    into_amount * by[Q2] * ports.return_flow,
                    into_amount * by[C2] / ports.gut_time,
                    1.0,
                ];
                (own, slopes)
            }
        };
        let produced = endogenous_production(x[X3], egp_0, EgpMode::NonNegative);
        values[Q1] = into_amount * own + produced + flux - non_insulin_uptake(g, f_01);
        if ports.return_flow != 1.0 {
            // What returns faster leaves Q2 faster.
            let mut nominal = at_glucose;
            nominal[Q2] = physical[Q2];
            values[Q2] -= into_amount * (own - self.body.rate(Q1, &nominal, &input));
        }
        (values, slopes)
    }

    /// Rates of everything but Q1.
    fn rates_around_glucose(
        &self,
        ports: &Ports,
        physical: &States,
        input: &StepInput,
    ) -> [(Compartment, f64); 9] {
        let rate = |c: Compartment, x: &States, input: &StepInput| self.body.rate(c, x, input);
        let [(with_1, speed_1), (with_2, speed_2), (with_3, speed_3)] = ports.action;
        // What comes in is not slowed with what leaves.
        let slowed = |c: Compartment, empty: &StepInput, time: f64| {
            let full = rate(c, physical, input);
            if time == 1.0 {
                return full;
            }
            let leaving = rate(c, physical, empty);
            full - leaving + leaving / time
        };
        [
            (S1, slowed(S1, &without_insulin(input), ports.insulin_time)),
            (S2, rate(S2, physical, input) / ports.insulin_time),
            (I, ports.insulin_clearance * rate(I, &ports.at_insulin(physical), input)),
            (X1, speed_1 * rate(X1, &acting(physical, with_1), input)),
            (X2, speed_2 * rate(X2, &acting(physical, with_2), input)),
            (X3, speed_3 * rate(X3, &acting(physical, with_3), input)),
            (Q2, rate(Q2, physical, input)),
            (C1, slowed(C1, &without_carbs(input), ports.gut_time)),
            (C2, rate(C2, physical, input) / ports.gut_time),
        ]
    }

    /// Slopes of [`rates_around_glucose`](Self::rates_around_glucose); those of Q1 stay 0.
    fn slopes_around_glucose(
        &self,
        ports: &Ports,
        physical: &States,
        input: &StepInput,
    ) -> BodySlopes {
        let by = |c: Compartment, x: &States, input: &StepInput| self.body.slopes(c, x, input).1;
        let slowed = |c: Compartment, empty: &StepInput, time: f64| {
            let full = by(c, physical, input)[c];
            if time == 1.0 {
                return full;
            }
            let leaving = by(c, physical, empty)[c];
            full - leaving + leaving / time
        };
        let [x1, x2, x3] = [(X1, ports.action[0]), (X2, ports.action[1]), (X3, ports.action[2])]
            .map(|(effect, (with, speed))| {
                let slopes = by(effect, &acting(physical, with), input);
                (speed * with * slopes[I], speed * slopes[effect])
            });
        let (s2, i) = (by(S2, physical, input), by(I, &ports.at_insulin(physical), input));
        let (q2, c2) = (by(Q2, physical, input), by(C2, physical, input));
        let time = ports.insulin_time;
        let s1 = slowed(S1, &without_insulin(input), time);
        let (s2_s1, s2_s2, i_s2) = (s2[S1] / time, s2[S2] / time, i[S2] / time);
        let i_i = ports.insulin_clearance * i[I];
        let time = ports.gut_time;
        let c1 = slowed(C1, &without_carbs(input), time);
        BodySlopes {
            insulin: [s1, s2_s1, s2_s2, i_s2, i_i, x1.0, x1.1, x2.0, x2.1, x3.0, x3.1],
            glucose: [0.0; 6],
            distant: [q2[X1], q2[X2], q2[Q1] / self.nominal.v_g * MG_PER_DL_PER_MMOL_PER_L, q2[Q2]],
            gut: [c1, c2[C1] / time, c2[C2] / time],
        }
    }
}

impl Ports {
    /// What the network of I sees: S2 empties at its own time, I is cleared at its own speed.
    fn at_insulin(&self, physical: &States) -> States {
        let mut states = *physical;
        states[S2] /= self.insulin_time * self.insulin_clearance;
        states
    }

    /// What the network of Q1 sees: C2 as it arrives.
    fn at_glucose(&self, physical: &States) -> States {
        let mut states = *physical;
        states[C2] /= self.gut_time;
        states[Q2] *= self.return_flow;
        states
    }
}

fn acting(physical: &States, action: f64) -> States {
    let mut states = *physical;
    states[I] *= action;
    states
}

fn without_insulin(input: &StepInput) -> StepInput {
    StepInput { basal: UnitsPerHour(0.0), bolus: Units(0.0), ..*input }
}

fn without_carbs(input: &StepInput) -> StepInput {
    StepInput { carbs: Grams(0.0), rescue: physiology::FastCarbs::default(), ..*input }
}
