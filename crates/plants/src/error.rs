//! Why a plant cannot be used.

use nn_statespace::Signal;
use physiology::Compartment;

/// A network that cannot stand in the filter, or a step that fails.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlantsError {
    /// A network sees more than its equation does.
    #[error(
        "network {compartment} of the model sees {signal}; a diagnosis needs the paper's wiring, in which every \
         network sees what its equation does"
    )]
    Wiring {
        /// Whose network.
        compartment: Compartment,
        /// What it sees.
        signal: Signal,
    },
    /// A window, a start or a training that cannot be.
    #[error(transparent)]
    Twin(#[from] twins::TwinError),
    /// Outcomes or errors of a window.
    #[error(transparent)]
    Stats(#[from] stats::StatsError),
    /// A step of a window under an effect fails.
    #[error("a window under the effect")]
    Window(#[from] physiology::SimulationError),
}
