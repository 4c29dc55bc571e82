//! Why a file cannot be read.

/// A file that does not hold what its schema says.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ContractError {
    /// Written by another version, or another file under this name.
    #[error(
        "{file}: its schema is '{found}', this version reads '{expected}'; write the file again with the \
         command that makes it"
    )]
    Schema {
        /// Which file.
        file: &'static str,
        /// What it states.
        found: String,
        /// What was expected.
        expected: &'static str,
    },
    /// No JSON, or a key that is missing, unknown or of another type.
    #[error(
        "{file}, line {line}, column {column}: {problem}; write the file again with the command that makes it",
        line = source.line(), column = source.column(), problem = without_place(source)
    )]
    Json {
        /// Which file.
        file: &'static str,
        /// What the parser found, with its place.
        source: serde_json::Error,
    },
    /// Two series that belong together have different lengths.
    #[error("{file}: '{series}' has {found} values where '{of}' has {expected}")]
    UnevenSeries {
        /// Which file.
        file: &'static str,
        /// The series that does not fit.
        series: &'static str,
        /// Its length.
        found: usize,
        /// The series that sets the length.
        of: &'static str,
        /// That length.
        expected: usize,
    },
}

/// What the parser says, without the place that it says at the end.
fn without_place(source: &serde_json::Error) -> String {
    let said = source.to_string();
    said.rsplit_once(" at line ").map_or(said.clone(), |(problem, _)| problem.to_owned())
}
