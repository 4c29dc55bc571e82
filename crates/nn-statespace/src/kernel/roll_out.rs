//! The interface of the kernel.

use physiology::Compartment;
use rayon::prelude::*;

use super::backward::Backward;
use super::block::{BLOCK, Block};
use super::forward::Forward;
use super::instructions::Instructions;
use super::layout::ParameterLayout;
use super::real::Real;
use super::units::{Networks, slopes_of_weights};
use crate::error::ModelError;
use crate::network::shaped;
use crate::training::windows::{INPUTS, STATES};
use crate::widths::Widths;
use crate::wiring::Wiring;

/// A sequence to roll out, scaled; states follow [`Compartment::ALL`].
#[derive(Debug, Clone, Copy)]
pub struct Sequence<'a, T> {
    /// The states at the start, shape (10).
    pub initial: &'a [T],
    /// Insulin and carbohydrate of each step, shape (steps, 2), row-major.
    pub inputs: &'a [T],
    /// What the states should be after each step, shape (steps, 10), row-major; empty where nothing
    /// is compared.
    pub truth: &'a [T],
}

/// A loss that is a sum over samples, steps and states.
pub trait StateLoss<T>: Sync {
    /// The terms of one state at one step, for some samples: adds each term to `values` and writes
    /// its slope by the simulated state to `slopes`. All slices are of one length.
    fn terms(
        &self,
        compartment: Compartment,
        simulated: &[T],
        truth: &[T],
        slopes: &mut [T],
        values: &mut [T],
    );
}

/// The roll-out of the population network over batches, and its gradient.
///
/// Steps are Forward Euler in scaled space, `x += 5 dx` (paper, algorithm of the training process).
/// It keeps its memory from batch to batch: for 128 sequences of 60 steps and the paper's networks
/// about 3 MiB in single precision.
#[derive(Debug)]
pub struct FusedRollOut<T> {
    layout: ParameterLayout,
    networks: Networks<T>,
    glucose_range: Option<(T, T)>,
    instructions: Instructions,
    blocks: Vec<Block<T>>,
}

impl<T: Real> FusedRollOut<T> {
    /// For networks of these widths, with Q1 running free, on the machine's fastest instructions.
    #[must_use]
    pub fn new(wiring: &Wiring, widths: &Widths) -> Self {
        Self {
            layout: ParameterLayout::new(wiring, widths),
            networks: Networks::new(wiring),
            glucose_range: None,
            instructions: Instructions::best(),
            blocks: Vec::new(),
        }
    }

    /// The same with Q1 confined to this range after every step, in scaled units.
    #[must_use]
    pub fn with_glucose_range(mut self, range: (f64, f64)) -> Self {
        self.glucose_range = Some((T::of(range.0), T::of(range.1)));
        self
    }

    /// The same on these instructions; on the portable ones if the machine does not have them.
    #[must_use]
    pub fn with_instructions(mut self, instructions: Instructions) -> Self {
        self.instructions = instructions;
        self
    }

    /// Where each weight stands in a vector of parameters.
    #[must_use]
    pub fn layout(&self) -> &ParameterLayout {
        &self.layout
    }

    /// The states after each step, shape (sequences, steps, 10), row-major.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if parameters or sequences do not fit, [`ModelError::NotFinite`] if a
    /// parameter is not a finite number. States that leave the finite numbers are returned as they
    /// are.
    pub fn simulate(
        &mut self,
        parameters: &[T],
        batch: &[Sequence<'_, T>],
    ) -> Result<Vec<T>, ModelError> {
        let steps = self.begin(parameters, batch)?;
        let Self { networks, glucose_range, instructions, blocks, .. } = self;
        let mut states = vec![T::ZERO; batch.len() * steps * STATES];
        let parts = states.par_chunks_mut(BLOCK * steps * STATES);
        blocks.par_iter_mut().zip(batch.par_chunks(BLOCK)).zip(parts).for_each(
            |((block, sequences), states)| {
                block.load(sequences, steps);
                let glucose_range = *glucose_range;
                T::dispatch(*instructions, Forward { networks, glucose_range, block });
                block.store(states);
            },
        );
        Ok(states)
    }

    /// The loss of the batch and its slopes by the parameters, which are written to `gradient`.
    ///
    /// The result is the same for any number of threads. A unit exactly at its kink counts as
    /// inactive.
    ///
    /// # Errors
    /// Those of [`Self::simulate`], and [`ModelError::Shape`] if the truth or `gradient` is of
    /// another length. A loss that is not a finite number is returned as it is.
    pub fn gradient(
        &mut self,
        parameters: &[T],
        batch: &[Sequence<'_, T>],
        loss: &impl StateLoss<T>,
        gradient: &mut [T],
    ) -> Result<f64, ModelError> {
        let steps = self.begin(parameters, batch)?;
        shaped("parameters", &[self.layout.len], &[gradient.len()])?;
        for (index, Sequence { truth, .. }) in batch.iter().enumerate() {
            shaped(format_args!("truth of sequence {index}"), &[steps * STATES], &[truth.len()])?;
        }
        let Self { layout, networks, glucose_range, instructions, blocks } = self;
        blocks.par_iter_mut().zip(batch.par_chunks(BLOCK)).for_each(|(block, sequences)| {
            let (glucose_range, layout, networks) = (*glucose_range, &*layout, &*networks);
            block.load(sequences, steps);
            block.load_truth(sequences);
            let forward = Forward { networks, glucose_range, block: &mut *block };
            T::dispatch(*instructions, forward);
            judge(block, loss);
            let backward = Backward { networks, layout, glucose_range, block };
            T::dispatch(*instructions, backward);
        });
        gradient.fill(T::ZERO);
        let mut value = 0.0;
        for block in &*blocks {
            value += block.loss;
            for (sum, part) in gradient.iter_mut().zip(&block.sums) {
                *sum = *sum + *part;
            }
        }
        slopes_of_weights(layout, parameters, gradient);
        Ok(value)
    }

    /// Takes over the parameters, makes a block for each part of the batch and returns its steps.
    fn begin(&mut self, parameters: &[T], batch: &[Sequence<'_, T>]) -> Result<usize, ModelError> {
        self.networks.set(&self.layout, parameters)?;
        let steps = batch.first().map_or(0, |sequence| sequence.inputs.len() / INPUTS);
        for (index, Sequence { initial, inputs, .. }) in batch.iter().enumerate() {
            shaped(format_args!("initial of sequence {index}"), &[STATES], &[initial.len()])?;
            shaped(format_args!("inputs of sequence {index}"), &[steps * INPUTS], &[inputs.len()])?;
        }
        shaped("inputs", &[steps.max(1), INPUTS], &[steps, INPUTS])?;
        self.blocks.resize_with(batch.len().div_ceil(BLOCK), Block::default);
        Ok(steps)
    }
}

/// The loss of a block and its slopes by the states.
fn judge<T: Real>(block: &mut Block<T>, loss: &impl StateLoss<T>) {
    let used = block.used;
    block.adjoint.resize(block.steps(), [[T::ZERO; BLOCK]; STATES]);
    let mut values = [T::ZERO; BLOCK];
    let rows = block.signals[1..].iter().zip(&block.truth).zip(&mut block.adjoint);
    for ((simulated, truth), slopes) in rows {
        for compartment in Compartment::ALL {
            let state = compartment as usize;
            let slopes = &mut slopes[state];
            slopes[used..].fill(T::ZERO);
            loss.terms(
                compartment,
                &simulated[state][..used],
                &truth[state][..used],
                &mut slopes[..used],
                &mut values[..used],
            );
        }
    }
    block.loss = values[..used].iter().map(|value| value.to_f64()).sum();
}
