//! A person's training windows, and how well an ODE plant meets them.

use cohort::{Person, Window};
use nn_statespace::{CentreAndScale, PopulationModel, Signal};
use ode_sim::OdePlant;
use physiology::{Compartment, Kilograms, OpenLoop, simulate};
use twins::{
    PersonWindows, ScaledLoss, TwinLoss, WindowStart, inputs_within, measured, window_starts,
};

use crate::error::OdeTwinError;

/// Windows on which plants are compared, all of one person.
#[derive(Debug, Clone)]
pub struct FitWindows<'a> {
    person: &'a Person,
    cut: &'a PersonWindows,
    windows: Vec<Window>,
    /// Measured glucose of each window, mg/dL, the start first.
    pub(crate) measured: Vec<Vec<f64>>,
    start: WindowStart,
    loss: ScaledLoss,
    /// Centre and scale of glucose in the loss, mg/dL.
    scaling: CentreAndScale,
}

impl<'a> FitWindows<'a> {
    /// The person's training windows, judged by the loss that trains twins of `population`.
    ///
    /// # Errors
    /// [`OdeTwinError::NoWindows`], and those of [`measured`].
    pub fn training(
        person: &'a Person,
        cut: &'a PersonWindows,
        start: WindowStart,
        loss: TwinLoss,
        population: &PopulationModel,
    ) -> Result<Self, OdeTwinError> {
        if cut.train.is_empty() {
            return Err(OdeTwinError::NoWindows);
        }
        let measured: Result<Vec<Vec<f64>>, _> =
            cut.train.iter().map(|window| measured(person, window)).collect();
        Ok(Self {
            person,
            cut,
            windows: cut.train.clone(),
            measured: measured?,
            start,
            loss: loss.scaled_by(population),
            scaling: population.scaler().of(Signal::State(Compartment::Q1)),
        })
    }

    /// The windows among these that share no step with an earlier one, then every `stride`th of
    /// them. What is measured in windows that overlap must not count twice as evidence.
    #[must_use]
    pub fn apart(&self, stride: usize) -> Self {
        let mut free_from = 0;
        let mut chosen = Vec::new();
        for (place, window) in self.windows.iter().enumerate() {
            if window.start >= free_from {
                free_from = window.start + window.len;
                chosen.push(place);
            }
        }
        let chosen: Vec<usize> = chosen.into_iter().step_by(stride.max(1)).collect();
        Self {
            windows: chosen.iter().map(|place| self.windows[*place]).collect(),
            measured: chosen.iter().map(|place| self.measured[*place].clone()).collect(),
            ..self.clone()
        }
    }

    /// The person's weight, or that of the simulator's average person.
    pub(crate) fn weight(&self) -> Kilograms {
        self.person.weight.unwrap_or(Kilograms(ode_sim::population::MEAN_WEIGHT))
    }

    /// Glucose of free runs of a plant through the windows, mg/dL, the start first; not confined to
    /// a sensor's range.
    ///
    /// # Errors
    /// Those of [`window_starts`], and of a state that leaves the finite numbers.
    pub fn simulated(&self, plant: &OdePlant) -> Result<Vec<Vec<f64>>, OdeTwinError> {
        let steps: Vec<usize> = self.windows.iter().map(|window| window.start).collect();
        let Self { person, cut, start, .. } = *self;
        let starts = window_starts(plant, person, &cut.inputs, &steps, start, cut.mean_basal)?;
        self.windows
            .iter()
            .zip(starts.states)
            .map(|(window, start)| {
                let inputs = inputs_within(&cut.inputs, window);
                let run = simulate(plant, start, &mut OpenLoop::new(inputs), inputs.len())
                    .map_err(twins::TwinError::from)?;
                Ok(run.glucose(plant).into_iter().map(|glucose| glucose.0).collect())
            })
            .collect()
    }

    /// Mean loss of a plant over the windows, the same that trains twins (paper, Eq. `costInd`).
    ///
    /// # Errors
    /// Those of [`Self::simulated`].
    pub fn loss(&self, plant: &OdePlant) -> Result<f64, OdeTwinError> {
        let scaled = |glucose: &[f64]| -> Vec<f64> {
            glucose.iter().map(|value| self.scaling.scale(*value)).collect()
        };
        let simulated = self.simulated(plant)?;
        let each = simulated.iter().zip(&self.measured);
        let sum: f64 = each.map(|(s, m)| self.loss.of(&scaled(s), &scaled(m))).sum();
        Ok(sum / self.windows.len() as f64)
    }
}
