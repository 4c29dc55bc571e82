//! Errors.

/// Why there is no posterior.
#[derive(Debug, thiserror::Error)]
pub enum PosteriorError {
    /// A file that is none of ours, or damaged.
    #[error("the posterior cannot be read: {0}")]
    File(String),
    /// A table that cannot be trained on.
    #[error("the table cannot be trained on: {0}")]
    Table(String),
    /// Tensor arithmetic failed.
    #[error("arithmetic of the posterior: {0}")]
    Tensor(#[from] candle_core::Error),
}
