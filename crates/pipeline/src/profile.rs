//! How much a stage computes.

use nn_statespace::training::TrainingConfig;
use ode_sim::DevelopmentPlan;

/// How much to compute.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Profile {
    /// Minutes on two cores.
    Quick,
    /// The paper's widths, schedules and simulated days; hours, of which `train` takes a quarter of one.
    Paper,
}

impl Profile {
    /// The development set.
    pub(crate) fn plan(self, seed: u64) -> DevelopmentPlan {
        match self {
            Self::Quick => DevelopmentPlan::quick(seed),
            Self::Paper => DevelopmentPlan::paper(seed),
        }
    }

    /// How a population network is trained.
    pub(crate) fn training(self, seed: u64) -> TrainingConfig {
        match self {
            Self::Quick => TrainingConfig::quick(seed),
            Self::Paper => TrainingConfig::working(seed),
        }
    }
}
