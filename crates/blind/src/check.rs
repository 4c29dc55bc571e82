//! The whole check: `blind_check.json`, schema `blind-check/1`.

use serde::{Deserialize, Serialize};

use crate::amplitude::AmplitudeRecovery;
use crate::answer::{Answer, Candidate, Found, PortEvidence, Verdict};
use crate::by_hand::{HandRow, by_hand};
use crate::ceiling::Ceiling;
use crate::confusion::Confusion;
use crate::error::BlindError;
use crate::label::{Kind, Label, TrueEffect};
use crate::localisation::{WhereScore, WorldWhere};
use crate::outcome::{Outcome, names_a_stranger};
use crate::pairs::PairScore;
use crate::power::{PowerRow, power};
use crate::reliability::Reliability;
use crate::share::Share;
use crate::targets::{Target, false_alarms, targets};

/// Value of [`BlindCheck::schema`].
const SCHEMA: &str = "blind-check/1";
/// Candidates and ports that a row keeps.
const KEPT: usize = 5;

/// A world whose label is known and whose answer is in.
#[derive(Debug, Clone, PartialEq)]
pub struct ScoredWorld {
    /// The truth.
    pub label: Label,
    /// The answer.
    pub answer: Answer,
}

/// Answers scored against labels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BlindCheck {
    /// Always `blind-check/1`.
    pub schema: String,
    /// Seed from which the plan was drawn.
    pub master_seed: u64,
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
    #[serde(default)]
    pub by_hand: Vec<HandRow>,
    /// What was promised.
    pub targets: Vec<Target>,
    /// Whether the answers tell where the gap lies.
    #[serde(rename = "where", default, skip_serializing_if = "Option::is_none")]
    pub localisation: Option<WhereScore>,
    /// What exact courses would name; `None` where that was not asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ceiling: Option<Ceiling>,
}

/// Worlds with an effect outside the library.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UnknownScore {
    /// Those that were called unknown.
    pub recalled: Share,
    /// Of those, the ones whose strongest port is where the effect enters.
    pub right_port: Share,
    /// Of those, the ones whose strongest port, or one that cannot be told from it, is.
    pub right_port_or_in_set: Share,
}

/// One world.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
    pub found: Vec<Found>,
    /// Candidates with the most evidence, most first.
    pub top_candidates: Vec<Candidate>,
    /// Ports with the most evidence, most first.
    pub top_ports: Vec<PortEvidence>,
    /// How the answer compares with the truth.
    pub outcome: Outcome,
    /// Whether an effect was named that does not act and cannot be confused with one that does.
    pub wrong_name: bool,
    /// Whether the strongest port is the right one, for an unknown effect that was called so.
    pub right_port: Option<bool>,
    /// Whether the answer tells where the gap lies; `None` where the label does not.
    #[serde(rename = "where", default, skip_serializing_if = "Option::is_none")]
    pub localisation: Option<WorldWhere>,
    /// Time that the diagnosis took, s.
    pub seconds: f64,
    /// Why there is no answer.
    pub failure: Option<String>,
}

impl BlindCheck {
    /// Scores the worlds. `master_seed` is that of the plan and seeds the bootstraps.
    ///
    /// # Errors
    /// If an interval cannot be formed.
    pub fn score(master_seed: u64, worlds: &[ScoredWorld]) -> Result<Self, BlindError> {
        let unknown = UnknownScore::of(worlds)?;
        let pairs = PairScore::of(worlds, master_seed)?;
        let reliability = Reliability::of(worlds, master_seed)?;
        let targets = targets(worlds, &unknown, &pairs, &reliability)?;
        let singles = worlds.iter().filter(|w| w.label.kind == Kind::Single);
        Ok(Self {
            schema: SCHEMA.to_owned(),
            master_seed,
            worlds: worlds.iter().map(WorldRow::of).collect(),
            confusion: Confusion::of(worlds),
            power: power(worlds)?,
            false_alarms: false_alarms(worlds)?,
            wrong_names: Share::among(singles, |w| names_a_stranger(&w.label, &w.answer))?,
            unknown,
            pairs,
            reliability,
            amplitudes: AmplitudeRecovery::of(worlds),
            failed: Share::among(worlds, |w| w.answer.verdict == Verdict::Failed)?,
            by_hand: by_hand(worlds, master_seed)?,
            targets,
            localisation: Some(WhereScore::of(worlds)?),
            ceiling: None,
        })
    }

    /// The target of this name.
    #[must_use]
    pub fn target(&self, name: &str) -> Option<&Target> {
        self.targets.iter().find(|target| target.name == name)
    }
}

impl UnknownScore {
    pub(crate) fn of(worlds: &[ScoredWorld]) -> Result<Self, BlindError> {
        let outside = || worlds.iter().filter(|w| w.label.kind == Kind::Outside);
        let recalled = || outside().filter(|w| w.answer.verdict == Verdict::Unknown);
        Ok(Self {
            recalled: Share::among(outside(), |w| w.answer.verdict == Verdict::Unknown)?,
            right_port: Share::among(recalled(), |w| right_port(w) == Some(true))?,
            right_port_or_in_set: Share::among(recalled(), |w| {
                let truth = port(w);
                right_port(w) == Some(true)
                    || w.answer.best_port().is_some_and(|best| {
                        best.confusable_with.iter().any(|other| Some(other.as_str()) == truth)
                    })
            })?,
        })
    }
}

fn port(world: &ScoredWorld) -> Option<&str> {
    world.label.effects.first().and_then(|effect| effect.port.as_deref())
}

/// Whether the strongest port is where the effect enters; `None` unless the effect is outside the
/// library and was called unknown.
fn right_port(world: &ScoredWorld) -> Option<bool> {
    let asked = world.label.kind == Kind::Outside && world.answer.verdict == Verdict::Unknown;
    asked.then(|| {
        let best = world.answer.best_port().map(|best| best.port.as_str());
        best.is_some() && best == port(world)
    })
}

impl WorldRow {
    fn of(world: &ScoredWorld) -> Self {
        let ScoredWorld { label, answer } = world;
        let mut top_candidates = answer.candidates.clone();
        top_candidates.sort_by(|a, b| b.gain_nats.total_cmp(&a.gain_nats));
        top_candidates.truncate(KEPT);
        let mut top_ports = answer.ports.clone();
        top_ports.sort_by(|a, b| {
            b.probability.total_cmp(&a.probability).then(b.gain_nats.total_cmp(&a.gain_nats))
        });
        top_ports.truncate(KEPT);
        Self {
            id: label.id.clone(),
            kind: label.kind,
            generator: label.generator.clone(),
            regime: label.regime.clone(),
            people: label.people,
            days: label.days,
            nuisances: label.nuisances.clone(),
            truth: label.effects.clone(),
            verdict: answer.verdict,
            found: answer.found.clone(),
            top_candidates,
            top_ports,
            outcome: Outcome::of(label, answer),
            wrong_name: names_a_stranger(label, answer),
            right_port: right_port(world),
            localisation: WorldWhere::of(label, answer),
            seconds: answer.seconds,
            failure: answer.failure.clone(),
        }
    }
}
