//! Why a report cannot be written.

use crate::Part;

/// A part that cannot be used, or a figure that cannot be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A part is not the JSON that its file should hold.
    #[error(
        "{file}, line {line}, column {column}: {source}; write the file again with the command \
         that makes it",
        file = part.file_name(), line = source.line(), column = source.column()
    )]
    Json {
        /// Which part.
        part: Part,
        /// What the parser found, with its place.
        source: serde_json::Error,
    },
    /// Two series of a part that belong together have different lengths.
    #[error("{file}: '{series}' has {found} values where '{of}' has {expected}", file = part.file_name())]
    UnevenSeries {
        /// Which part.
        part: Part,
        /// The series that does not fit.
        series: &'static str,
        /// Its length.
        found: usize,
        /// The series that sets the length.
        of: &'static str,
        /// That length.
        expected: usize,
    },
    /// The drawing library refused a figure.
    #[error("figure '{figure}' cannot be drawn: {message}")]
    Figure {
        /// What the figure shows.
        figure: String,
        /// What the drawing library says.
        message: String,
    },
}
