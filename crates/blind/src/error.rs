//! What can go wrong in this crate.

/// Errors of sealing and scoring.
#[derive(Debug, thiserror::Error)]
pub enum BlindError {
    /// A label is not the one that was sealed.
    #[error("world {id}: the label is not the one that was sealed; it was changed after the seal")]
    Tampered {
        /// The world.
        id: String,
    },
    /// A world was sealed and has no label, or the reverse.
    #[error("world {id}: {problem}")]
    Unmatched {
        /// The world.
        id: String,
        /// What is missing.
        problem: &'static str,
    },
    /// A statistic could not be formed.
    #[error(transparent)]
    Stats(#[from] stats::StatsError),
    /// A statistic of the realism table is not a number.
    #[error("realism: {statistic}: {source}")]
    Statistic {
        /// Its name.
        statistic: String,
        /// What is wrong.
        source: stats::StatsError,
    },
    /// There is no real person to compare with.
    #[error("realism: no real person has a statistic; give a cohort of people's records")]
    NobodyReal,
}
