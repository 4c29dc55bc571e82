//! How the Padova body lives through a step, with the effects that act on it.

use ode_sim::OdeError;
use physiology::{Compartment, Kilograms, MgPerDl, NonFinite, States, StepInput, UnitsPerHour};
use rand::Rng;

use super::equations::{Forcing, MG_PER_MMOL, PadovaCompartments, Prepared, derivative};
use super::exertion::Exertion;
use super::parameters::PadovaParameters;
use super::steady_state::{self, PMOL_PER_UNIT};
use crate::body::{BodyModel, Compartments as _, SUBSTEP, SUBSTEPS};
use crate::effects::{Amplitudes, Condition, Effect};

/// Insulin of one milliunit, pmol.
const PMOL_PER_MILLIUNIT: f64 = PMOL_PER_UNIT / 1000.0;

/// State of a body of the UVA/Padova kind.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PadovaState {
    /// The twelve compartments.
    pub compartments: PadovaCompartments,
    /// Carbohydrate of the last meal plus the content of the stomach at that time, mg.
    pub meal: f64,
    /// What past exercise still does.
    pub exertion: Exertion,
}

impl BodyModel for PadovaParameters {
    type State = PadovaState;

    fn draw(rng: &mut (impl Rng + ?Sized)) -> Self {
        Self::draw(rng)
    }

    fn weight(&self) -> Kilograms {
        self.weight
    }

    fn at_rest(&self, glucose: MgPerDl) -> Result<(PadovaState, UnitsPerHour), OdeError> {
        let (compartments, basal) = steady_state::at_glucose(&Prepared::new(*self), glucose)?;
        Ok((PadovaState { compartments, ..PadovaState::default() }, basal))
    }

    /// Carbohydrate eaten enters the stomach as solid food at the start of a step. Fast
    /// carbohydrate against a low enters it ground, at once, whenever it was eaten.
    fn advance(
        &self,
        state: &PadovaState,
        input: &StepInput,
        condition: &Condition,
        amplitudes: &Amplitudes,
    ) -> Result<PadovaState, NonFinite> {
        let exertion = state.exertion.after_step(input.exercise);
        let mut x = state.compartments;
        let (solid, fast) = (1000.0 * input.carbs.0, 1000.0 * input.rescue.amount.0);
        let meal = if solid + fast > 0.0 { x.q_sto1 + x.q_sto2 + solid + fast } else { state.meal };
        x.q_sto1 += solid;
        x.q_sto2 += fast;

        let now = amplitudes.of(Effect::Exercise);
        let after = amplitudes.of(Effect::PostExerciseSensitivity);
        let pmol = input.insulin().0 * condition.bioavailability * PMOL_PER_UNIT / 60.0;
        let forcing = Forcing {
            insulin: pmol / self.weight.0,
            meal,
            condition: Condition {
                production: condition.production * exertion.production_factor(now),
                action: condition.action * exertion.action_factor(after),
                uptake: condition.uptake * exertion.capacity_factor(now),
                ..*condition
            },
        };
        let body = Prepared::new(*self);
        for _ in 0..SUBSTEPS {
            x = x.runge_kutta_4(SUBSTEP, |x| derivative(&body, x, &forcing));
        }
        Ok(PadovaState { compartments: x.finite()?, meal, exertion })
    }

    fn glucose(&self, state: &PadovaState) -> MgPerDl {
        MgPerDl(state.compartments.g_p / self.v_g)
    }

    /// The compartments with the nearest meaning: S1, S2 and I in mU; X2 is the rate at which
    /// insulin beyond basal clears tissue glucose, X3 the share of k_p1 that insulin suppresses, C1
    /// the content of the stomach, C2 the rate of appearance. There is no X1.
    fn report(&self, state: &PadovaState) -> States {
        let (p, x) = (self, &state.compartments);
        let per_kg = 1.0 / (p.weight.0 * MG_PER_MMOL);
        let mut states = States::default();
        states[Compartment::S1] = x.i_sc1 / PMOL_PER_MILLIUNIT;
        states[Compartment::S2] = x.i_sc2 / PMOL_PER_MILLIUNIT;
        states[Compartment::I] = x.i_p / p.v_i / PMOL_PER_MILLIUNIT;
        states[Compartment::X2] = p.v_mx * x.x / (p.k_m0 + x.g_t);
        states[Compartment::X3] = p.k_p3 * x.x_l / p.k_p1();
        states[Compartment::Q1] = self.glucose(state).0;
        states[Compartment::Q2] = x.g_t / MG_PER_MMOL;
        states[Compartment::C1] = (x.q_sto1 + x.q_sto2) * per_kg;
        states[Compartment::C2] = p.f * p.k_abs * x.q_gut * per_kg;
        states
    }
}

#[cfg(test)]
mod tests {
    use super::super::equations::gastric_emptying;
    use super::*;
    use crate::body::{Body, BodyState};
    use physiology::{Exercise, Grams, OpenLoop, Plant, STEP, Trajectory, Units, simulate};

    /// A course from a steady 130 mg/dL with `first` in its first step.
    fn course(
        p: PadovaParameters,
        condition: Condition,
        amplitudes: Amplitudes,
        first: StepInput,
        steps: usize,
    ) -> (Vec<f64>, Trajectory<BodyState<PadovaState>>) {
        let conditions = vec![condition; steps];
        let body = Body::new(p, &conditions, amplitudes);
        let (start, basal) = body.at_rest(MgPerDl(130.0)).expect("a steady state");
        let held = StepInput { basal, ..StepInput::default() };
        let mut inputs = vec![StepInput { exercise: first.exercise, ..held }; steps];
        inputs[0] = StepInput { basal, ..first };
        let run = simulate(&body, start, &mut OpenLoop::new(&inputs), steps).expect("finite");
        (run.glucose(&body).iter().map(|g| g.0).collect(), run)
    }

    fn plain(first: StepInput, steps: usize) -> Vec<f64> {
        course(PadovaParameters::nominal(), Condition::AS_DRAWN, Amplitudes::NONE, first, steps).0
    }

    fn meal(grams: f64) -> StepInput {
        StepInput { carbs: Grams(grams), ..StepInput::default() }
    }

    #[test]
    fn a_steady_state_stands_still() {
        let p = PadovaParameters::nominal();
        for glucose in [70.0, 100.0, 130.0, 180.0, 240.0] {
            let body = Body::undisturbed(p);
            let (start, basal) = body.at_rest(MgPerDl(glucose)).expect("a steady state");
            let insulin = basal.0 * PMOL_PER_UNIT / 60.0 / p.weight.0;
            let forcing = Forcing { condition: Condition::AS_DRAWN, insulin, meal: 0.0 };
            let slope = derivative(&Prepared::new(p), &start.model.compartments, &forcing);
            // Bisection to rounding.
            let still = slope.entries().all(|(_, rate)| rate.abs() < 1e-8);
            assert!(still, "{glucose} mg/dL: {slope:?} per minute");
            let inputs = vec![StepInput { basal, ..StepInput::default() }; 288];
            let run = simulate(&body, start, &mut OpenLoop::new(&inputs), 288).expect("finite");
            let end = body.glucose(&run.states[288]).0;
            assert!((end - glucose).abs() < 1e-5, "{glucose}: {end}"); // a day of such residuals
        }
    }

    #[test]
    fn the_basal_need_is_that_of_an_adult() {
        let body = Body::undisturbed(PadovaParameters::nominal());
        let (_, basal) = body.at_rest(MgPerDl(120.0)).expect("a steady state");
        assert!((0.6..1.2).contains(&basal.0), "{basal}");
        let (state, _) = body.at_rest(MgPerDl(120.0)).expect("a steady state");
        // At basal glucose the parameters define the state.
        assert!((state.model.compartments.x).abs() < 1e-6);
        assert!((state.model.compartments.g_t - PadovaParameters::nominal().g_tb()).abs() < 1e-6);
        assert!(matches!(body.at_rest(MgPerDl(900.0)), Err(OdeError::NoBasal { .. })));
        assert!(matches!(body.at_rest(MgPerDl(-1.0)), Err(OdeError::Argument { .. })));
    }

    #[test]
    fn every_gram_appears() {
        let p = PadovaParameters::nominal();
        let mut first = meal(75.0);
        first.rescue.amount = Grams(15.0);
        let (_, run) = course(p, Condition::AS_DRAWN, Amplitudes::NONE, first, 288);
        // What leaves the intestine, by Simpson's rule on pairs of steps.
        let rate: Vec<f64> =
            run.states.iter().map(|s| p.k_abs * s.model.compartments.q_gut).collect();
        let absorbed: f64 = rate
            .chunks_exact(2)
            .zip(rate.iter().skip(2).step_by(2))
            .map(|(pair, last)| STEP.0 / 3.0 * (pair[0] + 4.0 * pair[1] + last))
            .sum();
        let end = run.states[288].model.compartments;
        let left = end.q_sto1 + end.q_sto2 + end.q_gut;
        // Simpson's rule at 5 min over courses of 17 min and more.
        assert!((absorbed + left - 90_000.0).abs() < 180.0, "{absorbed} and {left} mg");
        assert!(left < 1.0, "{left} mg after a day");
        // Of what leaves the intestine the share f reaches plasma.
        let prepared = Prepared::new(p);
        let slope = |q_gut: f64| {
            let state = PadovaCompartments { q_gut, ..run.states[0].model.compartments };
            let forcing = Forcing { condition: Condition::AS_DRAWN, insulin: 0.0, meal: 0.0 };
            derivative(&prepared, &state, &forcing).g_p
        };
        let appearance = slope(1000.0) - slope(0.0);
        assert!((appearance - p.f * p.k_abs * 1000.0 / p.weight.0).abs() < 1e-12); // rounding
    }

    #[test]
    fn carbohydrate_raises_insulin_lowers() {
        let rest = plain(meal(0.0), 72);
        let fed = plain(meal(40.0), 72);
        let dosed = plain(StepInput { bolus: Units(2.0), ..StepInput::default() }, 72);
        assert!(rest.iter().all(|g| (g - 130.0).abs() < 1e-5));
        assert!(fed.iter().all(|g| *g > 130.0 - 1e-5) && fed[18] > 160.0, "{}", fed[18]);
        assert!(dosed.iter().all(|g| *g < 130.0 + 1e-5) && dosed[48] < 110.0, "{}", dosed[48]);
    }

    #[test]
    fn a_covered_meal_of_75_g_peaks_within_the_published_times() {
        let first = StepInput { bolus: Units(6.0), ..meal(75.0) };
        let glucose = plain(first, 72);
        let peak = (0..=72).max_by(|a, b| glucose[*a].total_cmp(&glucose[*b])).expect("not empty");
        // Glucose peaks 72 min (SD 23) after meals on insulin (Daenen et al., Diabetes Metab
        // 2010;36:165), 87 min (SD 29) in T1D (Johansen et al., J Diabetes Sci Technol 2012;6:356):
        // within 1.5 SD of either.
        assert!((40..=130).contains(&(5 * peak)), "{} min", 5 * peak);
        assert!((20.0..160.0).contains(&(glucose[peak] - 130.0)), "{}", glucose[peak]);
    }

    #[test]
    fn the_stomach_empties_fast_slowly_and_fast_again() {
        let p = PadovaParameters::nominal();
        let rate = |share: f64| gastric_emptying(&p, share * 75_000.0, 75_000.0);
        assert!(rate(1.0) > 0.9 * p.k_max && rate(0.0) > 0.9 * p.k_max);
        // Half-way between the two switches it is within a hundredth of the span of the least.
        assert!(rate(0.4) - p.k_min < 0.01 * (p.k_max - p.k_min), "{}", rate(0.4));
        assert!((rate(p.b) - 0.5 * (p.k_max + p.k_min)).abs() < 1e-9); // one tanh is 0, one is 1
        assert_eq!(gastric_emptying(&p, 0.0, 0.0), p.k_max);
    }

    #[test]
    fn every_condition_moves_glucose_the_way_it_should() {
        let drawn = Condition::AS_DRAWN;
        let first = StepInput { bolus: Units(3.0), ..meal(50.0) };
        let p = PadovaParameters::nominal();
        let mean = |c: Condition| {
            let (glucose, _) = course(p, c, Amplitudes::NONE, first, 48);
            glucose.iter().sum::<f64>() / 49.0
        };
        let cases = [
            ("production", Condition { production: 1.2, ..drawn }, 1.0),
            ("action", Condition { action: 1.2, ..drawn }, -1.0),
            ("liver action", Condition { liver_action: 1.2, ..drawn }, -1.0),
            ("insulin time", Condition { insulin_time: 1.3, ..drawn }, 1.0),
            ("bioavailability", Condition { bioavailability: 0.8, ..drawn }, 1.0),
            ("flux", Condition { glucose_flux: 0.002, ..drawn }, 1.0),
            ("renal slope", Condition { renal_slope: 3.0, renal_threshold: 0.8, ..drawn }, -1.0),
        ];
        for (name, condition, sign) in cases {
            let moved = mean(condition) - mean(drawn);
            assert!(sign * moved > 1.0, "{name}: {moved} mg/dL");
        }
        let hour = |c: Condition| {
            let (glucose, _) = course(p, c, Amplitudes::NONE, first, 48);
            glucose[..=12].iter().sum::<f64>() / 13.0
        };
        assert!(hour(Condition { gut_time: 1.5, ..drawn }) < hour(drawn) - 3.0);
    }

    #[test]
    fn exercise_acts_through_its_two_effects_alone() {
        let exercise = Some(Exercise { vo2max_percent: 50.0, active_muscle_share: 0.5 });
        let first = StepInput { exercise, ..StepInput::default() };
        let after = |amplitudes: Amplitudes, steps: usize| {
            let p = PadovaParameters::nominal();
            course(p, Condition::AS_DRAWN, amplitudes, first, steps).0[steps]
        };
        assert!((after(Amplitudes::NONE, 9) - 130.0).abs() < 1e-5);
        let fall = 130.0 - after(Amplitudes::NONE.with(Effect::Exercise, 1.0), 9);
        // Riddell et al. 2017: 40 to 60 mg/dL in 45 min of moderate exercise, from higher starts.
        assert!((30.0..65.0).contains(&fall), "{fall} mg/dL");
        let tail = Amplitudes::NONE.with(Effect::PostExerciseSensitivity, 1.0);
        assert!(after(tail, 36) < 125.0, "{}", after(tail, 36));
    }
}
