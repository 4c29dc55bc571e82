//! The truth of a world.

use serde::{Deserialize, Serialize};

/// What kind of truth a world holds.
#[apply(word!)]
#[derive(Hash, PartialOrd, Ord)]
pub enum Kind {
    /// No effect acts.
    Null,
    /// One effect of the library acts.
    Single,
    /// Two effects of the library act.
    Pair,
    /// One effect acts that the library does not hold.
    Outside,
}

/// The label of a world.
#[apply(strict!)]
pub struct Label {
    /// Name of the world and of its folder.
    pub id: String,
    /// What kind of truth.
    pub kind: Kind,
    /// Effects that act; empty for a null world.
    pub effects: Vec<TrueEffect>,
    /// Which simulator made the world.
    pub generator: String,
    /// How basal insulin is decided.
    pub regime: String,
    /// Number of people.
    pub people: usize,
    /// Days of each before any was taken away.
    pub days: usize,
    /// What was done to the record whatever acts: missing channels, gaps, uneven days.
    pub nuisances: Vec<String>,
    /// Seed of the world.
    pub seed: u64,
    /// Where the effects act; `None` where nothing does, or where it is not known.
    #[serde(rename = "where", skip_serializing_if = "Option::is_none")]
    pub gap: Option<TrueWhere>,
}

/// Labels of worlds that are not under seal, in the order of the worlds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Labels(pub Vec<Label>);

/// An effect that acts in a world.
#[apply(strict!)]
pub struct TrueEffect {
    /// Its name.
    pub effect: String,
    /// Where it enters; stated for effects outside the library, whose place is all there is to find.
    pub port: Option<String>,
    /// Whether the library holds it.
    pub in_library: bool,
    /// Mean amplitude over the people; 1 is the published size.
    pub amplitude: f64,
    /// Mean absolute shift of glucose that was aimed at, mg/dL.
    pub target_mg_dl: f64,
    /// Mean absolute shift of glucose that it causes in this cohort, mg/dL.
    pub achieved_mg_dl: f64,
    /// Whether the amplitude was held at its limit, so that the target is out of reach.
    pub at_limit: bool,
    /// The form that the effect takes in this world, in words; of effects of the library.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form: Option<String>,
}

/// The truth behind "where".
#[apply(strict!)]
pub struct TrueWhere {
    /// Mean difference of glucose with minus without all effects, mg/dL, by horizon: 60, 300 min and whole days from midnight.
    pub mean_mg_dl: [f64; 3],
    /// Mean absolute difference, mg/dL, by horizon: 60, 300 min and whole days from midnight.
    pub mean_absolute_mg_dl: [f64; 3],
    /// The difference by hour (`00` to `23`), context, glucose band and person.
    pub cells: Vec<TrueCell>,
    /// What each effect does at its port.
    pub ports: Vec<PortCourse>,
}

/// The mean difference in one cell.
#[apply(strict!)]
pub struct TrueCell {
    /// By what the cell is set apart.
    pub factor: String,
    /// Which part of it this is.
    pub level: String,
    /// Share of the runs that lie in it.
    pub share: f64,
    /// Mean difference, mg/dL, by horizon: 60, 300 min and whole days from midnight; `None` where no run lies in the cell.
    pub mean_mg_dl: [Option<f64>; 3],
}

/// The mean course of an effect over the day, at its port.
#[apply(strict!)]
pub struct PortCourse {
    /// The effect.
    pub effect: String,
    /// Where it enters.
    pub port: String,
    /// Unit of the course.
    pub unit: String,
    /// With minus without, one entry an hour of the clock; `None` where nothing tells.
    pub by_hour: Vec<Option<f64>>,
}

impl Label {
    /// The label of a world in which nothing acts.
    #[must_use]
    pub fn null(id: &str, generator: &str, regime: &str, people: usize, days: usize) -> Self {
        Self {
            id: id.to_owned(),
            kind: Kind::Null,
            effects: Vec::new(),
            generator: generator.to_owned(),
            regime: regime.to_owned(),
            people,
            days,
            nuisances: Vec::new(),
            seed: 0,
            gap: None,
        }
    }

    /// Whether an effect of this name acts.
    #[must_use]
    pub fn has(&self, effect: &str) -> bool {
        self.effects.iter().any(|e| e.in_library && e.effect == effect)
    }

    /// Largest shift that one of the effects causes, mg/dL; 0 in a null world.
    #[must_use]
    pub fn largest_shift(&self) -> f64 {
        self.effects.iter().map(|e| e.achieved_mg_dl).fold(0.0, f64::max)
    }
}
