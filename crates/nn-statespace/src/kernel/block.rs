//! The memory of one block of samples, which stays in a core's cache.

use super::Sequence;
use super::real::Real;
use crate::training::windows::{INPUTS, SIGNALS, STATES};

/// Samples of a block.
pub(super) const BLOCK: usize = 32;
/// Lanes in which sums over samples are kept apart, whatever the width of a vector, so that every
/// width gives the same sums.
pub(super) const WIDE: usize = 16;

/// Groups of [`WIDE`] samples in a block.
pub(super) const PARTS: usize = BLOCK / WIDE;

/// One value a sample.
pub(super) type Row<T> = [T; BLOCK];

/// A block of sequences. Time is the outermost axis throughout; samples are the innermost.
#[derive(Debug, Default)]
pub(super) struct Block<T> {
    /// Samples; the rows beyond repeat the last of them, and their slopes are 0.
    pub(super) used: usize,
    /// The signals before each step and, in the last row, the states after the last one.
    pub(super) signals: Vec<[Row<T>; SIGNALS]>,
    /// What the states should be after each step.
    pub(super) truth: Vec<[Row<T>; STATES]>,
    /// Slopes of each state's step by what its network sees, for each step.
    pub(super) slopes: Vec<Row<T>>,
    /// Activity of every unit in every step, 16 samples a number, where it is kept: shape (steps,
    /// parts of the block, units).
    pub(super) activity: Vec<u16>,
    /// Slopes of the loss by the states after each step: at first those of the loss itself, then
    /// those of everything that follows as well.
    pub(super) adjoint: Vec<[Row<T>; STATES]>,
    /// Room for what one network's units meet.
    pub(super) rows: Vec<[T; WIDE]>,
    /// Sums over samples and steps, in the order of the parameters.
    pub(super) sums: Vec<T>,
    /// The block's part of the loss.
    pub(super) loss: f64,
}

impl<T: Real> Block<T> {
    /// Steps of its sequences.
    pub(super) fn steps(&self) -> usize {
        self.signals.len() - 1
    }

    /// Takes up the sequences, at most [`BLOCK`], all of `steps` steps.
    pub(super) fn load(&mut self, sequences: &[Sequence<'_, T>], steps: usize) {
        self.used = sequences.len();
        self.signals.resize(steps + 1, [[T::ZERO; BLOCK]; SIGNALS]);
        for sample in 0..BLOCK {
            let sequence = &sequences[sample.min(self.used - 1)];
            for (state, value) in sequence.initial.iter().enumerate() {
                self.signals[0][state][sample] = *value;
            }
        }
        for (step, rows) in self.signals[..steps].iter_mut().enumerate() {
            let [insulin, carbs] = &mut rows[STATES..] else { unreachable!("two inputs") };
            for sample in 0..BLOCK {
                let inputs = &sequences[sample.min(self.used - 1)].inputs[step * INPUTS..];
                insulin[sample] = inputs[0];
                carbs[sample] = inputs[1];
            }
        }
    }

    /// Takes up the truth of the same sequences.
    pub(super) fn load_truth(&mut self, sequences: &[Sequence<'_, T>]) {
        self.truth.resize(self.steps(), [[T::ZERO; BLOCK]; STATES]);
        for (step, rows) in self.truth.iter_mut().enumerate() {
            for (sample, sequence) in sequences.iter().enumerate() {
                let truth = &sequence.truth[step * STATES..][..STATES];
                for (row, value) in rows.iter_mut().zip(truth) {
                    row[sample] = *value;
                }
            }
        }
    }

    /// Writes the states after each step, shape (samples, steps, 10).
    pub(super) fn store(&self, states: &mut [T]) {
        let steps = self.steps();
        for (sample, states) in states.chunks_exact_mut(steps * STATES).enumerate() {
            for (rows, states) in self.signals[1..].iter().zip(states.as_chunks_mut::<STATES>().0) {
                for (state, row) in states.iter_mut().zip(rows) {
                    *state = row[sample];
                }
            }
        }
    }
}
