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

#[cfg(test)]
mod tests {
    use super::super::round::none;
    use super::*;

    #[test]
    fn evidence_of_days_and_of_blocks_has_names_of_its_own() {
        let mut estimated = none();
        estimated.day[1].beyond_usual = 27.0;
        estimated.block[1].beyond_usual = 9.0;
        let shown: Vec<PortGain> =
            gains(&estimated).into_iter().filter(|found| found.gain != 0.0).collect();
        let port = RANDOM[1].port;
        let expected = [(27.0, false), (9.0, true)].map(|(gain, within_days)| PortGain {
            port,
            gain,
            within_days,
        });
        assert_eq!(shown, expected);
        let names = shown.iter().map(|found| name(found.port, found.within_days));
        let suffixes: Vec<String> =
            names.map(|name| name.trim_start_matches(port.name()).to_owned()).collect();
        assert_eq!(suffixes, ["/day", "/block"]);
        assert_eq!(gains(&estimated).len(), 2 * RANDOM.len());
    }
}
