//! The balanced simulation error on validation windows (paper, Eq. for L_BayesOpt).

use physiology::Compartment;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::windows::STATES;
use crate::error::ModelError;
use crate::kernel::{FusedRollOut, Sequence};
use crate::signal::Signal;
use crate::training_set::WindowSet;

/// Windows rolled out together: work for eight threads in a few megabytes.
const BATCH: usize = 256;

/// The paper's three groups of sequences, by the true glucose after the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WindowGroup {
    /// More than 70 % within 70 to 180 mg/dL and less than 20 % below 70.
    InRange,
    /// More than 20 % below 70 mg/dL.
    Low,
    /// Everything else.
    Other,
}

impl WindowGroup {
    /// The group of a sequence of glucose values, mg/dL.
    #[must_use]
    pub fn of(glucose: &[f64]) -> Self {
        let share = |keep: &dyn Fn(f64) -> bool| {
            glucose.iter().filter(|g| keep(**g)).count() as f64 / glucose.len() as f64
        };
        let below = share(&|g| g < 70.0);
        if below > 0.2 {
            Self::Low
        } else if share(&|g| (70.0..=180.0).contains(&g)) > 0.7 && below < 0.2 {
            Self::InRange
        } else {
            Self::Other
        }
    }
}

/// Error of simulated glucose in each of the paper's groups.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GroupErrors {
    /// Root mean square error over all samples of the group's windows but their starts, mg/dL, in
    /// the order in range, low, other; `None` where the group is empty.
    pub rmse_mg_dl: [Option<f64>; 3],
    /// Windows in each group.
    pub windows: [usize; 3],
}

impl GroupErrors {
    /// The mean of the groups' errors, mg/dL: the paper's balanced error, over the groups that
    /// have windows.
    #[must_use]
    pub fn balanced(&self) -> f64 {
        let present: Vec<f64> = self.rmse_mg_dl.iter().flatten().copied().collect();
        present.iter().sum::<f64>() / present.len() as f64
    }
}

/// Rolls out every window from its start with these weights and compares glucose by group.
///
/// # Errors
/// [`ModelError::Shape`] or [`ModelError::NotFinite`] if the weights are not those of `roll_out`'s
/// networks.
pub fn validate(
    roll_out: &mut FusedRollOut<f32>,
    parameters: &[f32],
    windows: &WindowSet,
) -> Result<GroupErrors, ModelError> {
    let glucose = windows.scaler().of(Signal::State(Compartment::Q1));
    let glucose_of = |rows: &[f32]| -> Vec<f64> {
        let rows = rows.chunks_exact(STATES);
        rows.map(|row| f64::from(row[Compartment::Q1 as usize])).collect()
    };
    let order: Vec<usize> = (0..windows.len()).collect();
    let mut squares = [0.0; 3];
    let mut counts = [0_usize; 3];
    for batch in order.chunks(BATCH) {
        let sequences: Vec<Sequence<'_, f32>> =
            batch.iter().map(|window| windows.sequence(*window, windows.length())).collect();
        let simulated = roll_out.simulate(parameters, &sequences)?;
        let judged: Vec<(WindowGroup, f64)> = sequences
            .par_iter()
            .zip(simulated.par_chunks_exact(windows.length() * STATES))
            .map(|(sequence, simulated)| {
                let (simulated, truth) = (glucose_of(simulated), glucose_of(sequence.truth));
                let error = simulated.iter().zip(&truth).map(|(s, t)| (s - t) * (s - t)).sum();
                let physical: Vec<f64> = truth.iter().map(|t| glucose.unscale(*t)).collect();
                (WindowGroup::of(&physical), error)
            })
            .collect();
        for (group, error) in judged {
            squares[group as usize] += error;
            counts[group as usize] += 1;
        }
    }
    let rmse = std::array::from_fn(|group| {
        let samples = counts[group] * windows.length();
        (samples > 0).then(|| glucose.scale * (squares[group] / samples as f64).sqrt())
    });
    Ok(GroupErrors { rmse_mg_dl: rmse, windows: counts })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_the_papers() {
        let cases = [
            (vec![100.0; 60], WindowGroup::InRange),
            ([vec![69.9; 13], vec![100.0; 47]].concat(), WindowGroup::Low), // 21.7 % low
            ([vec![69.9; 12], vec![100.0; 48]].concat(), WindowGroup::Other), // 20 % exactly
            ([vec![69.9; 11], vec![180.0; 49]].concat(), WindowGroup::InRange),
            ([vec![180.1; 18], vec![70.0; 42]].concat(), WindowGroup::Other), // 70 % exactly
        ];
        for (glucose, group) in cases {
            assert_eq!(WindowGroup::of(&glucose), group);
        }
    }

    #[test]
    fn the_balanced_error_is_the_mean_over_groups_that_exist() {
        let errors = GroupErrors { rmse_mg_dl: [Some(10.0), None, Some(20.0)], windows: [3, 0, 1] };
        assert_eq!(errors.balanced(), 15.0);
    }
}
