//! Why a report cannot be written.

/// A part that cannot be used, or a figure that cannot be drawn.
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
    /// The drawing library refused a figure.
    #[error("figure '{figure}' cannot be drawn: {message}")]
    Figure {
        /// What the figure shows.
        figure: String,
        /// The drawing library's reason.
        message: String,
    },
}
