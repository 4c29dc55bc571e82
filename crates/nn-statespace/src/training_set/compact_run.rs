//! A simulated run in single precision.

use std::io::Write;

use crate::error::ModelError;
use crate::signal::Signal;
use crate::training::Run;
use crate::training::windows::{INPUTS, STATES};

/// A simulated run in physical units, rounded to single precision: the ten states of
/// [`physiology::States`], insulin in U/h (basal and bolus together) and the carbohydrate of a
/// step in g.
#[derive(Debug, Clone, PartialEq)]
pub struct CompactRun {
    /// Row-major, shape (steps + 1, 10) in the order of [`physiology::Compartment::ALL`].
    pub(super) states: Box<[f32]>,
    /// Row-major, shape (steps, 2): insulin and carbohydrate.
    pub(super) inputs: Box<[f32]>,
}

impl CompactRun {
    /// Rounds a run. The relative error of a value is at most 2^-24.
    ///
    /// # Errors
    /// [`ModelError::Windows`] unless there is one more state than inputs;
    /// [`ModelError::NotFinite`] with the signal and the step if a value is not a finite number of
    /// single precision.
    pub fn new(run: Run<'_>) -> Result<Self, ModelError> {
        let compact = Self::rounded(run.rows(0)?);
        for signal in Signal::all() {
            if let Some(index) = compact.values(signal).position(|value| !value.is_finite()) {
                return Err(ModelError::NotFinite { tensor: signal.name().to_owned(), index });
            }
        }
        Ok(compact)
    }

    /// These states and inputs in single precision.
    pub(super) fn rounded((states, inputs): (Vec<f64>, Vec<f64>)) -> Self {
        let single = |values: Vec<f64>| values.into_iter().map(|value| value as f32).collect();
        Self { states: single(states), inputs: single(inputs) }
    }

    /// Steps of the run; it has one more state.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.inputs.len() / INPUTS
    }

    /// The values of a signal by step: one more for a state than for an input.
    pub fn values(&self, signal: Signal) -> impl Iterator<Item = f32> + '_ {
        let (rows, first, width) = match signal.row().checked_sub(STATES) {
            None => (&self.states, signal.row(), STATES),
            Some(input) => (&self.inputs, input, INPUTS),
        };
        rows.iter().skip(first).step_by(width).copied()
    }

    /// Writes the run, little-endian, states before inputs, so that a hash of it names the data.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write_canonical(&self, mut writer: impl Write) -> std::io::Result<()> {
        writer.write_all(&(self.steps() as u64).to_le_bytes())?;
        self.write_values(writer)
    }

    /// Writes what [`Self::write_canonical`] does without the number of steps.
    pub(super) fn write_values(&self, mut writer: impl Write) -> std::io::Result<()> {
        let values = self.states.iter().chain(&self.inputs);
        writer.write_all(&values.flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>())
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use physiology::{Compartment, FastCarbs, Grams, States, StepInput, Units, UnitsPerHour};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha12Rng;

    /// A run whose values are all of single precision, with ties, zeros and both signs.
    pub(in crate::training_set) fn example(
        seed: u64,
        steps: usize,
    ) -> (Vec<States>, Vec<StepInput>) {
        let mut rng = ChaCha12Rng::seed_from_u64(seed);
        let mut states = vec![States::default(); steps + 1];
        for (k, compartment) in Compartment::ALL.into_iter().enumerate() {
            let size = 10_f64.powi(k as i32 - 5);
            for row in &mut states {
                let z: f64 = rng.random_range(-1.0..1.0);
                // Coarse for one state, so that many values are equal.
                let z = if k == 3 { (4.0 * z).round() } else { z };
                row[compartment] = f64::from((size * z) as f32);
            }
        }
        let inputs = (0..steps)
            .map(|k| StepInput {
                basal: UnitsPerHour(1.25),
                bolus: Units(if k % 7 == 0 { 0.5 } else { 0.0 }),
                carbs: Grams(if k % 5 == 0 { 30.0 } else { 0.0 }),
                rescue: FastCarbs { amount: Grams(8.0), ..FastCarbs::default() },
                ..StepInput::default()
            })
            .collect();
        (states, inputs)
    }

    #[test]
    fn a_run_keeps_its_values_by_signal() {
        let (states, inputs) = example(1, 20);
        let run = CompactRun::new(Run { states: &states, inputs: &inputs }).expect("finite");
        assert_eq!(run.steps(), 20);
        for compartment in Compartment::ALL {
            let values: Vec<f64> = run.values(Signal::State(compartment)).map(f64::from).collect();
            let given: Vec<f64> = states.iter().map(|x| x[compartment]).collect();
            assert_eq!(values, given, "{compartment}");
        }
        let insulin: Vec<f32> = run.values(Signal::Insulin).collect();
        assert_eq!((insulin.len(), insulin[0], insulin[1]), (20, 7.25, 1.25));
        let carbs: Vec<f32> = run.values(Signal::Carbs).collect();
        assert_eq!(carbs[4..6], [8.0, 38.0], "fast carbohydrate is carbohydrate");
    }

    #[test]
    fn canonical_bytes_tell_runs_apart() {
        let bytes = |seed, steps| {
            let (states, inputs) = example(seed, steps);
            let mut bytes = Vec::new();
            let run = CompactRun::new(Run { states: &states, inputs: &inputs }).expect("finite");
            run.write_canonical(&mut bytes).expect("a vector takes all");
            bytes
        };
        assert_eq!(bytes(1, 20).len(), 8 + 4 * (21 * 10 + 20 * 2));
        assert_eq!(bytes(1, 20), bytes(1, 20));
        assert_ne!(bytes(1, 20), bytes(2, 20));
    }

    #[test]
    fn what_is_no_run_is_refused() {
        let (mut states, inputs) = example(1, 20);
        assert!(CompactRun::new(Run { states: &states[1..], inputs: &inputs }).is_err());
        // Finite, but not in single precision.
        states[7][Compartment::X2] = 1e300;
        let error = CompactRun::new(Run { states: &states, inputs: &inputs }).expect_err("too big");
        assert!(matches!(error, ModelError::NotFinite { index: 7, .. }), "{error}");
        assert!(error.to_string().contains("X2"), "{error}");
    }
}
