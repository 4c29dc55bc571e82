//! Why a development set cannot be used.

use conformance::ConformanceError;
use nn_statespace::ModelError;
use ode_sim::OdeError;
use stats::StatsError;

/// A set that cannot be simulated, cut or scored.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DevelopmentError {
    /// The set itself, or a run of the ODE.
    #[error("the development set")]
    Set(#[from] OdeError),
    /// One week of it.
    #[error("week {week} of the development set")]
    Week {
        /// Which week, from 0.
        week: usize,
        /// Why.
        source: Box<DevelopmentError>,
    },
    /// Two subsets share a day of meals.
    #[error("meal day {day} lies in {one} (week {first}) and in {other} (week {second})")]
    Leak {
        /// Index of the day in the pool.
        day: usize,
        /// One subset.
        one: &'static str,
        /// Its week.
        first: usize,
        /// The other subset.
        other: &'static str,
        /// Its week.
        second: usize,
    },
    /// A network, its scaler or its windows.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A step of a network fails.
    #[error("a window of the development set")]
    Step(#[from] physiology::SimulationError),
    /// A change of a network's weights.
    #[error(transparent)]
    Change(#[from] ConformanceError),
    /// Outcomes or their test.
    #[error("outcomes of week {week:?}")]
    Outcomes {
        /// Of which week; of all together where there is none.
        week: Option<usize>,
        /// Why.
        source: StatsError,
    },
    /// The search refuses the trials.
    #[error("the search for widths: {0}")]
    Search(bayesopt::SearchError),
}
