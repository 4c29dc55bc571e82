//! The evidence that an effect or a port must show before it is named.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Least threshold of an effect, nats: at odds of one effect in twenty a gain of 3 makes it as likely as
/// not.
const LEAST: f64 = 3.0;
/// Least threshold of events of no known effect and of ports, nats: "unknown" is the answer that says least.
const LEAST_UNKNOWN: f64 = 5.0;
/// Room above the largest evidence seen where nothing is missing.
const ROOM: f64 = 1.15;
/// Temperature of the probabilities, nats.
const TEMPERATURE: f64 = 1.5;

/// Evidence found in one cohort.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Evidence {
    /// People times days.
    pub person_days: f64,
    /// Evidence, nats, by effect, kind of unknown events, and port with scale.
    pub gains: BTreeMap<String, f64>,
}

/// Thresholds in nats, fixed on worlds in which nothing is missing.
///
/// A plant of another structure than the body gains a little from wrong effects for every day observed, so a
/// threshold is the larger of a constant and a rate times the person-days.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Thresholds {
    /// What they were fixed on.
    pub source: String,
    /// By effect, kind of unknown events, and port with scale.
    pub by_name: BTreeMap<String, Threshold>,
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
    /// The thresholds in use: for each name the larger of those of both generators' calibration worlds.
    ///
    /// # Panics
    /// Never: the files are part of the crate and tested.
    #[must_use]
    pub fn working() -> Self {
        let of = |name| Self::of_worlds(name).expect("the crate's own file, tested");
        let (a, b) = (of("hovorka"), of("padova"));
        let mut by_name = a.by_name.clone();
        for (name, threshold) in &b.by_name {
            let entry = by_name.entry(name.clone()).or_insert(*threshold);
            *entry = entry.larger(*threshold);
        }
        Self {
            source: format!("{}; {}", a.source, b.source),
            by_name,
            other: a.other.larger(b.other),
            temperature: a.temperature.max(b.temperature),
        }
    }

    /// The thresholds that were fixed on the worlds of one generator, `hovorka` or `padova`.
    ///
    /// For a blind check: worlds of one generator are judged by the thresholds of the other.
    #[must_use]
    pub fn of_worlds(generator: &str) -> Option<Self> {
        let text = match generator {
            "hovorka" => include_str!("hovorka.json"),
            "padova" => include_str!("padova.json"),
            _ => return None,
        };
        serde_json::from_str(text).ok()
    }

    /// Thresholds that no cohort of `nulls` reaches, in which nothing is missing.
    ///
    /// For each name: a constant, and a rate that is `1.15` times the largest evidence per person-day among
    /// the cohorts whose evidence reaches the constant.
    #[must_use]
    pub fn fit(source: &str, nulls: &[Evidence]) -> Self {
        let mut by_name: BTreeMap<String, Threshold> = BTreeMap::new();
        for null in nulls {
            for (name, gain) in &null.gains {
                let nats = if names_an_effect(name) { LEAST } else { LEAST_UNKNOWN };
                let start = Threshold { nats, nats_per_person_day: 0.0 };
                let entry = by_name.entry(name.clone()).or_insert(start);
                if ROOM * gain > nats {
                    let rate = ROOM * gain / null.person_days.max(1.0);
                    entry.nats_per_person_day = entry.nats_per_person_day.max(rate);
                }
            }
        }
        let other = Threshold { nats: LEAST_UNKNOWN, nats_per_person_day: 0.05 };
        Self { source: source.to_owned(), by_name, other, temperature: TEMPERATURE }
    }

    /// That of an effect, a kind of unknown events or a port with its scale.
    #[must_use]
    pub fn of(&self, name: &str) -> Threshold {
        self.by_name.get(name).copied().unwrap_or(self.other)
    }
}

/// Whether a name is that of a named effect: neither of unknown events nor of a port with its scale.
fn names_an_effect(name: &str) -> bool {
    !name.contains('/') && !name.starts_with("unknown")
}

impl Threshold {
    fn larger(self, other: Self) -> Self {
        Self {
            nats: self.nats.max(other.nats),
            nats_per_person_day: self.nats_per_person_day.max(other.nats_per_person_day),
        }
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
            let threshold = working.by_name.get(name).copied().unwrap_or(working.other);
            assert!(threshold.nats >= LEAST && threshold.nats_per_person_day >= 0.0, "{name}");
            assert!(threshold.over(1e6) >= threshold.over(1.0));
        }
    }

    #[test]
    fn no_null_reaches_the_thresholds_fitted_to_it() {
        let null = |person_days, gain, port| Evidence {
            person_days,
            gains: [("dawn".to_owned(), gain), ("egp/day".to_owned(), port)].into(),
        };
        let nulls = [null(70.0, 6.0, -1.0), null(280.0, 9.0, 30.0), null(21.0, 1.0, 0.0)];
        let fitted = Thresholds::fit("test", &nulls);
        for null in &nulls {
            for (name, gain) in &null.gains {
                assert!(fitted.of(name).over(null.person_days) > *gain, "{name}");
            }
        }
        assert_eq!(fitted.of("dawn").over(10.0), LEAST);
        assert_eq!(fitted.of("egp/day").over(10.0), LEAST_UNKNOWN);
    }
}
