//! The roll-out against the same loss in candle's graph, slower and its oracle, against central
//! differences, and against a full simulation.
//!
//! Shapes: `batch` windows side by side in rows; time runs over the operations of the graph.

use candle_core::{DType, Device, Result, Tensor, Var};
use nn_statespace::{GlucoseClamp, PopulationModel, ScaledStates, Signal};
use physiology::{Compartment, OpenLoop, Plant, STEP, simulate};

use crate::inputs::{INPUTS, InputSet};
use crate::loss::{ScaledLoss, TwinLoss};
use crate::prepared::{Known, PreparedWindow, network_input};
use crate::residual::{PARAMETERS, ResidualNetwork, SHAPES};
use crate::roll_out::{TwinRollOut, network_of, parameters_of, simulate_many};
use crate::synthetic::{exercising_day, population, trained_looking, twin_of};
use crate::training::{window_courses, window_loss};

/// The network's parameters as variables, f64 on the CPU: weight, shape `(inputs, outputs)`, and
/// bias of each layer, in turn.
fn variables_of(network: &ResidualNetwork) -> Result<Vec<Var>> {
    let mut variables = Vec::with_capacity(8);
    for (layer, shape) in network.layers.iter().zip(SHAPES) {
        let (weight, bias) = (layer.weight.as_slice(), layer.bias.as_slice());
        variables.push(Var::from_slice(weight, shape, &Device::Cpu)?);
        variables.push(Var::from_slice(bias, (1, shape.1), &Device::Cpu)?);
    }
    Ok(variables)
}

fn residual_rate(variables: &[Var], input: &Tensor) -> Result<Tensor> {
    let mut x = input.clone();
    for (i, pair) in variables.chunks_exact(2).enumerate() {
        x = x.matmul(&pair[0])?.broadcast_add(&pair[1])?;
        if i < 3 {
            x = x.relu()?;
        }
    }
    Ok(x)
}

/// Mean loss of windows of one length as a scalar tensor whose graph reaches the variables.
///
/// Glucose flows through the frozen population networks of Q1 and Q2, so that a gradient crosses
/// all steps of a window.
fn graph_loss(
    population: &PopulationModel,
    variables: &[Var],
    windows: &[&PreparedWindow],
) -> Result<Tensor> {
    let scaled = TwinLoss::PAPER.scaled_by(population);
    let steps = windows[0].steps();
    let column = |value: &dyn Fn(&PreparedWindow) -> f64| -> Result<Tensor> {
        let values: Vec<f64> = windows.iter().map(|w| value(w)).collect();
        Tensor::from_vec(values, (windows.len(), 1), &Device::Cpu)
    };
    let mut q1 = column(&|w| w.start()[Compartment::Q1])?;
    let mut q2 = column(&|w| w.start()[Compartment::Q2])?;
    let mut error = q1.zeros_like()?;
    let mut sum = Tensor::zeros((), DType::F64, &Device::Cpu)?;
    for step in 0..steps {
        let known = known_inputs(windows, step)?;
        let residual = residual_rate(variables, &Tensor::cat(&[&q1, &q2, &known], 1)?)?;
        let rate_1 = rate(population, Compartment::Q1, windows, step, &q1, &q2)?;
        let rate_2 = rate(population, Compartment::Q2, windows, step, &q1, &q2)?;
        let added_rate = column(&|w| w.added_rates[step])?;
        q1 = clamp(population, &(q1 + (((rate_1 + residual)? + added_rate)? * STEP.0)?)?)?;
        q2 = (q2 + (rate_2 * STEP.0)?)?;
        let measured = column(&|w| w.target()[step + 1])?;
        let following = (&q1 - &measured)?;
        let penalty = penalties(&scaled, &q1, windows, step)?;
        let fit = (following.sqr()? * penalty)?.sum_all()?;
        let change = (&following - &error)?.sqr()?.sum_all()?;
        sum = ((sum + fit)? + (change * TwinLoss::PAPER.consistency)?)?;
        error = following;
    }
    sum / (steps * windows.len()) as f64
}

/// Inputs of the residual network after Q1 and Q2, shape `(batch, 8)`.
fn known_inputs(windows: &[&PreparedWindow], step: usize) -> Result<Tensor> {
    let mut values = Vec::with_capacity(windows.len() * (INPUTS - 2));
    for window in windows {
        let (x, _) = window.known(step);
        values.extend_from_slice(&network_input(x, &window.personal[step])[2..]);
    }
    Tensor::from_vec(values, (windows.len(), INPUTS - 2), &Device::Cpu)
}

/// The frozen rate of a compartment, shape `(batch, 1)`.
fn rate(
    population: &PopulationModel,
    compartment: Compartment,
    windows: &[&PreparedWindow],
    step: usize,
    q1: &Tensor,
    q2: &Tensor,
) -> Result<Tensor> {
    let mut columns = Vec::new();
    for signal in population.wiring().inputs(compartment) {
        columns.push(match signal {
            Signal::State(Compartment::Q1) => q1.clone(),
            Signal::State(Compartment::Q2) => q2.clone(),
            known => {
                let value = |window: &&PreparedWindow| {
                    let (x, u) = window.known(step);
                    match known {
                        Signal::State(state) => x[*state],
                        Signal::Insulin => u.insulin,
                        Signal::Carbs => u.carbs,
                    }
                };
                let values: Vec<f64> = windows.iter().map(value).collect();
                Tensor::from_vec(values, (windows.len(), 1), &Device::Cpu)?
            }
        });
    }
    let network = population.network(compartment);
    let (hidden, inputs) = (network.hidden(), network.inputs());
    let w1 = Tensor::from_slice(network.w1(), (hidden, inputs), &Device::Cpu)?;
    let b1 = Tensor::from_slice(network.b1(), (1, hidden), &Device::Cpu)?;
    let w2 = Tensor::from_slice(network.w2(), (hidden, 1), &Device::Cpu)?;
    let activation = Tensor::cat(&columns, 1)?.matmul(&w1.t()?)?.broadcast_add(&b1)?.relu()?;
    activation.matmul(&w2)? + network.b2()
}

fn clamp(population: &PopulationModel, q1: &Tensor) -> Result<Tensor> {
    match population.clamp() {
        GlucoseClamp::Reproduction => {
            let (lowest, highest) = population.scaled_glucose_range();
            q1.clamp(lowest, highest)
        }
        GlucoseClamp::Off => Ok(q1.clone()),
    }
}

/// Penalties at the present values, constants of the graph, shape `(batch, 1)`.
fn penalties(
    loss: &ScaledLoss,
    q1: &Tensor,
    windows: &[&PreparedWindow],
    step: usize,
) -> Result<Tensor> {
    let simulated: Vec<f64> = q1.detach().flatten_all()?.to_vec1()?;
    let values: Vec<f64> = simulated
        .iter()
        .zip(windows)
        .map(|(q1, window)| loss.penalty(*q1, window.target()[step + 1]))
        .collect();
    Tensor::from_vec(values, (windows.len(), 1), &Device::Cpu)
}

/// The loss of windows by the graph, and its slopes by each variable.
fn by_graph(
    population: &PopulationModel,
    network: &ResidualNetwork,
    windows: &[&PreparedWindow],
) -> Result<(f64, Vec<Vec<f64>>)> {
    let variables = variables_of(network)?;
    let loss = graph_loss(population, &variables, windows)?;
    let store = loss.backward()?;
    let mut slopes = Vec::with_capacity(variables.len());
    for variable in &variables {
        let slope = store.get(variable).expect("every variable has a gradient");
        slopes.push(slope.flatten_all()?.to_vec1::<f64>()?);
    }
    Ok((loss.to_scalar::<f64>()?, slopes))
}

/// The same by the fused roll-out, in f64, slopes one after the other.
fn by_roll_out(
    population: &PopulationModel,
    network: &ResidualNetwork,
    windows: &[&PreparedWindow],
) -> (f64, Vec<f64>) {
    let loss = TwinLoss::PAPER.scaled_by(population);
    let mut roll_out = TwinRollOut::<f64>::new(population, loss).expect("finite weights");
    let mut gradient = vec![0.0; PARAMETERS];
    let sum = roll_out.loss(&parameters_of(network), windows, Some(&mut gradient));
    let share = 1.0 / windows.len() as f64;
    (sum * share, gradient.into_iter().map(|slope| slope * share).collect())
}

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
        let (loss, fused) = by_roll_out(&population, &network, &windows);
        let (value, slopes) = by_graph(&population, &network, &windows).expect("a graph");
        // Both sum some 1e6 products in f64, in different order.
        assert!((loss - value).abs() < 1e-10 * loss.abs().max(1.0), "{loss} {value}");
        assert_eq!(slopes.iter().map(Vec::len).sum::<usize>(), fused.len());
        let mut ours = fused.iter();
        for theirs in &slopes {
            let largest = |most: f64, value: f64| most.max(value.abs());
            let size = theirs.iter().copied().fold(0.0, largest);
            let deviation = theirs.iter().zip(&mut ours).map(|(a, b)| a - b).fold(0.0, largest);
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
    let (loss, expected) = by_roll_out(&population, &network, &both);
    let (value, slopes) = by_graph(&population, &network, &both).expect("a graph");
    assert!((loss - value).abs() < 1e-10 * value, "{loss} {value}"); // rounding
    let found = slopes.concat();
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
    let (_, slopes) = by_roll_out(&population, &network, &windows);
    let values: Vec<f64> = parameters_of(&network);
    let scale = slopes.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    // Every 97th parameter, and the last layer's bias.
    let mut compared = 0;
    for index in (0..values.len()).step_by(97).chain([values.len() - 1]) {
        let at = |h: f64| {
            let mut moved = values.clone();
            moved[index] += h;
            window_loss(&population, &network_of(&moved), &owned, TwinLoss::PAPER).expect("windows")
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
