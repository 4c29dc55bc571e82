//! The fused roll-out of a twin: windows side by side in lanes, through the loop and back.
//!
//! The population model is frozen inside the loop, but glucose flows through it: a change of Q1 at
//! one step changes the population's rates of Q1 and Q2 at the next. Within a step everything is
//! piecewise linear, so that the way back needs the slopes of the three rates (population Q1 and
//! Q2, residual) by Q1 and Q2, and weighs each step's gradient of the residual network by what a
//! change of its output does to the loss. `graph.rs` computes the same in candle's graph, against
//! which this is tested.

mod residual_lanes;
mod simulate;

use nn_statespace::kernel::{LANES, LaneSteps, Real, Signals};
use nn_statespace::{PopulationModel, Signal};
use physiology::{Compartment, STEP};

use self::residual_lanes::{Activations, Slopes, add_gradient, evaluate, slopes};
use crate::error::TwinError;
use crate::inputs::{INPUTS, STATE_INPUTS};
use crate::loss::ScaledLoss;
use crate::prepared::{GLUCOSE, PreparedWindow, network_input};

pub(crate) use self::residual_lanes::{network_of, parameters_of};
pub use simulate::simulate_many;

/// The precisions of the roll-out: single to train in, double to check gradients in.
pub(crate) trait Precision: Real + faer::traits::ComplexField {}
impl Precision for f32 {}
impl Precision for f64 {}

/// What one step left behind for the way back.
#[derive(Debug, Clone)]
struct StepTape<T> {
    activations: Activations<T>,
    /// Slopes of the population's steps of Q1 and Q2 by Q1 and Q2, the states themselves not in.
    population: [[[T; LANES]; 2]; 2],
    confined: [bool; LANES],
}

/// Rolls windows out and back with the memory of earlier ones.
#[derive(Debug)]
pub(crate) struct TwinRollOut<T> {
    steps: LaneSteps<T>,
    loss: ScaledLoss,
    tape: Vec<StepTape<T>>,
    slopes: Slopes<T>,
    /// Simulated Q1 after each step, the start first.
    glucose: Vec<[T; LANES]>,
    /// Slopes of the loss by them.
    adjoint: Vec<[T; LANES]>,
}

impl<T: Precision> TwinRollOut<T> {
    pub(crate) fn new(population: &PopulationModel, loss: ScaledLoss) -> Result<Self, TwinError> {
        Ok(Self {
            steps: LaneSteps::new(population, &GLUCOSE)?,
            loss,
            tape: Vec::new(),
            slopes: Slopes::new(),
            glucose: Vec::new(),
            adjoint: Vec::new(),
        })
    }

    /// Sum of the losses of windows of one length; its slopes by the parameters are added to
    /// `gradient`, if there is one.
    pub(crate) fn loss(
        &mut self,
        parameters: &[T],
        windows: &[&PreparedWindow],
        mut gradient: Option<&mut [T]>,
    ) -> f64 {
        let keep = if gradient.is_some() { Keep::Everything } else { Keep::Glucose };
        let mut sum = 0.0;
        for block in windows.chunks(LANES) {
            self.forward(parameters, block, keep);
            sum += self.judge(block);
            if let Some(gradient) = gradient.as_deref_mut() {
                self.backward(parameters, gradient);
            }
        }
        sum
    }

    /// Scaled glucose of free runs through windows of one length, the start first.
    pub(crate) fn courses(
        &mut self,
        parameters: &[T],
        windows: &[&PreparedWindow],
    ) -> Vec<Vec<f64>> {
        let mut courses = Vec::with_capacity(windows.len());
        for block in windows.chunks(LANES) {
            self.forward(parameters, block, Keep::Glucose);
            let lane = |lane: usize| self.glucose.iter().map(|row| row[lane].to_f64()).collect();
            courses.extend((0..block.len()).map(lane));
        }
        courses
    }

    fn forward(&mut self, parameters: &[T], block: &[&PreparedWindow], keep: Keep) {
        let count = block[0].steps();
        let tapes = if keep == Keep::Everything { count } else { 1 };
        self.tape.resize_with(tapes, || StepTape {
            activations: Activations::new(),
            population: [[[T::ZERO; LANES]; 2]; 2],
            confined: [false; LANES],
        });
        self.glucose.clear();
        let step_size = T::of(STEP.0);
        let mut now: Signals<T> = [[T::ZERO; LANES]; 12];
        for (lane, window) in lanes(block).enumerate() {
            for compartment in GLUCOSE {
                now[compartment as usize][lane] = T::of(window.start()[compartment]);
            }
        }
        let mut next = now;
        self.glucose.push(now[Compartment::Q1 as usize]);
        for step in 0..count {
            let tape = &mut self.tape[if keep == Keep::Everything { step } else { 0 }];
            let mut added_rates = [T::ZERO; LANES];
            for (lane, window) in lanes(block).enumerate() {
                load(window, step, lane, &mut now, &mut tape.activations);
                added_rates[lane] = T::of(window.added_rates[step]);
            }
            // Q1 and Q2 lead the residual network's inputs.
            for (input, compartment) in tape.activations.input.iter_mut().zip(GLUCOSE) {
                *input = now[compartment as usize];
            }
            let residual = evaluate(parameters, &mut tape.activations);
            self.steps.step(&now, &mut next);
            let rates = residual.into_iter().zip(added_rates);
            for (q1, (residual, added_rate)) in next[Compartment::Q1 as usize].iter_mut().zip(rates)
            {
                *q1 += step_size * (residual + added_rate);
            }
            tape.confined = self.steps.confine_glucose(&mut next);
            if keep == Keep::Everything {
                for (of, slopes) in GLUCOSE.into_iter().zip(&mut tape.population) {
                    for (by, slope) in GLUCOSE.into_iter().zip(slopes) {
                        let known = self.steps.slope(of, Signal::State(by));
                        *slope = known.copied().unwrap_or([T::ZERO; LANES]);
                    }
                }
            }
            for compartment in GLUCOSE {
                now[compartment as usize] = next[compartment as usize];
            }
            self.glucose.push(now[Compartment::Q1 as usize]);
        }
    }

    /// The block's loss; its slopes by glucose go to `adjoint`, those of idle lanes are 0.
    fn judge(&mut self, block: &[&PreparedWindow]) -> f64 {
        self.adjoint.clear();
        self.adjoint.resize(self.glucose.len(), [T::ZERO; LANES]);
        let mut sum = 0.0;
        let mut slope = Vec::new();
        for (lane, window) in block.iter().enumerate() {
            let simulated: Vec<f64> = self.glucose.iter().map(|row| row[lane].to_f64()).collect();
            sum += self.loss.of(&simulated, window.target());
            slope.clear();
            slope.resize(simulated.len(), 0.0);
            self.loss.add_slope(&simulated, window.target(), &mut slope);
            for (row, slope) in self.adjoint.iter_mut().zip(&slope) {
                row[lane] = T::of(*slope);
            }
        }
        sum
    }

    fn backward(&mut self, parameters: &[T], gradient: &mut [T]) {
        let step_size = T::of(STEP.0);
        let (mut to_q1, mut to_q2) = ([T::ZERO; LANES], [T::ZERO; LANES]);
        for (tape, adjoint) in self.tape.iter().zip(&self.adjoint[1..]).rev() {
            for ((to, adjoint), confined) in to_q1.iter_mut().zip(adjoint).zip(tape.confined) {
                *to = if confined { T::ZERO } else { *to + *adjoint };
            }
            let by_glucose = slopes(parameters, &tape.activations, &mut self.slopes);
            let mut factors = [T::ZERO; LANES];
            for lane in 0..LANES {
                let (q1, q2) = (to_q1[lane], to_q2[lane]);
                factors[lane] = step_size * q1;
                let [[p11, p12], [p21, p22]] =
                    tape.population.map(|slopes| slopes.map(|row| row[lane]));
                to_q1[lane] = q1 + q1 * p11 + q2 * p21 + factors[lane] * by_glucose[0][lane];
                to_q2[lane] = q2 + q1 * p12 + q2 * p22 + factors[lane] * by_glucose[1][lane];
            }
            add_gradient(&tape.activations, &mut self.slopes, &factors, gradient);
        }
    }
}

/// What a roll-out keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Keep {
    Glucose,
    Everything,
}

/// The windows of a block and, for its idle lanes, the first of them again.
fn lanes<'a>(block: &'a [&'a PreparedWindow]) -> impl Iterator<Item = &'a PreparedWindow> {
    (0..LANES).map(|lane| block.get(lane).copied().unwrap_or(block[0]))
}

/// Writes what a step knows beforehand, that is all but Q1 and Q2, into a lane.
fn load<T: Precision>(
    window: &PreparedWindow,
    step: usize,
    lane: usize,
    now: &mut Signals<T>,
    activations: &mut Activations<T>,
) {
    let (states, input) = window.known(step);
    for compartment in Compartment::ALL {
        if !GLUCOSE.contains(&compartment) {
            now[compartment as usize][lane] = T::of(states[compartment]);
        }
    }
    now[Signal::Insulin.row()][lane] = T::of(input.insulin);
    now[Signal::Carbs.row()][lane] = T::of(input.carbs);
    let seen = network_input(states, &window.personal[step]);
    for (row, value) in activations.input.iter_mut().zip(seen).skip(GLUCOSE.len()) {
        row[lane] = T::of(value);
    }
}

const _: () = assert!(STATE_INPUTS > GLUCOSE.len() && INPUTS > STATE_INPUTS);
