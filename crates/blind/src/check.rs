//! The whole check: `blind_check.json`, schema `blind-check/4`.

use crate::amplitude::amplitude_recovery;
use crate::confusion::confusion;
use crate::localisation::{ranked, where_score, world_where};
use crate::pairs::pair_score;
use crate::reliability::reliability;
use crate::share::among;
use contract::Document as _;
use contract::blind_check::{BlindCheck, Kind, Verdict, WorldRow};

use crate::by_hand::by_hand;
use crate::error::BlindError;
use crate::outcome::{names_a_stranger, outcome};
use crate::power::power;
use crate::scored_world::ScoredWorld;
use crate::targets::{false_alarms, targets};
use crate::unknown::{right_port, unknown_score};

/// Candidates and ports that a row keeps.
const KEPT: usize = 5;

/// Scores the worlds. `master_seed` is that of the plan and seeds the bootstraps.
///
/// # Errors
/// If an interval cannot be formed.
pub fn score(master_seed: u64, worlds: &[ScoredWorld]) -> Result<BlindCheck, BlindError> {
    let unknown = unknown_score(worlds)?;
    let pairs = pair_score(worlds, master_seed)?;
    let reliability = reliability(worlds, master_seed)?;
    let targets = targets(worlds, &unknown, &pairs, &reliability)?;
    let singles = worlds.iter().filter(|w| w.label.kind == Kind::Single);
    Ok(BlindCheck {
        schema: BlindCheck::SCHEMA.to_owned(),
        master_seed,
        seeds: Vec::new(),
        worlds: worlds.iter().map(world_row).collect(),
        confusion: confusion(worlds),
        power: power(worlds)?,
        false_alarms: false_alarms(worlds)?,
        wrong_names: among(singles, |w| names_a_stranger(&w.label, &w.answer))?,
        unknown,
        pairs,
        reliability,
        amplitudes: amplitude_recovery(worlds),
        failed: among(worlds, |w| w.answer.verdict == Verdict::Failed)?,
        by_hand: by_hand(worlds, master_seed)?,
        targets,
        localisation: Some(where_score(worlds)?),
        ceiling: None,
    })
}

fn world_row(world: &ScoredWorld) -> WorldRow {
    let ScoredWorld { label, answer } = world;
    let mut top_candidates = answer.candidates.clone();
    top_candidates.sort_by(|a, b| b.gain_nats.total_cmp(&a.gain_nats));
    top_candidates.truncate(KEPT);
    WorldRow {
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
        top_ports: ranked(answer).into_iter().take(KEPT).cloned().collect(),
        outcome: outcome(label, answer),
        wrong_name: names_a_stranger(label, answer),
        right_port: right_port(world),
        localisation: world_where(label, answer),
        seconds: answer.seconds,
        failure: answer.failure.clone(),
    }
}
