//! Training and validation windows over simulated runs.

use std::io::Write;

use physiology::{Compartment, States, StepInput};

use crate::error::ModelError;
use crate::kernel::Sequence;
use crate::per_compartment::PerCompartment;
use crate::scaler::{CentreAndScale, Scaler};
use crate::wiring::Signal;

/// States a row holds.
pub(crate) const STATES: usize = 10;
/// Inputs a row holds: insulin, carbohydrate.
pub(crate) const INPUTS: usize = 2;

/// One simulated run in physical units: `states[k + 1]` follows `states[k]` under `inputs[k]`.
#[derive(Debug, Clone, Copy)]
pub struct Run<'a> {
    /// One more than there are inputs.
    pub states: &'a [States],
    /// What acted during each step.
    pub inputs: &'a [StepInput],
}

/// The value of the latent compartment C1 at the start of a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CarbStart {
    /// What the run reports, so that a window may start during a meal. C1 still has no error term.
    Reported,
    /// Nothing, as where the source knows no such compartment.
    Zero,
}

impl Scaler {
    /// Fits the scaler to training runs: median and interquartile range of every state over all
    /// rows and of both inputs over all steps; C1, which has no ground truth, keeps centre 0 and
    /// scale 1 (paper, appendix on the robust scaler).
    ///
    /// # Errors
    /// [`ModelError::NoRows`] without rows, [`ModelError::NotFinite`] with the signal at fault.
    pub fn fit(runs: &[Run<'_>]) -> Result<Self, ModelError> {
        let states = PerCompartment::try_from_fn(|compartment| {
            if compartment == Compartment::C1 {
                return Ok(CentreAndScale { centre: 0.0, scale: 1.0 });
            }
            let values = runs.iter().flat_map(|run| run.states.iter().map(|x| x[compartment]));
            CentreAndScale::robust(Signal::State(compartment), values.collect())
        })?;
        let insulin = runs.iter().flat_map(|run| run.inputs.iter().map(|u| u.insulin().0));
        let carbs =
            runs.iter().flat_map(|run| run.inputs.iter().map(|u| (u.carbs + u.rescue.amount).0));
        Self::new(
            states,
            CentreAndScale::robust(Signal::Insulin, insulin.collect())?,
            CentreAndScale::robust(Signal::Carbs, carbs.collect())?,
        )
    }
}

/// Windows of equal length over scaled runs. Rows are shared by overlapping windows.
#[derive(Debug, Clone)]
pub struct WindowSet {
    scaler: Scaler,
    length: usize,
    /// Row-major, shape (rows, 10) in the order of [`Compartment::ALL`], scaled.
    states: Vec<f32>,
    /// Row-major, shape (rows, 2): insulin and carbohydrate of the step that starts at the row.
    inputs: Vec<f32>,
    /// First row of each window.
    starts: Vec<usize>,
    /// Lowest scaled value of each state over all rows; 0 for C1.
    minima: PerCompartment<f64>,
}

impl WindowSet {
    /// Cuts `runs` into windows of `length` steps that start `stride` steps apart; a run's tail
    /// that does not fill a window is not used. The paper takes 60 steps, 15 apart for training
    /// (75 % overlap) and 60 apart for validation.
    ///
    /// # Errors
    /// [`ModelError::Windows`] if `length` or `stride` is 0, a run's lengths do not fit together
    /// or no run holds a window; [`ModelError::NotFinite`] if a value is not a finite number.
    pub fn new(
        scaler: &Scaler,
        runs: &[Run<'_>],
        length: usize,
        stride: usize,
        carb_start: CarbStart,
    ) -> Result<Self, ModelError> {
        let problem = |run, problem| ModelError::Windows { run, problem };
        if length == 0 || stride == 0 {
            return Err(problem(0, "length and stride must be at least one step"));
        }
        let mut set = Self {
            scaler: *scaler,
            length,
            states: Vec::new(),
            inputs: Vec::new(),
            starts: Vec::new(),
            minima: PerCompartment::from_fn(|_| f64::INFINITY),
        };
        for (index, run) in runs.iter().enumerate() {
            if run.states.len() != run.inputs.len() + 1 {
                return Err(problem(index, "there must be one more state than inputs"));
            }
            let offset = set.states.len() / STATES;
            for (step, states) in run.states.iter().enumerate() {
                let scaled = scaler.scale(states);
                for (compartment, value) in scaled.iter() {
                    let value = match (compartment, carb_start) {
                        (Compartment::C1, CarbStart::Zero) => 0.0,
                        _ => value,
                    };
                    if !value.is_finite() {
                        let tensor = format!("run {index}, {compartment}");
                        return Err(ModelError::NotFinite { tensor, index: step });
                    }
                    set.minima[compartment] = set.minima[compartment].min(value);
                    set.states.push(value as f32);
                }
                // The row after the last step has no input; it is never read.
                let input = run.inputs.get(step).copied().unwrap_or_default();
                let scaled = scaler.scale_input(&input);
                for (signal, value) in
                    [(Signal::Insulin, scaled.insulin), (Signal::Carbs, scaled.carbs)]
                {
                    if !value.is_finite() {
                        let tensor = format!("run {index}, {signal}");
                        return Err(ModelError::NotFinite { tensor, index: step });
                    }
                    set.inputs.push(value as f32);
                }
            }
            if let Some(last) = run.inputs.len().checked_sub(length) {
                set.starts.extend((0..=last).step_by(stride).map(|start| offset + start));
            }
        }
        if set.starts.is_empty() {
            return Err(problem(runs.len(), "no run is as long as a window"));
        }
        set.minima[Compartment::C1] = 0.0;
        Ok(set)
    }

    /// Number of windows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.starts.len()
    }

    /// Whether there are no windows; never true, since none cannot be built.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.starts.is_empty()
    }

    /// Steps in a window.
    #[must_use]
    pub fn length(&self) -> usize {
        self.length
    }

    /// The scaler of the rows.
    #[must_use]
    pub fn scaler(&self) -> &Scaler {
        &self.scaler
    }

    /// The lowest scaled value of each state over all rows, and 0 for C1: min(x^i) of the paper.
    #[must_use]
    pub fn minima(&self) -> &PerCompartment<f64> {
        &self.minima
    }

    /// The scaled states of a window, row-major, shape (length + 1, 10), time along the rows.
    ///
    /// # Panics
    /// If there is no such window.
    #[must_use]
    pub fn states(&self, window: usize) -> &[f32] {
        let start = self.starts[window];
        &self.states[start * STATES..(start + self.length + 1) * STATES]
    }

    /// The scaled inputs of a window, row-major, shape (length, 2), time along the rows.
    ///
    /// # Panics
    /// If there is no such window.
    #[must_use]
    pub fn inputs(&self, window: usize) -> &[f32] {
        let start = self.starts[window];
        &self.inputs[start * INPUTS..(start + self.length) * INPUTS]
    }

    /// The first `steps` steps of a window, with the states that should follow each.
    ///
    /// # Panics
    /// If there is no such window or it has fewer steps.
    #[must_use]
    pub fn sequence(&self, window: usize, steps: usize) -> Sequence<'_, f32> {
        let (initial, truth) = self.states(window).split_at(STATES);
        let truth = &truth[..steps * STATES];
        Sequence { initial, inputs: &self.inputs(window)[..steps * INPUTS], truth }
    }

    /// Writes everything that training sees, little-endian, so that a hash of it names the data.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write_canonical(&self, mut writer: impl Write) -> std::io::Result<()> {
        for start in &self.starts {
            writer.write_all(&(*start as u64).to_le_bytes())?;
        }
        writer.write_all(&(self.length as u64).to_le_bytes())?;
        for value in self.states.iter().chain(&self.inputs) {
            writer.write_all(&value.to_le_bytes())?;
        }
        Ok(())
    }
}
