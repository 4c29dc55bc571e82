//! Loss of a window and its gradient: roll-out and back-propagation through time, by hand.
//!
//! The population model is frozen inside the loop, but glucose flows through it: a change of Q1 at
//! one step changes the population's rates of Q1 and Q2 at the next. [`crate::graph`] computes the
//! same in candle's graph and is what this is tested against.

use nn_statespace::{PopulationModel, ScaledStates, Signal};
use physiology::{Compartment, STEP};

use crate::inputs::INPUTS;
use crate::loss::ScaledLoss;
use crate::prepared::{PreparedWindow, network_input};
use crate::residual::{HIDDEN, Layer, ResidualNetwork};

/// Everything of a roll-out that the way back needs, reused from window to window.
#[derive(Debug, Default)]
pub(crate) struct Tape {
    glucose: Vec<f64>,
    slope: Vec<f64>,
    steps: Vec<StepTape>,
}

#[derive(Debug, Clone)]
struct StepTape {
    input: [f64; INPUTS],
    first: [f64; HIDDEN[0]],
    second: [f64; HIDDEN[1]],
    third: [f64; HIDDEN[2]],
    /// d rate / d state of the population model: rows Q1, Q2, columns Q1, Q2.
    population: [[f64; 2]; 2],
    clamped: bool,
}

impl StepTape {
    const EMPTY: Self = Self {
        input: [0.0; INPUTS],
        first: [0.0; HIDDEN[0]],
        second: [0.0; HIDDEN[1]],
        third: [0.0; HIDDEN[2]],
        population: [[0.0; 2]; 2],
        clamped: false,
    };
}

/// What both passes over a window share.
#[derive(Clone, Copy)]
pub(crate) struct Objective<'a> {
    pub(crate) population: &'a PopulationModel,
    pub(crate) loss: ScaledLoss,
}

impl Objective<'_> {
    /// Loss of a window.
    pub(crate) fn loss(
        &self,
        network: &ResidualNetwork,
        window: &PreparedWindow,
        tape: &mut Tape,
    ) -> f64 {
        self.forward::<false>(network, window, tape);
        self.loss.of(&tape.glucose, window.target())
    }

    /// Loss of a window; its gradient is added to `gradient`.
    pub(crate) fn loss_and_gradient(
        &self,
        network: &ResidualNetwork,
        window: &PreparedWindow,
        tape: &mut Tape,
        gradient: &mut ResidualNetwork,
    ) -> f64 {
        self.forward::<true>(network, window, tape);
        let loss = self.loss.of(&tape.glucose, window.target());
        tape.slope.clear();
        tape.slope.resize(tape.glucose.len(), 0.0);
        self.loss.add_slope(&tape.glucose, window.target(), &mut tape.slope);
        backward(network, tape, gradient);
        loss
    }

    fn forward<const KEEP: bool>(
        &self,
        network: &ResidualNetwork,
        window: &PreparedWindow,
        tape: &mut Tape,
    ) {
        let steps = window.steps();
        tape.steps.resize(if KEEP { steps } else { 1 }, StepTape::EMPTY);
        tape.glucose.clear();
        let start = window.start();
        let (mut q1, mut q2) = (start[Compartment::Q1], start[Compartment::Q2]);
        tape.glucose.push(q1);
        for step in 0..steps {
            let record = &mut tape.steps[if KEEP { step } else { 0 }];
            let x = window.states_with(step, q1, q2);
            record.input = network_input(&x, window.personal(step));
            let residual = forward_network(network, record);
            let u = self.population.scaler().scale_input(&window.inputs()[step]);
            q1 += STEP.0 * (self.population.rate(Compartment::Q1, &x, u) + residual);
            q2 += STEP.0 * self.population.rate(Compartment::Q2, &x, u);
            if KEEP {
                record.population = self.slopes(&x, u);
            }
            let free = q1;
            q1 = self.clamped(q1);
            record.clamped = q1 != free;
            tape.glucose.push(q1);
        }
    }

    fn clamped(&self, q1: f64) -> f64 {
        match self.population.clamp() {
            nn_statespace::GlucoseClamp::Reproduction => {
                let (lowest, highest) = self.population.scaled_glucose_range();
                q1.clamp(lowest, highest)
            }
            nn_statespace::GlucoseClamp::Off => q1,
        }
    }

    /// d rate / d state: rows Q1, Q2, columns Q1, Q2.
    fn slopes(&self, x: &ScaledStates, u: nn_statespace::ScaledInputs) -> [[f64; 2]; 2] {
        [Compartment::Q1, Compartment::Q2].map(|compartment| {
            let signals = self.population.wiring().inputs(compartment);
            let mut gathered = [0.0; 12];
            let mut gradient = [0.0; 12];
            for (slot, signal) in gathered.iter_mut().zip(signals) {
                *slot = match signal {
                    Signal::State(c) => x[*c],
                    Signal::Insulin => u.insulin,
                    Signal::Carbs => u.carbs,
                };
            }
            let n = signals.len();
            self.population.network(compartment).add_gradient(
                &gathered[..n],
                1.0,
                &mut gradient[..n],
            );
            [Compartment::Q1, Compartment::Q2].map(|state| {
                let column = signals.iter().position(|s| *s == Signal::State(state));
                column.map_or(0.0, |column| gradient[column])
            })
        })
    }
}

fn forward_network(network: &ResidualNetwork, record: &mut StepTape) -> f64 {
    let [l0, l1, l2, l3] = network.layers();
    l0.apply(&record.input, &mut record.first);
    crate::residual::rectify(&mut record.first);
    l1.apply(&record.first, &mut record.second);
    crate::residual::rectify(&mut record.second);
    l2.apply(&record.second, &mut record.third);
    crate::residual::rectify(&mut record.third);
    let mut output = [0.0];
    l3.apply(&record.third, &mut output);
    output[0]
}

fn backward(network: &ResidualNetwork, tape: &Tape, gradient: &mut ResidualNetwork) {
    let (mut to_q1, mut to_q2) = (0.0, 0.0);
    for (step, record) in tape.steps.iter().enumerate().rev() {
        to_q1 += tape.slope[step + 1];
        if record.clamped {
            to_q1 = 0.0;
        }
        let (rate_1, rate_2) = (STEP.0 * to_q1, STEP.0 * to_q2);
        let through = backward_network(network, record, rate_1, gradient);
        let [[p11, p12], [p21, p22]] = record.population;
        to_q1 += rate_1 * p11 + rate_2 * p21 + through[0];
        to_q2 += rate_1 * p12 + rate_2 * p22 + through[1];
    }
}

/// Adds `output` times the gradient of the network's output; returns `output` times its slopes in
/// the first two inputs, Q1 and Q2.
fn backward_network(
    network: &ResidualNetwork,
    record: &StepTape,
    output: f64,
    gradient: &mut ResidualNetwork,
) -> [f64; 2] {
    let layers = network.layers();
    let grads = gradient.layers_mut();
    let mut third = [0.0; HIDDEN[2]];
    let mut second = [0.0; HIDDEN[1]];
    let mut first = [0.0; HIDDEN[0]];
    let mut input = [0.0; INPUTS];
    back(&layers[3], &mut grads[3], &record.third, &[output], &mut third);
    back(&layers[2], &mut grads[2], &record.second, &third, &mut second);
    back(&layers[1], &mut grads[1], &record.first, &second, &mut first);
    back(&layers[0], &mut grads[0], &record.input, &first, &mut input);
    [input[0], input[1]]
}

/// One layer back. `slope` is that of the layer's output. An input of exactly 0 is a closed unit
/// (or an input that is 0): it moves no weight, and behind a ReLU no slope passes. For the
/// network's own inputs, Q1 and Q2 may be 0 and still need their slope, so that the first layer
/// (the one with [`INPUTS`] inputs) passes it on all the same.
fn back(layer: &Layer, gradient: &mut Layer, input: &[f64], slope: &[f64], passed: &mut [f64]) {
    for (g, s) in gradient.bias.iter_mut().zip(slope) {
        *g += s;
    }
    let width = slope.len();
    let rows = layer.weight.chunks_exact(width).zip(gradient.weight.chunks_exact_mut(width));
    for ((x, p), (weights, grads)) in input.iter().zip(passed).zip(rows) {
        if *x != 0.0 {
            for (g, s) in grads.iter_mut().zip(slope) {
                *g += x * s;
            }
            *p = dot(weights, slope);
        } else if input.len() == INPUTS {
            *p = dot(weights, slope);
        }
    }
}

/// Eight partial sums, so that the additions can run side by side.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let (a_blocks, b_blocks) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a_blocks.remainder().iter().zip(b_blocks.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a_blocks.zip(b_blocks) {
        for lane in 0..8 {
            lanes[lane] += x[lane] * y[lane];
        }
    }
    lanes.iter().sum::<f64>() + rest
}
