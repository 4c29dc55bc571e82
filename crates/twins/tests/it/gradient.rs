//! The gradient of the fused roll-out against candle's graph and against central differences, and the windows
//! that are simulated once against a full roll-out.

use candle_core::Tensor;
use nn_statespace::{GlucoseClamp, ScaledStates};
use physiology::{Compartment, OpenLoop, Plant, simulate};
use twins::{
    InputSet, Known, PreparedWindow, ResidualNetwork, ResidualVariables, TwinLoss, batch_gradient,
    graph_loss, simulate_many, window_courses, window_loss,
};

use crate::synthetic::{exercising_day, population, trained_looking, twin_of};

fn start() -> ScaledStates {
    let mut start = ScaledStates::default();
    start[Compartment::X1] = 0.2;
    start[Compartment::C2] = -0.3;
    start
}

/// Three windows of `steps` steps whose glucose wanders through the penalised ranges.
fn windows(clamp: GlucoseClamp, steps: usize) -> Vec<PreparedWindow> {
    let population = population(clamp);
    let inputs = exercising_day(3 * steps);
    (0..3)
        .map(|w| {
            let glucose: Vec<f64> =
                (0..=steps).map(|k| 160.0 + 110.0 * (0.31 * (k + 20 * w) as f64).sin()).collect();
            let slice = inputs[w * steps..(w + 1) * steps].to_vec();
            PreparedWindow::new(&population, slice, &glucose, start(), None, InputSet::All)
                .expect("a window")
        })
        .collect()
}

#[test]
fn the_gradient_is_that_of_the_graph() {
    for clamp in [GlucoseClamp::Reproduction, GlucoseClamp::Off] {
        let population = population(clamp);
        let windows = windows(clamp, 60);
        let windows: Vec<&PreparedWindow> = windows.iter().collect();
        let network = trained_looking(5);
        let (loss, fused) =
            batch_gradient(&population, &network, &windows, TwinLoss::PAPER).expect("windows");

        let variables = ResidualVariables::new(&network).expect("variables");
        let graph = graph_loss(&population, &variables, &windows, TwinLoss::PAPER).expect("graph");
        let graph_value = graph.to_scalar::<f64>().expect("a scalar");
        // Both sum some 1e6 products in f64, in different order.
        assert!((loss - graph_value).abs() < 1e-10 * loss.abs().max(1.0), "{loss} {graph_value}");

        let store = graph.backward().expect("gradients");
        let expected = ResidualVariables::new(&fused).expect("variables");
        for (variable, ours) in variables.variables().iter().zip(expected.variables()) {
            let theirs = store.get(variable).expect("every variable has a gradient");
            let largest = |t: &Tensor| -> f64 {
                let values: Vec<f64> = t.flatten_all().expect("flat").to_vec1().expect("f64");
                values.into_iter().fold(0.0, |m, v| m.max(v.abs()))
            };
            let deviation = largest(&(ours.as_tensor() - theirs).expect("same shape"));
            let size = largest(theirs);
            assert!(size > 0.0, "a tensor without any gradient shows nothing");
            assert!(deviation < 1e-9 * size, "{deviation} of {size}"); // rounding, as above
        }
    }
}

#[test]
fn what_acts_beside_the_networks_moves_glucose_and_the_gradient_alike() {
    let population = population(GlucoseClamp::Off);
    let network = trained_looking(5);
    let plain = windows(GlucoseClamp::Off, 12);
    let inputs = exercising_day(12);
    let glucose: Vec<f64> = (0..=12).map(|k| 160.0 + 5.0 * k as f64).collect();
    let mut states = vec![start(); 12];
    for (k, state) in states.iter_mut().enumerate() {
        state[Compartment::X1] = 0.05 * k as f64;
    }
    let window = |rate: f64| {
        let known = Known { states: states.clone(), added_rates: vec![rate; 12] };
        let (inputs, set) = (inputs.clone(), InputSet::All);
        PreparedWindow::under(&population, inputs, &glucose, known, None, set).expect("fits")
    };
    let (without, with) = (window(0.0), window(0.01));
    let courses = window_courses(&population, &network, &[without, with.clone()]).expect("two");
    assert_eq!(courses[0][0].0, 160.0);
    // 0.01 scaled units of 80 mg/dL a minute, five minutes.
    let first = courses[1][1].0 - courses[0][1].0;
    assert!((first - 4.0).abs() < 1e-9, "{first}");
    let both = [&with, &plain[0]];
    let (loss, fused) =
        batch_gradient(&population, &network, &both, TwinLoss::PAPER).expect("windows");
    let variables = ResidualVariables::new(&network).expect("variables");
    let graph = graph_loss(&population, &variables, &both, TwinLoss::PAPER).expect("graph");
    let value = graph.to_scalar::<f64>().expect("a scalar");
    assert!((loss - value).abs() < 1e-10 * value, "{loss} {value}"); // rounding
    let store = graph.backward().expect("gradients");
    let expected = flat(&fused);
    let found: Vec<f64> = variables
        .variables()
        .iter()
        .flat_map(|v| {
            let slope = store.get(v).expect("a gradient");
            slope.flatten_all().expect("flat").to_vec1::<f64>().expect("f64")
        })
        .collect();
    let largest = found.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    for (a, b) in found.iter().zip(&expected) {
        assert!((a - b).abs() < 1e-9 * largest, "{a} {b}"); // rounding
    }
    let short = Known { states: states[1..].to_vec(), added_rates: vec![0.0; 12] };
    let (inputs, set) = (inputs.clone(), InputSet::All);
    assert!(PreparedWindow::under(&population, inputs, &glucose, short, None, set).is_err());
}

#[test]
fn the_gradient_agrees_with_central_differences() {
    let population = population(GlucoseClamp::Off);
    let owned = windows(GlucoseClamp::Off, 12);
    let windows: Vec<&PreparedWindow> = owned.iter().collect();
    let network = trained_looking(9);
    let (_, gradient) =
        batch_gradient(&population, &network, &windows, TwinLoss::PAPER).expect("windows");
    let slopes = flat(&gradient);
    let values = flat(&network);
    let scale = slopes.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    // Every 97th parameter, and the last layer's bias.
    let mut compared = 0;
    for index in (0..values.len()).step_by(97).chain([values.len() - 1]) {
        let at = |h: f64| {
            let mut moved = values.clone();
            moved[index] += h;
            window_loss(&population, &unflat(&moved), &owned, TwinLoss::PAPER).expect("windows")
        };
        // h^2 of the third derivative and 1e-16 / h of rounding are both about 1e-10 here; a kink
        // of a ReLU or of the penalty within h would show as more.
        let h = 1e-6;
        let central = (at(h) - at(-h)) / (2.0 * h);
        assert!(
            (central - slopes[index]).abs() < 1e-6 * scale,
            "{index}: {central} {}",
            slopes[index]
        );
        compared += 1;
    }
    assert_eq!(compared, 123);
}

#[test]
fn what_is_simulated_once_equals_the_full_roll_out() {
    for clamp in [GlucoseClamp::Reproduction, GlucoseClamp::Off] {
        let twin = twin_of(trained_looking(3), clamp);
        for window in windows(clamp, 60) {
            let run = simulate(&twin, window.start(), &mut OpenLoop::new(window.inputs()), 60)
                .expect("finite");
            let simulated: Vec<f64> = run.states.iter().map(|x| x[Compartment::Q1]).collect();
            let full = TwinLoss::PAPER.scaled_by(&twin.population).of(&simulated, window.target());
            let once = window_loss(
                &twin.population,
                &twin.residual,
                std::slice::from_ref(&window),
                TwinLoss::PAPER,
            )
            .expect("a window");
            // Sums of some hundred products in f64, in another order.
            assert!((full - once).abs() < 1e-12 * full, "{full} {once}");
            assert!(twin.glucose(&run.states[60]).0.is_finite());
        }
    }
}

#[test]
fn runs_side_by_side_are_those_of_the_loop() {
    let twin = twin_of(trained_looking(3), GlucoseClamp::Reproduction);
    let day = exercising_day(288 + 40);
    // More runs than lanes, each with a start and inputs of its own.
    let runs: Vec<(ScaledStates, &[physiology::StepInput])> = (0..40)
        .map(|run| {
            let mut start = start();
            start[Compartment::Q1] = -0.5 + 0.05 * run as f64;
            (start, &day[run..run + 288])
        })
        .collect();
    let (starts, inputs): (Vec<_>, Vec<_>) = runs.iter().copied().unzip();
    let many = simulate_many(&twin, &starts, &inputs).expect("finite");
    let mut spread = 0.0_f64;
    for ((start, inputs), found) in runs.into_iter().zip(&many) {
        let run = simulate(&twin, start, &mut OpenLoop::new(inputs), 288).expect("finite");
        for (state, glucose) in run.states.iter().zip(found) {
            let expected = twin.glucose(state).0;
            // Single precision over 288 steps of a stable plant.
            assert!((expected - glucose.0).abs() < 0.05, "{expected} {}", glucose.0);
            spread = spread.max((expected - twin.glucose(&run.states[0]).0).abs());
        }
    }
    assert!(spread > 50.0, "glucose moves by {spread}");
    assert!(simulate_many(&twin, &starts[1..], &inputs).is_err());
}

fn flat(network: &ResidualNetwork) -> Vec<f64> {
    let variables = ResidualVariables::new(network).expect("variables");
    let parts = variables.variables().iter();
    parts.flat_map(|v| v.flatten_all().expect("flat").to_vec1::<f64>().expect("f64")).collect()
}

fn unflat(values: &[f64]) -> ResidualNetwork {
    let variables = ResidualVariables::new(&ResidualNetwork::zeros()).expect("variables");
    let mut rest = values;
    for variable in variables.variables() {
        let (part, following) = rest.split_at(variable.elem_count());
        let part = Tensor::from_slice(part, variable.shape(), &candle_core::Device::Cpu);
        variable.set(&part.expect("as many values")).expect("same shape");
        rest = following;
    }
    variables.network().expect("eight variables")
}
