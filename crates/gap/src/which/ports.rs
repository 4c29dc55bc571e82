//! Evidence by place in the equations.

use effects::Port;

use super::statistics::RANDOM;
use super::variance::Estimated;

/// Evidence that something varies at a port beyond what is estimated elsewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PortGain {
    pub(super) port: Port,
    /// Nats.
    pub(super) gain: f64,
    /// Whether it varies from block to block rather than from day to day.
    pub(super) within_days: bool,
}

/// The port of each random factor. Insulin input and action on both targets cannot be told apart by how
/// they vary: they stand as one.
const PORTS: [Port; RANDOM.len()] = [
    Port::InsulinAction,
    Port::Egp,
    Port::GutAbsorption,
    Port::InsulinAbsorption,
    Port::CarbAmount,
    Port::Sensor,
    Port::GlucoseFlux,
];

/// Evidence of both scales at every port that has a random factor.
pub(super) fn gains(estimated: &Estimated) -> Vec<PortGain> {
    PORTS
        .into_iter()
        .enumerate()
        .flat_map(|(factor, port)| {
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

/// Name of the threshold of a port and scale.
pub(super) fn threshold_name(port: Port, within_days: bool) -> String {
    format!("{}/{}", port.name(), if within_days { "block" } else { "day" })
}
