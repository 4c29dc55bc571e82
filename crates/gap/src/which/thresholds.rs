//! The evidence that an effect or a port must show before it is named.

use std::collections::BTreeMap;
use std::ops::Deref;

use contract::diagnosis::Evidence;
pub use contract::thresholds::{Threshold, ThresholdStep};
use effects::{Card, Effect};
use serde::{Deserialize, Serialize};

/// Least threshold of an effect, nats: at odds of one effect in fifty a gain of 4 makes it as likely as not.
const LEAST: f64 = 4.0;
/// Least threshold of a port that varies, nats.
const LEAST_PORT: f64 = 20.0;
/// Margin above the largest evidence seen where nothing is missing.
const MARGIN: f64 = 1.3;
/// Cohorts that tell the threshold of a size are up to this many times as large.
const NEIGHBOURS: f64 = 1.5;
/// Share of the worlds in which nothing is missing that may reach a threshold: without them one odd world
/// would set that of its effect.
const ALARMS: f64 = 0.0125;
/// How much more evidence is required of a plant that is not the ODE, on which thresholds were fixed.
const OTHER_PLANTS: f64 = 3.0;
/// The hands whose worlds fixed thresholds, with the file of each.
const HANDS: [(&str, &str); 4] = [
    ("hovorka", include_str!("hovorka.json")),
    ("padova", include_str!("padova.json")),
    ("minimal", include_str!("minimal.json")),
    ("saturating", include_str!("saturating.json")),
];
/// Temperature of the probabilities, nats.
const TEMPERATURE: f64 = 1.5;

/// Thresholds in nats, fixed on worlds in which nothing is missing.
///
/// A plant of another structure than the body gains a little from wrong effects for every day observed, so that
/// large cohorts without an effect reach further than small ones. Beyond the cohorts that it was fixed on a threshold
/// grows with the person-days.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Thresholds(contract::Thresholds);

impl Deref for Thresholds {
    type Target = contract::Thresholds;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl From<contract::Thresholds> for Thresholds {
    fn from(read: contract::Thresholds) -> Self {
        Self(read)
    }
}

/// The same evidence in cohorts of up to so many person-days.
fn even(nats: f64, person_days: f64) -> Threshold {
    Threshold { steps: vec![ThresholdStep { person_days, nats }] }
}

/// The stricter of two at every size.
fn larger(one: &Threshold, other: &Threshold) -> Threshold {
    let mut sizes: Vec<f64> =
        one.steps.iter().chain(&other.steps).map(|step| step.person_days).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.dedup();
    let of = |person_days: f64| ThresholdStep {
        person_days,
        nats: one.over(person_days).max(other.over(person_days)),
    };
    Threshold { steps: sizes.into_iter().map(of).collect() }
}

fn times(mut threshold: Threshold, factor: f64) -> Threshold {
    for step in &mut threshold.steps {
        step.nats *= factor;
    }
    threshold
}

impl Thresholds {
    /// The thresholds in use: for each name the largest of those of all hands.
    ///
    /// # Panics
    /// Never: the files are part of the crate and tested.
    #[must_use]
    pub fn working() -> Self {
        Self::largest_of(HANDS.into_iter().map(|(hand, _)| hand))
    }

    /// Thresholds that never saw the worlds of `hand`: for each name the largest of those of the other hands.
    ///
    /// For a blind check. A hand of which there are no thresholds is judged by those in use.
    ///
    /// # Panics
    /// As [`Self::working`].
    #[must_use]
    pub fn without(hand: &str) -> Self {
        Self::largest_of(HANDS.into_iter().map(|(hand, _)| hand).filter(|other| *other != hand))
    }

    /// The thresholds that were fixed on the worlds of one hand.
    #[must_use]
    pub fn of_hand(hand: &str) -> Option<Self> {
        let (_, text) = HANDS.into_iter().find(|(name, _)| *name == hand)?;
        contract::read(text.as_bytes()).ok().map(Self)
    }

    /// Thresholds that no evidence reaches: for reading the evidence alone.
    pub(crate) fn never() -> Self {
        Self(contract::Thresholds {
            source: "nothing is to be named".to_owned(),
            by_name: BTreeMap::new(),
            other: even(f64::INFINITY, f64::INFINITY),
            temperature: TEMPERATURE,
        })
    }

    fn largest_of(hands: impl Iterator<Item = &'static str>) -> Self {
        hands
            .map(|hand| Self::of_hand(hand).expect("the crate's own file, tested"))
            .reduce(|a, b| a.stricter(&b))
            .expect("more than one hand")
    }

    /// For each name the larger of two thresholds.
    fn stricter(mut self, other: &Self) -> Self {
        for (name, threshold) in &other.by_name {
            let entry = self.0.by_name.entry(name.clone()).or_insert_with(|| threshold.clone());
            *entry = larger(entry, threshold);
        }
        Self(contract::Thresholds {
            source: format!("{}; {}", self.source, other.source),
            other: larger(&self.other, &other.other),
            temperature: self.temperature.max(other.temperature),
            ..self.0
        })
    }

    /// These thresholds for a plant on which they were not fixed: all of them multiplied by a factor, which
    /// stands in `source`. False alarms are not calibrated for such a plant.
    #[must_use]
    pub fn for_other_plants(self) -> Self {
        let contract::Thresholds { source, by_name, other, temperature } = self.0;
        let wider = |threshold| times(threshold, OTHER_PLANTS);
        Self(contract::Thresholds {
            source: format!(
                "{source}; fixed for the ODE plant, here times {OTHER_PLANTS} for another plant"
            ),
            by_name: by_name.into_iter().map(|(name, t)| (name, wider(t))).collect(),
            other: wider(other),
            temperature: OTHER_PLANTS * temperature,
        })
    }

    /// Thresholds that hardly a cohort of `nulls` reaches, in which nothing is missing.
    ///
    /// For each name and size of cohort 1.3 times the largest evidence of the cohorts up to half as large again,
    /// no less than a floor. Up to 1.25 % of the cohorts are left out first: each time the one without which the
    /// thresholds fall by most.
    #[must_use]
    pub fn fit(source: &str, nulls: &[Evidence]) -> Self {
        let sizes = sizes(nulls);
        let mut kept: Vec<&Evidence> = nulls.iter().collect();
        for _ in 0..(ALARMS * nulls.len() as f64) as usize {
            let all = total(&largest(&kept, &sizes));
            let without = |index: usize| {
                let mut others = kept.clone();
                others.remove(index);
                total(&largest(&others, &sizes))
            };
            let falls: Vec<f64> = (0..kept.len()).map(|index| all - without(index)).collect();
            let Some(odd) = (0..falls.len()).max_by(|a, b| falls[*a].total_cmp(&falls[*b])) else {
                break;
            };
            kept.remove(odd);
        }
        let by_name = largest(&kept, &sizes);
        let other = even(LEAST_PORT, sizes[sizes.len() - 1]);
        let source = source.to_owned();
        Self(contract::Thresholds { source, by_name, other, temperature: TEMPERATURE })
    }

    /// That of an effect of a library.
    ///
    /// How often an effect without a threshold of its own (a user's) shows evidence where nothing is missing is not
    /// known. It must show as much as the strictest of the effects that resemble it: that act at its port, or that its
    /// card calls confusable with it; `other` where none of them has a threshold.
    #[must_use]
    pub fn of_effect(&self, card: &Card, library: &[&dyn Effect]) -> Threshold {
        if self.by_name.contains_key(card.id.name()) {
            return self.of(card.id.name());
        }
        library
            .iter()
            .map(|effect| effect.card())
            .filter(|other| self.by_name.contains_key(other.id.name()) && resembles(card, other))
            .map(|other| self.of(other.id.name()))
            .reduce(|one, other| larger(&one, &other))
            .unwrap_or_else(|| self.of(card.id.name()))
    }

    /// That of an effect or a port with its scale: no less than its floor.
    #[must_use]
    pub fn of(&self, name: &str) -> Threshold {
        let mut found = self.by_name.get(name).unwrap_or(&self.other).clone();
        for step in &mut found.steps {
            step.nats = step.nats.max(least(name));
        }
        found
    }
}

/// Whether one effect may show evidence wherever another does: they act at one port, or the card names the other.
fn resembles(card: &Card, other: &Card) -> bool {
    card.port == other.port || card.confusable_with.contains(&other.id)
}

/// Sizes of cohorts that have thresholds of their own, person-days: the largest, and halves of it.
fn sizes(nulls: &[Evidence]) -> [f64; 4] {
    let largest = nulls.iter().map(|null| null.person_days).fold(1.0, f64::max);
    [8.0, 4.0, 2.0, 1.0].map(|part| largest / part)
}

/// For each name and size the evidence that none of the cohorts reaches, nats.
fn largest(nulls: &[&Evidence], sizes: &[f64]) -> BTreeMap<String, Threshold> {
    let floor = |name: &str| Threshold {
        steps: sizes
            .iter()
            .map(|size| ThresholdStep { person_days: *size, nats: least(name) })
            .collect(),
    };
    let mut by_name: BTreeMap<String, Threshold> = BTreeMap::new();
    for null in nulls {
        for (name, gain) in &null.gains {
            let entry = by_name.entry(name.clone()).or_insert_with(|| floor(name));
            for step in &mut entry.steps {
                if null.person_days <= NEIGHBOURS * step.person_days {
                    step.nats = step.nats.max(MARGIN * gain);
                }
            }
        }
    }
    by_name
}

fn total(thresholds: &BTreeMap<String, Threshold>) -> f64 {
    thresholds.values().flat_map(|threshold| &threshold.steps).map(|step| step.nats).sum()
}

/// The floor of a threshold, nats. Names of effects hold no slash.
fn least(name: &str) -> f64 {
    if name.contains('/') { LEAST_PORT } else { LEAST }
}

#[cfg(test)]
mod tests {
    use effects::{EffectId, Port};

    use super::*;

    #[test]
    fn the_working_thresholds_are_positive_and_know_every_effect() {
        let working = Thresholds::working();
        assert!(working.temperature > 0.0);
        for name in effects::names() {
            let threshold = working.of(name);
            assert!(threshold.over(1.0) >= LEAST, "{name}");
            let sizes = [1.0, 50.0, 100.0, 200.0, 400.0, 1e6];
            assert!(sizes.is_sorted_by_key(|size| threshold.over(*size)), "{name}");
        }
    }

    #[test]
    fn the_thresholds_of_a_check_never_saw_the_hand_that_is_judged() {
        for (hand, _) in HANDS {
            let without = Thresholds::without(hand);
            let own = Thresholds::of_hand(hand).expect("the crate's own file");
            assert!(!without.source.contains(&own.source), "{hand}: {}", without.source);
            for (other, _) in HANDS.into_iter().filter(|(other, _)| *other != hand) {
                let theirs = Thresholds::of_hand(other).expect("the crate's own file");
                assert!(without.source.contains(&theirs.source), "{hand}: {}", without.source);
                for name in theirs.by_name.keys() {
                    assert!(without.of(name).over(140.0) >= theirs.of(name).over(140.0), "{name}");
                }
            }
        }
        assert_eq!(Thresholds::without("nobody"), Thresholds::working());
    }

    #[test]
    fn an_effect_without_a_threshold_needs_as_much_as_those_that_resemble_it() {
        let working = Thresholds::working();
        let owned = effects::library();
        let library: Vec<&dyn Effect> = owned.iter().map(AsRef::as_ref).collect();
        let dawn = effects::find("dawn").expect("in the library").card();
        let own = Card { id: EffectId::new("own"), port: Port::InsulinAction, ..dawn };
        for person_days in [20.0, 70.0, 1000.0] {
            let needed = working.of_effect(&own, &library).over(person_days);
            // The strictest at its port; dawn's card says that they are confusable, too.
            let circadian = working.of("circadian_sensitivity").over(person_days);
            assert!(needed >= circadian && needed >= working.of("sleep_loss").over(person_days));
            assert!(needed < working.of("sensor_lag").over(person_days));
        }
        // Those that have one keep it.
        for effect in &library {
            let card = effect.card();
            assert_eq!(working.of_effect(&card, &library), working.of(card.id.name()));
        }
        // Nothing resembles it.
        let alone = Card { confusable_with: &[], ..own };
        assert_eq!(working.of_effect(&alone, &[]), working.of("own"));
    }

    #[test]
    fn hardly_a_null_reaches_the_thresholds_fitted_to_it() {
        let of_size = |person_days, gain, port: f64| Evidence {
            person_days,
            gains: [("dawn".to_owned(), gain), ("egp/day".to_owned(), port)].into(),
        };
        let null = |gain, port| of_size(140.0, gain, port);
        let mut nulls = vec![null(6.0, 30.0), null(1.0, 20.0), null(1.0, 0.0)];
        let fitted = Thresholds::fit("test", &nulls);
        for null in &nulls {
            for (name, gain) in &null.gains {
                assert!(fitted.of(name).over(null.person_days) > *gain, "{name}");
            }
        }
        let twice = fitted.of("dawn").over(280.0);
        assert!((twice - 2.0 * 1.3 * 6.0).abs() < 1e-9, "{twice}"); // rounding
        // What large cohorts show is not required of small ones.
        assert_eq!(fitted.of("dawn").over(60.0), LEAST);
        // One odd world in eighty is left out.
        nulls.extend(vec![null(0.0, 0.0); 77]);
        let fitted = Thresholds::fit("test", &nulls);
        assert_eq!(fitted.of("egp/day").over(140.0), 1.3 * 20.0);
        assert_eq!(fitted.of("dawn").over(140.0), LEAST);
    }
}
