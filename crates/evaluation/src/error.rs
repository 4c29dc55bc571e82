//! What can go wrong in an evaluation.

/// Why people could not be judged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EvaluationError {
    /// A window, a start or a simulation that cannot be.
    #[error(transparent)]
    Twin(#[from] twins::TwinError),
    /// The same, of one person.
    #[error("person '{person}': {source}")]
    Person {
        /// The person's identifier.
        person: String,
        /// What went wrong.
        source: Box<EvaluationError>,
    },
    /// A steady state that cannot be found.
    #[error(transparent)]
    Model(#[from] nn_statespace::ModelError),
    /// Windows that cannot be cut.
    #[error(transparent)]
    Cohort(#[from] cohort::CohortError),
    /// A simulation left the finite numbers.
    #[error(transparent)]
    Simulation(#[from] physiology::SimulationError),
    /// A statistic that cannot be computed.
    #[error(transparent)]
    Stats(#[from] stats::StatsError),
    /// Tests and intervals over people need at least two.
    #[error("people to judge: {found}; left out: {excluded}; at least 2 are needed")]
    TooFewPeople {
        /// People judged.
        found: usize,
        /// People left out.
        excluded: usize,
    },
    /// Somebody who was judged on another cohort.
    #[error("person '{0}' was judged but is not in the cohort")]
    NotInCohort(String),
    /// A method without a model in one person and with one in another.
    #[error("person '{person}' has no model '{method}' although others have; fit everybody alike")]
    MissingModel {
        /// The person.
        person: String,
        /// The method.
        method: &'static str,
    },
}

impl EvaluationError {
    pub(crate) fn of_person(self, person: &str) -> Self {
        match self {
            Self::Person { .. } | Self::MissingModel { .. } => self,
            other => Self::Person { person: person.to_owned(), source: Box::new(other) },
        }
    }
}
