//! What goes in stays in or has left: insulin, carbohydrate, and glucose under Euler.

use ode_sim::equations::{endogenous_production, infusion, non_insulin_uptake, renal_clearance};
use ode_sim::{
    EgpMode, ExerciseMemory, Integrator, OdeParameters, OdePlant, OdeState, steady_state,
};
use physiology::{
    Exercise, FastCarbs, Grams, Kilograms, MgPerDl, Minutes, OpenLoop, Plant, StepInput, Units,
    UnitsPerHour, simulate,
};

const INTEGRATORS: [Integrator; 3] = [
    Integrator::ForwardEuler,
    Integrator::RungeKutta4 { substeps: 2 },
    Integrator::Adaptive { rtol: 1e-8, atol: 1e-11 },
];

/// A day with meals, boluses, a snack and exercise.
fn a_day() -> Vec<StepInput> {
    let mut inputs = vec![StepInput { basal: UnitsPerHour(0.8), ..StepInput::default() }; 288];
    for (step, carbs, bolus) in [(90, 60.0, 4.0), (150, 80.0, 7.0), (222, 95.0, 6.5)] {
        inputs[step].carbs = Grams(carbs);
        inputs[step + 2].bolus = Units(bolus);
    }
    inputs[200].rescue = FastCarbs { amount: Grams(20.0), eaten_before: Minutes(5.0) };
    for input in &mut inputs[180..190] {
        input.exercise = Some(Exercise { vo2max_percent: 55.0, active_muscle_share: 0.4 });
    }
    inputs
}

fn plant(integrator: Integrator, parameters: OdeParameters) -> OdePlant {
    OdePlant { parameters, weight: Kilograms(70.0), integrator, egp: EgpMode::Reproduction }
}

#[test]
fn without_elimination_all_insulin_is_still_there() {
    let inputs = a_day();
    let given: f64 = inputs.iter().map(|i| 5.0 * infusion(i.insulin().0, 70.0)).sum();
    for integrator in INTEGRATORS {
        let p = OdeParameters { k_e: 0.0, ..OdeParameters::nominal() };
        // Insulin would take glucose below zero and further: only insulin is looked at here.
        let p = p.with_sensitivity_scaled(0.0);
        let plant = plant(integrator, p);
        let start = OdeState { q1: 1.0, ..OdeState::default() };
        let run = simulate(&plant, start, &mut OpenLoop::new(&inputs), 288).expect("finite");
        let end = run.states[288];
        let present = end.s1 + end.s2 + p.v_i * end.i;
        // A sum of all states is kept by every Runge-Kutta method: rounding of 288 steps.
        assert!((present / given - 1.0).abs() < 1e-12, "{integrator:?}: {present} of {given}");
    }
}

#[test]
fn under_euler_insulin_given_is_present_or_eliminated() {
    let inputs = a_day();
    let p = OdeParameters::nominal();
    let plant = plant(Integrator::ForwardEuler, p);
    let start = steady_state::at_glucose(&p, plant.weight, MgPerDl(130.0)).expect("steady").state;
    let run = simulate(&plant, start, &mut OpenLoop::new(&inputs), 288).expect("finite");
    let amount = |x: &OdeState| x.s1 + x.s2 + p.v_i * x.i;
    let given: f64 = inputs.iter().map(|i| 5.0 * infusion(i.insulin().0, 70.0)).sum();
    let eliminated: f64 = run.states[..288].iter().map(|x| 5.0 * p.k_e * p.v_i * x.i).sum();
    let error = amount(&start) + given - eliminated - amount(&run.states[288]);
    assert!(error.abs() < 1e-11 * given, "unaccounted for: {error} mU/kg"); // rounding
}

#[test]
fn carbohydrate_eaten_is_in_the_gut_or_absorbed() {
    let inputs = a_day();
    let p = OdeParameters::nominal();
    for integrator in INTEGRATORS {
        let plant = plant(integrator, p);
        let start =
            steady_state::at_glucose(&p, plant.weight, MgPerDl(130.0)).expect("steady").state;
        let run = simulate(&plant, start, &mut OpenLoop::new(&inputs), 288).expect("finite");
        for (k, state) in run.states.iter().enumerate() {
            // What each meal has released by now: the integral of U_G in closed form.
            let (mut eaten, mut absorbed, mut snack, mut snack_absorbed) = (0.0, 0.0, 0.0, 0.0);
            for (m, input) in inputs[..k].iter().enumerate() {
                let per_gram = p.a_g / (0.18 * 70.0);
                let released = |since: f64, t_max: f64| {
                    let s = since / t_max;
                    1.0 - (1.0 + s) * (-s).exp()
                };
                let since = 5.0 * (k - m) as f64;
                eaten += per_gram * input.carbs.0;
                absorbed += per_gram * input.carbs.0 * released(since, p.t_max_g);
                snack += per_gram * input.rescue.amount.0;
                let since = since + input.rescue.eaten_before.0;
                snack_absorbed += per_gram * input.rescue.amount.0 * released(since, 20.0);
            }
            // Rounding of 288 exact steps.
            let gut = state.meals.c1 + state.meals.c2;
            assert!((eaten - absorbed - gut).abs() < 1e-12, "{integrator:?}, step {k}");
            let gut = state.rescue.c1 + state.rescue.c2;
            assert!((snack - snack_absorbed - gut).abs() < 1e-12, "{integrator:?}, step {k}");
        }
    }
}

#[test]
fn all_absorbed_carbohydrate_reaches_the_blood() {
    // No uptake, production, disposal or clearance: glucose can only come in.
    let p = OdeParameters { f_01: 0.0, egp_0: 0.0, ..OdeParameters::nominal() };
    let p = p.with_sensitivity_scaled(0.0);
    let mut inputs = vec![StepInput::default(); 288];
    inputs[3].carbs = Grams(8.0);
    let eaten = p.a_g * 8.0 / (0.18 * 70.0);
    // Euler sums U_G at step boundaries: U_G'(0) h^2/12 short of the integral, 25/(12 x 1600).
    for (integrator, tolerance) in INTEGRATORS.into_iter().zip([1.4e-3, 1e-6, 1e-7]) {
        let plant = plant(integrator, p);
        let start = OdeState { q1: 0.8, ..OdeState::default() };
        let run = simulate(&plant, start, &mut OpenLoop::new(&inputs), 288).expect("finite");
        let peak = plant.glucose(&run.states[288]).0;
        assert!(peak < 162.0, "the kidneys stay out of it: {peak}");
        let arrived = run.states[288].q1 + run.states[288].q2 - 0.8;
        assert!((arrived / eaten - 1.0).abs() < tolerance, "{integrator:?}: {arrived} of {eaten}");
    }
}

#[test]
fn under_euler_glucose_changes_by_its_fluxes() {
    let inputs = a_day();
    let p = OdeParameters::nominal();
    let plant = plant(Integrator::ForwardEuler, p);
    let start = steady_state::at_glucose(&p, plant.weight, MgPerDl(130.0)).expect("steady").state;
    let run = simulate(&plant, start, &mut OpenLoop::new(&inputs), 288).expect("finite");
    let mut net = 0.0;
    for (x, input) in run.states.iter().zip(&inputs) {
        let g = x.q1 / p.v_g;
        // A snack eaten five minutes before counts from the start of its step.
        let snack = p.a_g * input.rescue.amount.0 / (0.18 * 70.0);
        let snack = snack * 0.25 * (-0.25_f64).exp() / 20.0;
        net += 5.0
            * (x.meals.appearance(p.t_max_g)
                + x.rescue.appearance(20.0)
                + snack
                + endogenous_production(x.x3, p.egp_0, EgpMode::Reproduction)
                - non_insulin_uptake(g, p.f_01)
                - renal_clearance(g, p.v_g)
                - x.x2 * x.q2);
    }
    let end = run.states[288];
    let change = end.q1 + end.q2 - start.q1 - start.q2;
    assert!((change - net).abs() < 1e-12, "{change} against {net} mmol/kg"); // rounding
    assert_eq!(end.exercise, ExerciseMemory::Rest, "the bout is forgotten after five hours");
}
