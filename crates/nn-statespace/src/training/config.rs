//! Every choice that training depends on, as presets without a default.

use serde::{Deserialize, Serialize};

use super::loss::LossConfig;
use super::slope_constraints::{ProductPenalty, SlopeRule};
use crate::population::GlucoseClamp;

/// Resolved configuration of a training run; written beside the weights.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrainingConfig {
    /// Consecutive parts of the run. The optimiser's moments carry over.
    pub stages: Vec<Stage>,
    /// Windows in a batch; the last batch of an epoch takes what is left.
    pub batch: usize,
    /// Weights of the loss.
    pub loss: LossConfig,
    /// Whether a batch's gradient is limited.
    pub gradient_limit: GradientLimit,
    /// Factor on the initial weights of the output layers. 1 is PyTorch's initialisation; smaller
    /// values keep the first roll-outs from running away.
    pub initial_output_gain: f64,
    /// Whether Q1 is confined after each step of the roll-out, in training and in the model.
    pub clamp: GlucoseClamp,
    /// Whether slopes keep the signs of physiology.
    pub slopes: SlopeRule,
    /// Which epoch's weights are kept.
    pub keep: KeptWeights,
    /// When a stage ends before its last epoch.
    pub stop: EarlyStop,
    /// Seed of initial weights and shuffling.
    pub seed: u64,
}

/// A part of a training run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Stage {
    /// Passes over the training windows.
    pub epochs: usize,
    /// Steps of each window that are rolled out, from its start; at most the window's length.
    pub steps: usize,
    /// Learning rate of Adam.
    pub learning_rate: LearningRate,
}

impl Stage {
    fn new(epochs: usize, steps: usize, first: f64, decay: f64) -> Self {
        Self { epochs, steps, learning_rate: LearningRate { first, decay } }
    }
}

/// Learning rate of a stage, held within an epoch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LearningRate {
    /// In the stage's first epoch.
    pub first: f64,
    /// Each epoch's rate is that of the one before times `exp(-decay)`.
    pub decay: f64,
}

impl LearningRate {
    /// The rate in the stage's epoch `epoch`, counted from 0.
    #[must_use]
    pub fn at(&self, epoch: usize) -> f64 {
        self.first * (-self.decay * epoch as f64).exp()
    }
}

/// Whether the gradient of a batch is scaled down before it is used.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GradientLimit {
    /// Used as it is (paper).
    Off,
    /// Scaled down to this Euclidean norm over all parameters where it is longer.
    Norm(f64),
}

/// Which weights a run returns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum KeptWeights {
    /// Those of the last epoch, as the name of the published file suggests.
    LastEpoch,
    /// Those of the epoch with the lowest balanced error on the validation windows; one whose slopes do not have the signs
    /// that are to be kept counts as a quarter worse.
    LowestValidationError,
}

/// When a stage ends before its last epoch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EarlyStop {
    /// Never (paper).
    Off,
    /// After so many epochs of the stage without a lower balanced error on the validation windows.
    Patience(usize),
}

impl EarlyStop {
    /// Whether a stage with these balanced errors so far, one an epoch, ends here.
    ///
    /// An error that is not a number is never the lowest.
    #[must_use]
    pub fn ends(self, errors: &[f64]) -> bool {
        let Self::Patience(patience) = self else { return false };
        let mut best = (0, f64::INFINITY);
        for (epoch, error) in errors.iter().enumerate() {
            if *error < best.1 {
                best = (epoch + 1, *error);
            }
        }
        errors.len() - best.0 >= patience.max(1)
    }
}

impl TrainingConfig {
    /// The paper's settings: batch 128, 60 steps, learning rate 1e-3 falling by exp(-0.1) an
    /// epoch, 15 epochs (from the name of the published file), Adam without weight decay.
    ///
    /// Of initial weights the paper says nothing. With PyTorch's, roll-outs of this length leave the
    /// range of single precision; the output layers therefore begin at a tenth of them.
    #[must_use]
    pub fn paper(seed: u64) -> Self {
        Self {
            stages: vec![Stage::new(15, 60, 1e-3, 0.1)],
            batch: 128,
            loss: LossConfig::paper(),
            gradient_limit: GradientLimit::Off,
            initial_output_gain: 0.1,
            clamp: GlucoseClamp::Off,
            slopes: SlopeRule::Free,
            keep: KeptWeights::LastEpoch,
            stop: EarlyStop::Off,
            seed,
        }
    }

    /// The paper's settings as the authors' published code carries them out: Q1 is confined to
    /// [`crate::GLUCOSE_RANGE`] after every step, of which the paper says nothing.
    #[must_use]
    pub fn authors_code(seed: u64) -> Self {
        Self { clamp: GlucoseClamp::Reproduction, ..Self::paper(seed) }
    }

    /// As [`unconstrained`](Self::unconstrained), with slopes kept as physiology has them.
    #[must_use]
    pub fn working(seed: u64) -> Self {
        Self { slopes: SlopeRule::Kept(ProductPenalty::working()), ..Self::unconstrained(seed) }
    }

    /// The paper's settings with each batch's gradient limited, the first two epochs on short
    /// roll-outs, a lower learning rate that falls faster, and the best epoch's weights kept.
    ///
    /// Without a limit single batches, whose roll-outs run away, throw the weights off in any epoch;
    /// without short ones first, they do so in the first epochs and some seeds do not recover.
    #[must_use]
    pub fn unconstrained(seed: u64) -> Self {
        Self {
            stages: vec![
                Stage::new(1, 6, 1e-3, 0.0),
                Stage::new(1, 20, 1e-3, 0.0),
                Stage::new(13, 60, 5e-4, 0.2),
            ],
            gradient_limit: GradientLimit::Norm(1.0),
            keep: KeptWeights::LowestValidationError,
            ..Self::paper(seed)
        }
    }

    /// As [`working`](Self::working), for a few thousand windows and seconds: short roll-outs first,
    /// which find the rates cheaply, then the paper's full length at falling learning rates.
    #[must_use]
    pub fn quick(seed: u64) -> Self {
        let stages = vec![Stage::new(10, 6, 1e-2, 0.05), Stage::new(80, 60, 5e-3, 0.06)];
        Self { stages, ..Self::working(seed) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_ends_when_its_patience_does() {
        let cases: [(&[f64], usize, bool); 9] = [
            (&[], 1, false),
            (&[5.0], 1, false),
            (&[5.0, 4.0], 1, false),
            (&[5.0, 4.0, 4.0], 1, true), // not lower
            (&[5.0, 4.0, 4.5], 2, false),
            (&[5.0, 4.0, 4.5, 4.1], 2, true),
            (&[5.0, 6.0, 4.0], 2, false),
            (&[f64::NAN, f64::NAN], 2, true),
            (&[f64::NAN, 3.0, f64::NAN], 2, false),
        ];
        for (errors, patience, ends) in cases {
            assert_eq!(EarlyStop::Patience(patience).ends(errors), ends, "{errors:?} {patience}");
            assert!(!EarlyStop::Off.ends(errors));
        }
    }
}
