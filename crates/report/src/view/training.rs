//! `training.json`: how the population network was trained.
//!
//! ```json
//! {"schema": "training/1", "model": "population", "seed": 1,
//!  "epochs": [{"epoch": 1, "train_loss": 0.9, "validation_loss": 1.0, "learning_rate": 0.001}],
//!  "data": {"windows_train": 9000, "windows_validation": 1000, "hash": "..."},
//!  "seconds": 41.2}
//! ```

use serde::Deserialize;

/// One training run.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Training {
    /// What was trained.
    pub model: String,
    /// The seed.
    pub seed: u64,
    /// One entry an epoch, in order.
    pub epochs: Vec<Epoch>,
    /// The data.
    pub data: TrainingData,
    /// Time taken, s.
    #[serde(default)]
    pub seconds: Option<f64>,
}

/// One pass through the training data.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Epoch {
    /// Number of the epoch.
    pub epoch: u32,
    /// Loss on the training windows.
    pub train_loss: f64,
    /// Loss on the validation windows, where it was computed.
    #[serde(default)]
    pub validation_loss: Option<f64>,
    /// Learning rate.
    #[serde(default)]
    pub learning_rate: Option<f64>,
}

/// The data of a training run.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct TrainingData {
    /// Windows used for training.
    pub windows_train: usize,
    /// Windows used for validation.
    pub windows_validation: usize,
    /// Hash of the data.
    pub hash: String,
}
