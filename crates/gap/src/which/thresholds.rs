//! The evidence that an effect or a port must show before it is named.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Thresholds in nats, fixed on worlds in which nothing is missing.
///
/// A plant of another structure than the body gains a little from wrong effects for every day observed, so a
/// threshold is the larger of a constant and a rate times the person-days.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Thresholds {
    /// What they were fixed on.
    pub source: String,
    /// By effect.
    pub effects: BTreeMap<String, Threshold>,
    /// By port.
    pub ports: BTreeMap<String, Threshold>,
    /// For what is not named above.
    pub other: Threshold,
    /// Nats of evidence over the threshold by which the odds of an answer rise e-fold.
    pub temperature: f64,
}

/// One threshold.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Threshold {
    /// Least evidence, nats.
    pub nats: f64,
    /// Evidence per person and day.
    pub nats_per_person_day: f64,
}

impl Threshold {
    /// The evidence needed over so many person-days.
    #[must_use]
    pub fn over(&self, person_days: f64) -> f64 {
        self.nats.max(self.nats_per_person_day * person_days)
    }
}

impl Thresholds {
    /// The thresholds in use: the larger of those of both generators' calibration worlds.
    ///
    /// # Panics
    /// Never: the file is part of the crate and tested.
    #[must_use]
    pub fn working() -> Self {
        serde_json::from_str(include_str!("thresholds.json")).expect("the crate's own file, tested")
    }

    /// That of an effect.
    #[must_use]
    pub fn of_effect(&self, name: &str) -> Threshold {
        self.effects.get(name).copied().unwrap_or(self.other)
    }

    /// That of a port.
    #[must_use]
    pub fn of_port(&self, name: &str) -> Threshold {
        self.ports.get(name).copied().unwrap_or(self.other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_working_thresholds_are_positive_and_know_every_effect() {
        let working = Thresholds::working();
        assert!(working.temperature > 0.0);
        for name in effects::names() {
            let threshold = working.effects.get(name).unwrap_or_else(|| panic!("{name}"));
            assert!(threshold.nats > 0.0 && threshold.nats_per_person_day >= 0.0, "{name}");
            assert!(threshold.over(1e6) >= threshold.over(1.0));
        }
    }
}
