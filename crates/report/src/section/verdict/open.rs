//! What is not known after a diagnosis.

use crate::number::percent;
use crate::section::words::{effect, list};
use contract::Diagnosis;
use contract::diagnosis::CandidateEffect;

/// Probability from which on an effect that is not named is told.
const TOLD_FROM: f64 = 0.05;
/// Most effects that are told of one kind; the tables have all.
const TOLD: usize = 4;
/// Candidates that are no effects.
const NO_EFFECT: [&str; 2] = ["none", "unknown"];

/// What the diagnosis leaves open, in one paragraph.
pub(super) fn open(diagnosis: &Diagnosis) -> String {
    let parts: Vec<String> = [perhaps(diagnosis), untried(diagnosis), Some(never(diagnosis))]
        .into_iter()
        .flatten()
        .collect();
    parts.join(" ")
}

/// Effects that are neither named nor improbable.
fn perhaps(diagnosis: &Diagnosis) -> Option<String> {
    let mut open: Vec<&CandidateEffect> = diagnosis
        .candidates
        .iter()
        .filter(|candidate| {
            let named = diagnosis.effects.iter().any(|found| found.effect == candidate.effect);
            candidate.probability >= TOLD_FROM && !named && !NO_EFFECT.contains(&&*candidate.effect)
        })
        .collect();
    open.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    let words: Vec<String> = open
        .iter()
        .take(TOLD)
        .map(|candidate| {
            format!("{} ({})", effect(&candidate.effect), percent(candidate.probability))
        })
        .collect();
    let verb = if words.len() == 1 { "acts" } else { "act" };
    (!words.is_empty()).then(|| {
        format!(
            "Whether {} {verb}: neither named (from {}) nor excluded.",
            list(&words),
            percent(diagnosis.posterior.names_from)
        )
    })
}

/// Effects that these records cannot show.
fn untried(diagnosis: &Diagnosis) -> Option<String> {
    let names: Vec<String> =
        diagnosis.untried.iter().take(TOLD).map(|untried| effect(&untried.effect)).collect();
    let more = diagnosis.untried.len() - names.len();
    let names = match more {
        0 => list(&names),
        _ => format!("{} and {more} more", names.join(", ")),
    };
    (!diagnosis.untried.is_empty())
        .then(|| format!("Not tried, since the records lack what would show it: {names}."))
}

/// What no diagnosis of this kind can say.
fn never(diagnosis: &Diagnosis) -> String {
    let which = if diagnosis.effects.is_empty() { "An effect" } else { "Another effect" };
    format!(
        "{which} that is small, or that the library of effects does not hold, may act unseen; an effect is named by \
         how well it fits the records, which does not prove the cause."
    )
}
