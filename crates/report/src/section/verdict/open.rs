//! What is not known after a diagnosis.

use super::sentence::inside_a_sentence;
use crate::number::percent;
use crate::section::words::{effect, list, sentence as capital};
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
    let parts =
        [withheld(diagnosis), perhaps(diagnosis), untried(diagnosis), Some(never(diagnosis))];
    parts.into_iter().flatten().collect::<Vec<String>>().join(" ")
}

/// Effects that are probable enough to be named, and why they are not.
fn withheld(diagnosis: &Diagnosis) -> Option<String> {
    let words = diagnosis.candidates.iter().filter_map(|candidate| {
        let (name, why) = (effect(&candidate.effect), candidate.not_named.as_deref()?);
        let why = inside_a_sentence(why);
        Some(format!("{name} ({}; {why})", percent(candidate.probability)))
    });
    let words: Vec<String> = words.collect();
    (!words.is_empty())
        .then(|| format!("Probable enough, and not named all the same: {}.", list(&words)))
}

/// Effects that are neither named nor improbable.
fn perhaps(diagnosis: &Diagnosis) -> Option<String> {
    let is_open = |candidate: &&CandidateEffect| {
        let named = diagnosis.effects.iter().any(|found| found.effect == candidate.effect);
        let told = named || candidate.not_named.is_some();
        candidate.probability >= TOLD_FROM && !told && !NO_EFFECT.contains(&&*candidate.effect)
    };
    let mut open: Vec<&CandidateEffect> = diagnosis.candidates.iter().filter(is_open).collect();
    open.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    let words = open.iter().take(TOLD);
    let words = words.map(|c| format!("{} ({})", effect(&c.effect), percent(c.probability)));
    let said = &diagnosis.posterior;
    let named = if said.something < said.speaks_from {
        let from = percent(said.speaks_from);
        format!(
            "an effect is named only where something is missing with a probability from {from} on"
        )
    } else {
        format!("an effect is named from {} on", percent(said.names_from))
    };
    (!open.is_empty()).then(|| {
        format!("{} may act: neither named ({named}) nor excluded.", capital(&list(words)))
    })
}

/// Effects that these records cannot show.
fn untried(diagnosis: &Diagnosis) -> Option<String> {
    let names = diagnosis.untried.iter().take(TOLD).map(|untried| effect(&untried.effect));
    let names: Vec<String> = names.collect();
    let names = match diagnosis.untried.len() - names.len() {
        0 => list(&names),
        more => format!("{} and {more} more", names.join(", ")),
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
