//! Why a report cannot be written.

/// A part that cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A part does not match its schema.
    #[error(transparent)]
    Contract(#[from] contract::ContractError),
    /// A part cannot be read.
    #[error("{file} cannot be read: {source}")]
    Unreadable {
        /// Which file.
        file: &'static str,
        /// The system's reason.
        source: std::io::Error,
    },
}
