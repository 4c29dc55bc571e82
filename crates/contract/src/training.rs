//! `training.json`: how the population network was trained.

/// One training run.
#[apply(strict!)]
pub struct Training {
    /// The settings.
    pub config: serde_json::Value,
    /// The data.
    pub data: TrainingData,
    /// One entry an epoch, in order.
    pub epochs: Vec<Epoch>,
    /// The epoch whose weights are kept, counted from 0.
    pub kept_epoch: usize,
    /// What was trained, by the file of its weights.
    pub model: String,
    /// `training/1`.
    pub schema: String,
    /// Time taken, s.
    pub seconds: f64,
    /// The seed.
    pub seed: u64,
    /// What `validation_loss` is, in words.
    pub validation_loss_is: String,
}

/// One pass through the training data.
#[apply(strict!)]
pub struct Epoch {
    /// Number of the epoch, counted from 0 over the whole run.
    pub epoch: usize,
    /// Learning rate.
    pub learning_rate: f64,
    /// Steps of a window that are rolled out.
    pub steps: usize,
    /// Loss on the training windows, scaled units.
    pub train_loss: f64,
    /// Balanced error on the validation windows, mg/dL.
    pub validation_loss: f64,
    /// Error on the validation windows in range, low and other, mg/dL; `None` for a group without windows.
    pub validation_rmse_by_group_mg_dl: [Option<f64>; 3],
}

/// The data of a training run.
#[apply(strict!)]
#[derive(Eq)]
pub struct TrainingData {
    /// SHA-256 of the windows, hexadecimal.
    pub hash: String,
    /// Days that were simulated.
    pub simulated_days: usize,
    /// Windows used for training.
    pub windows_train: usize,
    /// Windows used for validation.
    pub windows_validation: usize,
}
