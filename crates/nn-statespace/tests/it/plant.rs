//! The population plant and its steady states on models that can be worked out by hand.

use nn_statespace::initial_state::{SteadyStateOutcome, steady_state};
use nn_statespace::{
    CentreAndScale, GlucoseClamp, HiddenLayerNetwork, ModelCard, PerCompartment, PopulationModel,
    ScaledStates, Scaler, Signal, Wiring,
};
use physiology::{
    Compartment, FastCarbs, Grams, MgPerDl, NonFinite, Plant, StepInput, Units, UnitsPerHour,
};

/// `constant + sum of slope x input` for inputs above -1024: a unit an input, its kink out of reach.
fn linear(slopes: &[f64], constant: f64) -> HiddenLayerNetwork {
    const KINK: f64 = 1024.0;
    let inputs = slopes.len();
    let mut w1 = vec![0.0; inputs * inputs];
    for input in 0..inputs {
        w1[input * inputs + input] = 1.0;
    }
    let offset = KINK * slopes.iter().sum::<f64>();
    HiddenLayerNetwork::new(inputs, w1, vec![KINK; inputs], slopes.to_vec(), constant - offset)
        .expect("shapes fit")
}

/// A model whose rates are linear in named signals plus a constant, in physical units.
fn model(
    clamp: GlucoseClamp,
    rate: impl Fn(Compartment) -> (Vec<(Signal, f64)>, f64),
) -> PopulationModel {
    let wiring = Wiring::paper();
    let networks = PerCompartment::from_fn(|compartment| {
        let (terms, constant) = rate(compartment);
        let slope = |signal: &Signal| {
            terms.iter().filter(|(name, _)| name == signal).map(|(_, slope)| slope).sum()
        };
        let slopes: Vec<f64> = wiring.inputs(compartment).iter().map(slope).collect();
        linear(&slopes, constant)
    });
    let unit = CentreAndScale { centre: 0.0, scale: 1.0 };
    let scaler = Scaler::new(PerCompartment::from_fn(|_| unit), unit, unit).expect("positive");
    let card = ModelCard {
        origin: "worked out by hand".to_owned(),
        version: "0".to_owned(),
        training_data_sha256: None,
        training: None,
    };
    PopulationModel::new(wiring, networks, scaler, clamp, card).expect("fits")
}

/// Glucose moves at a constant rate, mg/dL/min; S1 collects insulin, C1 carbohydrate.
fn drifting(clamp: GlucoseClamp, rate: f64) -> PopulationModel {
    model(clamp, |compartment| match compartment {
        Compartment::Q1 => (vec![], rate),
        Compartment::S1 => (vec![(Signal::Insulin, 1.0)], 0.0),
        Compartment::C1 => (vec![(Signal::Carbs, 0.2)], 0.0),
        _ => (vec![], 0.0),
    })
}

fn at_glucose(glucose: f64) -> ScaledStates {
    let mut x = ScaledStates::default();
    x[Compartment::Q1] = glucose;
    x
}

#[test]
fn a_step_is_five_minutes_of_the_rates() {
    let model = drifting(GlucoseClamp::Off, 2.0);
    let input = StepInput {
        basal: UnitsPerHour(1.0),
        bolus: Units(2.0),
        carbs: Grams(30.0),
        rescue: FastCarbs { amount: Grams(10.0), ..FastCarbs::default() },
        ..StepInput::default()
    };
    let next = model.step(&at_glucose(100.0), &input).expect("finite");
    assert_eq!(next[Compartment::Q1], 110.0);
    assert_eq!(next[Compartment::S1], 5.0 * (1.0 + 24.0)); // 2 U within five minutes are 24 U/h
    assert!((next[Compartment::C1] - 40.0).abs() < 1e-9); // rounding of the kink's offset
    assert_eq!(model.glucose(&next), MgPerDl(110.0));
}

#[test]
fn the_clamp_confines_glucose_alone_and_only_where_it_is_on() {
    let cases = [(395.0, 2.0, 400.0, 405.0), (45.0, -2.0, 40.0, 35.0), (100.0, 2.0, 110.0, 110.0)];
    for (start, rate, confined, free) in cases {
        for (clamp, expected) in [(GlucoseClamp::Reproduction, confined), (GlucoseClamp::Off, free)]
        {
            let model = drifting(clamp, rate);
            let mut x = at_glucose(start);
            x[Compartment::Q2] = 1e4;
            let next = model.step(&x, &StepInput::default()).expect("finite");
            assert_eq!(next[Compartment::Q1], expected, "{clamp:?}");
            assert_eq!(next[Compartment::Q2], 1e4);
        }
    }
}

#[test]
fn a_residual_adds_to_the_rate_of_glucose_before_the_clamp() {
    let model = drifting(GlucoseClamp::Reproduction, 2.0);
    let step = |residual| {
        let next = model.step_with_residual(&at_glucose(395.0), &StepInput::default(), residual);
        next.expect("finite")[Compartment::Q1]
    };
    assert_eq!(step(-3.0), 390.0); // after the clamp it would be 385
    assert_eq!(step(5.0), 400.0);
}

#[test]
fn what_is_not_a_number_is_named() {
    let model = drifting(GlucoseClamp::Reproduction, 2.0);
    let input = StepInput { carbs: Grams(f64::NAN), ..StepInput::default() };
    let error = model.step(&at_glucose(100.0), &input).expect_err("NaN carbs");
    assert_eq!(error, NonFinite { compartment: Compartment::C1 });
    let error = model
        .step_with_residual(&at_glucose(100.0), &StepInput::default(), f64::NAN)
        .expect_err("NaN residual");
    assert_eq!(error, NonFinite { compartment: Compartment::Q1 });
}

/// At glucose g the basal rate that holds it is (3.3 - 0.02 g) / 0.9.
fn with_steady_states() -> PopulationModel {
    use Compartment::{C1, C2, I, Q1, Q2, S1, S2, X1, X2, X3};
    let state = Signal::State;
    model(GlucoseClamp::Off, |compartment| match compartment {
        S1 => (vec![(Signal::Insulin, 1.0), (state(S1), -0.02)], 0.0),
        S2 => (vec![(state(S1), 0.02), (state(S2), -0.02)], 0.0),
        I => (vec![(state(S2), 0.01), (state(I), -0.05)], 0.0),
        X1 | X2 | X3 => (vec![(state(I), 0.0002), (state(compartment), -0.02)], 0.0),
        Q1 => {
            let slopes = [(X1, -6.0), (X3, -3.0), (Q2, 0.2), (Q1, -0.03)];
            (slopes.map(|(name, slope)| (state(name), slope)).to_vec(), 3.3)
        }
        Q2 => {
            let slopes = [(Q1, 0.002), (Q2, -0.04), (X1, 0.1), (X2, -0.1)];
            (slopes.map(|(name, slope)| (state(name), slope)).to_vec(), 0.0)
        }
        C1 => (vec![(Signal::Carbs, 0.2), (state(C1), -0.025)], 0.0),
        C2 => (vec![(state(C1), 0.025), (state(C2), -0.025)], 0.0),
    })
}

#[test]
fn a_steady_state_known_in_closed_form_is_found() {
    let model = with_steady_states();
    for glucose in [60.0, 120.0, 160.0] {
        let found = steady_state(&model, MgPerDl(glucose)).expect("a glucose");
        let basal = (3.3 - 0.02 * glucose) / 0.9;
        assert_eq!(found.outcome, SteadyStateOutcome::Found, "{glucose}");
        assert!(found.attracting);
        assert!(found.residual < 1e-11, "{}", found.residual);
        // The residual bound over the smallest slope, 0.02 to 0.0002 along the chain.
        assert!((found.basal.0 - basal).abs() < 1e-8, "{} {basal}", found.basal);
        let expected = [
            (Compartment::S1, 50.0 * basal),
            (Compartment::S2, 50.0 * basal),
            (Compartment::I, 10.0 * basal),
            (Compartment::X2, 0.1 * basal),
            (Compartment::Q1, glucose),
            (Compartment::Q2, 0.05 * glucose),
            (Compartment::C1, 0.0),
        ];
        for (compartment, value) in expected {
            assert!((found.states[compartment] - value).abs() < 1e-7, "{compartment}");
        }
    }
}

#[test]
fn a_negative_basal_rate_is_told_apart_from_no_steady_state() {
    let outside = steady_state(&with_steady_states(), MgPerDl(180.0)).expect("a glucose");
    assert_eq!(outside.outcome, SteadyStateOutcome::OutsidePhysicalRange);
    assert!((outside.basal.0 + 1.0 / 3.0).abs() < 1e-8);

    let none = steady_state(&drifting(GlucoseClamp::Off, 2.0), MgPerDl(100.0)).expect("a glucose");
    assert_eq!((none.outcome, none.residual), (SteadyStateOutcome::NotFound, 2.0));

    for glucose in [0.0, -5.0, f64::NAN, f64::INFINITY] {
        let error = steady_state(&with_steady_states(), MgPerDl(glucose)).expect_err("impossible");
        assert!(error.to_string().contains("not a positive finite glucose"), "{error}");
    }
}
