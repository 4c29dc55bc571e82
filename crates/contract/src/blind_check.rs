//! `blind_check.json`: answers of the diagnosis scored against labels that it could not see.

mod answer;
mod ceiling;
mod label;
mod places;
mod planted;
mod realism;
mod scores;
mod seal;

pub use answer::{Answer, Outcome, Verdict};
pub use ceiling::{Ceiling, CeilingAtBar, ExactCourse};
pub use label::{Kind, Label, Labels, PortCourse, TrueCell, TrueEffect, TrueWhere};
pub use places::{ContextScore, CoverageScore, EquationScore, WhereScore, WorldWhere};
pub use planted::{
    CalibratedPeople, EvidencePair, PlantedCheck, PlantedLabel, PlantedRow, PlantedTotals,
};
pub use realism::{Group, People, PersonStatistics, Quantiles, Realism, StatisticRow};
pub use scores::{
    AmplitudeRecovery, Bound, Confusion, ConfusionRow, HandRow, PairScore, PowerRow, Reliability,
    ReliabilityBin, Share, Target,
};
pub use seal::{OpenedLabel, OpenedLabels, Seal, SealedWorld};

use crate::diagnosis::{CandidateEffect, FoundEffect, PortEvidence};

/// Answers scored against labels.
#[apply(strict!)]
pub struct BlindCheck {
    /// `blind-check/4`.
    pub schema: String,
    /// Seed from which the plan was drawn; of the first check, where several are scored together.
    pub master_seed: u64,
    /// Seeds of the checks that are scored together; absent for one check.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub seeds: Vec<u64>,
    /// Every world.
    pub worlds: Vec<WorldRow>,
    /// Truth against answer.
    pub confusion: Confusion,
    /// How often effects are found.
    pub power: Vec<PowerRow>,
    /// Null worlds in which an effect was named or "unknown" was said.
    pub false_alarms: Share,
    /// Worlds with one effect in which another was named that cannot be confused with it.
    pub wrong_names: Share,
    /// Worlds with an effect outside the library.
    pub unknown: UnknownScore,
    /// Worlds with two effects.
    pub pairs: PairScore,
    /// Whether probabilities come true.
    pub reliability: Reliability,
    /// Whether larger effects get larger estimates.
    pub amplitudes: AmplitudeRecovery,
    /// Worlds whose diagnosis ended without an answer.
    pub failed: Share,
    /// The figures by hand, for diagnoses that never saw that hand; all hands together last.
    pub by_hand: Vec<HandRow>,
    /// What was promised.
    pub targets: Vec<Target>,
    /// Whether the answers tell where the gap lies.
    #[serde(rename = "where", skip_serializing_if = "Option::is_none")]
    pub localisation: Option<WhereScore>,
    /// What exact courses would name; `None` where that was not asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ceiling: Option<Ceiling>,
}

/// Worlds with an effect outside the library.
#[apply(strict!)]
pub struct UnknownScore {
    /// Those that were called unknown.
    pub recalled: Share,
    /// Of those, the ones whose strongest port is where the effect enters.
    pub right_port: Share,
    /// Of those, the ones whose strongest port, or one that cannot be told from it, is.
    pub right_port_or_in_set: Share,
}

/// One world.
#[apply(strict!)]
pub struct WorldRow {
    /// The world.
    pub id: String,
    /// What kind of truth.
    pub kind: Kind,
    /// Which simulator made it.
    pub generator: String,
    /// How basal insulin was decided.
    pub regime: String,
    /// Number of people.
    pub people: usize,
    /// Days of each.
    pub days: usize,
    /// What was done to the record whatever acts.
    pub nuisances: Vec<String>,
    /// What acts.
    pub truth: Vec<TrueEffect>,
    /// The answer in one word.
    pub verdict: Verdict,
    /// Effects found.
    pub found: Vec<FoundEffect>,
    /// Candidates with the most evidence, most first.
    pub top_candidates: Vec<CandidateEffect>,
    /// Ports with the most evidence, most first.
    pub top_ports: Vec<PortEvidence>,
    /// How the answer compares with the truth.
    pub outcome: Outcome,
    /// Whether an effect was named that does not act and cannot be confused with one that does.
    pub wrong_name: bool,
    /// Whether the strongest port is the right one, for an unknown effect that was called so.
    pub right_port: Option<bool>,
    /// Whether the answer tells where the gap lies; `None` where the label does not.
    #[serde(rename = "where", skip_serializing_if = "Option::is_none")]
    pub localisation: Option<WorldWhere>,
    /// Time that the diagnosis took, s.
    pub seconds: f64,
    /// Why there is no answer.
    pub failure: Option<String>,
}

impl BlindCheck {
    /// The target of this name.
    #[must_use]
    pub fn target(&self, name: &str) -> Option<&Target> {
        self.targets.iter().find(|target| target.name == name)
    }
}
