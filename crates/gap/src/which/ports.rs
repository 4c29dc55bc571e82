//! Evidence by place in the equations.

use effects::Port;

use super::statistics::{RANDOM, RandomFactor};
use super::variance::Estimated;

/// Evidence that something varies at a port beyond what is estimated elsewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PortGain {
    pub(crate) port: Port,
    /// Nats.
    pub(crate) gain: f64,
    /// Whether it varies from block to block rather than from day to day.
    pub(crate) within_days: bool,
}

/// Evidence of both scales at every port that has a random factor.
pub(super) fn gains(estimated: &Estimated) -> Vec<PortGain> {
    RANDOM
        .into_iter()
        .enumerate()
        .flat_map(|(factor, RandomFactor { port, .. })| {
            [(estimated.day[factor], false), (estimated.block[factor], true)].map(
                |(evidence, within_days)| PortGain {
                    port,
                    gain: evidence.beyond_usual,
                    within_days,
                },
            )
        })
        .collect()
}

/// Name of the evidence of a port and scale.
pub(super) fn name(port: Port, within_days: bool) -> String {
    format!("{}/{}", port.name(), if within_days { "block" } else { "day" })
}
