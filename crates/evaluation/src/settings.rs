//! How methods are judged, and what each person is compared with.

use ode_sim::{OdeParameters, OdePlant};
use physiology::Kilograms;
use stats::Bootstrap;
use twins::Protocol;

/// How methods are judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EvaluationSettings {
    /// How records are cut; the same as in training.
    pub protocol: Protocol,
    /// Level of each one-sided test.
    pub alpha: f64,
    /// Resampling of people for intervals.
    pub bootstrap: Bootstrap,
}

impl EvaluationSettings {
    /// Level 0.05 as in the paper; intervals of level 0.90, which belong to such tests, from 2,000
    /// bootstrap samples of people.
    #[must_use]
    pub const fn paper(protocol: Protocol, seed: u64) -> Self {
        Self { protocol, alpha: 0.05, bootstrap: Bootstrap { replicates: 2000, level: 0.9, seed } }
    }
}

/// The ODE baseline for a person: population parameters, the person's weight or, where it is
/// unknown, that of the simulator's average person (Resalat et al. 2019), integrated as the authors
/// do.
#[must_use]
pub fn ode_baseline(weight: Option<Kilograms>) -> OdePlant {
    let average = Kilograms(ode_sim::population::MEAN_WEIGHT);
    OdePlant::reproduction(OdeParameters::nominal(), weight.unwrap_or(average))
}
