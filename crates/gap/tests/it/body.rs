//! Bodies other than the ODE inside the filter: one with the rates of the nominal ODE must be that ODE under
//! every factor and every modulation.

use std::sync::Arc;

use effects::{Field, Modulation};
use gap::filter::augmented::AugmentedModel;
use gap::filter::body::{Body, sees};
use gap::filter::calibration::{Factor, PersonalFactors, calibrate};
use gap::filter::kalman::filter;
use gap::filter::state::{AugmentedState, STATES};
use gap::filter::tangent::{Direction, Parameter, signatures};
use gap::filter::transition::Transition;
use gap::{CalibrationRule, NoiseModel, Observations};
use ode_sim::equations::{Forcing, derivative, infusion};
use ode_sim::gut::glucose_dose;
use ode_sim::{EgpMode, OdeParameters, OdeVector, slot};
use physiology::{
    Compartment, Grams, Kilograms, MG_PER_DL_PER_MMOL_PER_L, MgPerDl, STEP, States, StepInput,
    Units, UnitsPerHour,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::synthetic::{Gap, World, person};

const WEIGHT: Kilograms = Kilograms(76.3);

/// The nominal ODE by its rates, all of them by Euler, the gut too.
#[derive(Debug)]
struct OdeRates {
    range: Option<(MgPerDl, MgPerDl)>,
}

impl Body for OdeRates {
    fn rate(&self, compartment: Compartment, x: &States, input: &StepInput) -> f64 {
        use Compartment::{C1, C2, Q1};
        let p = OdeParameters::nominal();
        let mut amounts = OdeVector::default();
        for state in Compartment::ALL {
            amounts[state] = x[state];
        }
        amounts[Q1] = x[Q1] / MG_PER_DL_PER_MMOL_PER_L * p.v_g;
        amounts[C2] = x[C2] * p.t_max_g;
        let insulin = infusion(input.insulin().0, WEIGHT.0);
        let forcing = Forcing { insulin, ..Forcing::default() };
        let rates = derivative(&p, &amounts, &forcing, EgpMode::NonNegative);
        match compartment {
            Q1 => rates[Q1] / p.v_g * MG_PER_DL_PER_MMOL_PER_L,
            C1 => rates[C1] + p.a_g * glucose_dose(input.carbs, WEIGHT) / STEP.0,
            C2 => rates[C2] / p.t_max_g,
            other => rates[other],
        }
    }

    fn glucose_range(&self) -> Option<(MgPerDl, MgPerDl)> {
        self.range
    }
}

fn ode() -> AugmentedModel {
    let (nominal, noise) = (OdeParameters::nominal(), NoiseModel::working());
    AugmentedModel::new(nominal, WEIGHT, noise)
}

fn body() -> AugmentedModel {
    ode().with_body(Arc::new(OdeRates { range: None }))
}

/// The same state for both, away from rest; `gut` is what C1 and C2 hold, mmol/kg.
fn states(glucose: f64, gut: f64) -> (AugmentedState, AugmentedState) {
    let (mut state, _) = ode().start(UnitsPerHour(1.2), MgPerDl(glucose));
    state.body.s1 *= 1.7;
    state.body.s2 *= 1.3;
    state.body.i *= 1.2;
    state.body.x1 *= 0.9;
    state.body.x3 *= 0.8;
    state.body.q2 *= 1.1;
    state.interstitial = MgPerDl(glucose - 6.0);
    state.flux = 0.002;
    state.body.meals.c1 = gut;
    state.body.meals.c2 = gut;
    let mut other = state;
    // The reporting unit of C2 is the rate at which it arrives.
    other.body.meals.c2 = gut / OdeParameters::nominal().t_max_g;
    (state, other)
}

fn input() -> StepInput {
    StepInput {
        basal: UnitsPerHour(0.9),
        bolus: Units(2.0),
        carbs: Grams(30.0),
        ..StepInput::default()
    }
}

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

/// Everything but the gut, whose step is exact in the ODE and Euler's in the body, is the same.
fn check_same(name: &str, ode: &AugmentedModel, glucose: f64, modulation: &Modulation) {
    let body = ode.clone().with_body(Arc::new(OdeRates { range: None }));
    // An empty gut, so that nothing of its step reaches the rest.
    for gut in [0.0, 1.5] {
        let (a, b) = states(glucose, gut);
        let expected = ode.step(&a, &input(), modulation).expect("finite").vector();
        let found = body.step(&b, &input(), modulation).expect("finite").vector();
        for state in (0..STATES).filter(|state| !(8..10).contains(state)) {
            let (found, expected) = (found[state], expected[state]);
            // Rounding of ratios of parameters, and of units there and back.
            let tolerance = 1e-12 * expected.abs().max(1.0);
            assert!(
                (found - expected).abs() < tolerance,
                "{name}, {glucose} mg/dL, gut {gut}, state {state}: {found} against {expected}"
            );
        }
        // Euler lets a meal stand through its step, the exact gut passes on 5 min of 30 to 55.
        let tolerance = 0.2 * (gut + 2.0);
        for state in [8, 9] {
            let unit = if state == 9 { OdeParameters::nominal().t_max_g } else { 1.0 };
            let distance = (unit * found[state] - expected[state]).abs();
            assert!(distance < tolerance, "{name}, state {state}: {distance}");
        }
    }
}

#[test]
fn the_odes_rates_are_the_ode_under_every_parameter() {
    for parameter in PARAMETERS {
        for by in [-0.3, 0.2] {
            let raised = ode().with_parameters(|p| parameter.raised(p, by));
            // Kinks lie where the nominal volume sees them: away from them it is the same.
            for glucose in [100.0, 110.0] {
                let name = format!("{parameter:?} by {by}");
                check_same(&name, &raised, glucose, &Modulation::NEUTRAL);
            }
        }
    }
}

#[test]
fn the_odes_rates_are_the_ode_under_every_modulation() {
    let factors = PersonalFactors([0.2, 0.1, -0.15, 0.2, -0.1, 0.12]);
    let personal = ode().with_parameters(|p| factors.applied_to(p));
    for field in Field::ALL {
        let change = match field {
            Field::Flux => 0.004,
            Field::ExtraCarbs | Field::RenalThreshold => 20.0,
            Field::SensorOffset => 5.0,
            _ => 0.3,
        };
        for glucose in [60.0, 120.0, 240.0] {
            let mut modulation = Modulation::NEUTRAL;
            modulation[field] += change;
            check_same(&format!("{field:?}"), &personal, glucose, &modulation);
        }
    }
}

/// Carbohydrate neither appears nor is lost when the time of absorption changes on the way.
#[test]
fn a_change_of_gut_time_keeps_what_was_eaten() {
    let model = body();
    let nominal = OdeParameters::nominal();
    let (mut state, _) = model.start(UnitsPerHour(1.0), MgPerDl(120.0));
    let mut arrived = 0.0;
    for step in 0..400 {
        let mut modulation = Modulation::NEUTRAL;
        if (3..20).contains(&step) {
            modulation[Field::GutTime] = 1.6;
        }
        let carbs = Grams(if step == 2 { 60.0 } else { 0.0 });
        let input = StepInput { basal: UnitsPerHour(1.0), carbs, ..StepInput::default() };
        arrived += STEP.0 * state.body.meals.c2 / modulation[Field::GutTime];
        state = model.step(&state, &input, &modulation).expect("finite");
    }
    let eaten = nominal.a_g * glucose_dose(Grams(60.0), WEIGHT);
    // What is left after 33 hours is far below this.
    assert!((arrived - eaten).abs() < 1e-9 * eaten, "{arrived} of {eaten} mmol/kg");
}

/// Every entry of the derivative, those that are taken for zero too, with personal factors and under a
/// modulation.
#[test]
fn the_sparse_transition_is_the_derivative_of_the_step() {
    let factors = PersonalFactors([0.2, 0.1, -0.15, 0.2, -0.1, 0.12]);
    let confined = OdeRates { range: Some((MgPerDl(40.0), MgPerDl(250.0))) };
    let models = [
        (body().with_parameters(|p| factors.applied_to(p)), 140.0),
        (body().with_parameters(|p| factors.applied_to(p)), 70.0),
        // Glucose is held at the end of its range, and depends on nothing.
        (ode().with_body(Arc::new(confined)), 270.0),
    ];
    let mut slowed = Modulation::NEUTRAL;
    slowed[Field::InsulinTime] = 1.4;
    slowed[Field::GutTime] = 0.8;
    slowed[Field::Production] = 1.2;
    for (model, glucose) in models {
        for modulation in [Modulation::NEUTRAL, slowed] {
            let (_, state) = states(glucose, 1.5);
            let (following, transition) =
                model.linearised(&state, &input(), &modulation).expect("finite");
            assert_eq!(following, model.step(&state, &input(), &modulation).expect("finite"));
            let x = state.vector();
            for column in 0..STATES {
                let h = 1e-5 * x[column].abs().max(1e-3);
                let moved = |by: f64| {
                    let mut y = x;
                    y[column] += by;
                    let moved = state.with_vector(&y);
                    model.step(&moved, &input(), &modulation).expect("finite").vector()
                };
                let (above, below) = (moved(h), moved(-h));
                for row in 0..STATES {
                    let slope = (above[row] - below[row]) / (2.0 * h);
                    let found = transition.get(row, column);
                    // Differences of differences; rounding of values up to 270 over 2h.
                    let tolerance = 1e-6 * found.abs().max(1.0) + 1e-13 * 300.0 / h;
                    assert!(
                        (slope - found).abs() < tolerance,
                        "{glucose} mg/dL, row {row} column {column}: {found} against {slope}"
                    );
                    if !Transition::NONZERO[row].contains(&column) {
                        assert_eq!(found, 0.0, "row {row} column {column}");
                    }
                }
            }
        }
    }
}

#[test]
fn each_compartment_sees_what_its_equation_does() {
    use Compartment::{C1, C2, I, Q1, Q2, X1, X3};
    let of = |compartment: Compartment| sees(compartment).collect::<Vec<_>>();
    assert_eq!(of(Q1), [X1, X3, Q1, Q2, C2]);
    assert_eq!(of(X3), [I, X3]);
    assert_eq!(of(C2), [C1, C2]);
    assert!(Compartment::ALL.into_iter().all(|c| of(c).contains(&c)));
}

/// What the filter believes of doses and of the gut before it starts is found by asking the body.
#[test]
fn a_start_and_the_noise_of_doses_are_the_odes() {
    let (ode, body) = (ode(), body());
    let (a, p) = ode.start(UnitsPerHour(1.0), MgPerDl(120.0));
    let (b, q) = body.start(UnitsPerHour(1.0), MgPerDl(120.0));
    for compartment in Compartment::ALL {
        let (a, b) = (a.body.vector()[compartment], b.body.vector()[compartment]);
        // A day of Euler steps from the same rest.
        assert!((a - b).abs() <= 1e-6 * a.abs(), "{compartment}: {b} against {a}");
    }
    let sd =
        |p: &gap::filter::covariance::Covariance, c: Compartment| p.get(slot(c), slot(c)).sqrt();
    let c1 = sd(&q, Compartment::C1) / sd(&p, Compartment::C1);
    // All that is eaten comes into C1; C2 rises to 1/e of it.
    assert!((c1 - 1.0).abs() < 1e-9, "{c1}");
    let t_max_g = OdeParameters::nominal().t_max_g;
    let c2 = sd(&q, Compartment::C2) * t_max_g / sd(&p, Compartment::C2);
    assert!((c2 - (-1.0f64).exp()).abs() < 0.05, "{c2}");
    let noise = |model: &AugmentedModel, state: &AugmentedState| {
        let mut p = gap::filter::covariance::Covariance::diagonal(&[0.0; STATES]);
        model.add_meal_noise(&mut p, &input());
        model.add_process_noise(&mut p, &input(), state);
        [Compartment::C1, Compartment::S1].map(|c| sd(&p, c))
    };
    for (a, b) in noise(&ode, &a).into_iter().zip(noise(&body, &a)) {
        assert!((a - b).abs() < 1e-9 * a, "{b} against {a}");
    }
}

/// A person followed, calibrated and differentiated with either: the gut's Euler step is what is left.
#[test]
fn a_person_is_followed_and_calibrated_alike() {
    let mut planted = PersonalFactors::default();
    planted.0[Factor::Action as usize] = 0.25;
    planted.0[Factor::TMaxG as usize] = -0.2;
    let world = World { gap: Gap::None, days: 7, spread: 0.0 };
    let made = person("p", &planted, &world, &mut ChaCha8Rng::seed_from_u64(21));
    let record = Observations::from_person(&made).expect("a good record");
    let (nominal, noise) = (OdeParameters::nominal(), NoiseModel::working());
    let ode = AugmentedModel::new(nominal, record.weight, noise);
    let body = ode.clone().with_body(Arc::new(OdeRates { range: None }));
    let runs = [&ode, &body].map(|model| filter(model, &record).expect("finite"));
    let (mut apart, mut size) = (0.0, 0.0);
    for (a, b) in runs[0].innovations.iter().zip(&runs[1].innovations) {
        if let Some((a, b)) = a.zip(*b) {
            apart += (a.normalised() - b.normalised()).powi(2);
            size += a.normalised().powi(2);
        }
    }
    // Measured: 0.014, from the steps after meals.
    assert!(apart < 0.03 * size, "{}", apart / size);

    // Parameters and a course by differences, through the same code as for the ODE.
    let production = vec![1.0; record.len()];
    let directions = [
        Direction::Parameter(Parameter::Action),
        Direction::Course(vec![(Field::Production, production)]),
    ];
    let a = signatures(&ode, &record, &runs[0], &directions).expect("finite");
    let b = signatures(&body, &record, &runs[1], &directions).expect("finite");
    for (a, b) in a.iter().zip(&b) {
        let product = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
        let cosine = product(a, b) / (product(a, a) * product(b, b)).sqrt();
        assert!(cosine > 0.99, "{cosine}");
    }

    let rule = CalibrationRule::working();
    let [a, b] = [&ode, &body].map(|model| calibrate(model, &record, &rule).expect("calibrates"));
    assert!(b.converged, "{} iterations", b.iterations);
    for (index, factor) in Factor::ALL.into_iter().enumerate() {
        let distance = (a.factors.0[index] - b.factors.0[index]).abs() / a.sd[index];
        // Euler delays meals by some 2 min of 40, which t_max_g takes up.
        assert!(distance < 2.0, "{factor:?}: {distance} posterior standard deviations");
    }
}
