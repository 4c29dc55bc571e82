//! What can go wrong in this crate.

/// Errors of a search.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SearchError {
    /// A range is empty or not finite.
    #[error("the range from {low} to {high} holds no numbers; its ends must be finite and rise")]
    Range {
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// There is nothing to model.
    #[error("a proposal needs an evaluated point; begin with those of a Latin hypercube")]
    Nothing,
    /// A point or its value is not finite, or the point has another number of coordinates.
    #[error(
        "evaluation {index}: {coordinates} coordinates with the value {value}; every evaluation \
         needs {needed} finite coordinates and a finite value"
    )]
    Evaluation {
        /// Which evaluation, from 0.
        index: usize,
        /// Its coordinates.
        coordinates: usize,
        /// Coordinates of the search.
        needed: usize,
        /// Its value.
        value: f64,
    },
}
