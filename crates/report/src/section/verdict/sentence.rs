//! The one sentence of a diagnosis: where, which and how far. Tiles and tables agree with it.

use super::how_far::change;
use super::place::{direction, worst};
use crate::number::{fixed, percent};
use crate::section::words::{effect, list, sentence as capital, situation};
use contract::Diagnosis;
use contract::diagnosis::{CellGap, FOUND_ABOVE, FoundEffect, Standing, Verdict};

/// The sentence.
pub(crate) fn sentence(diagnosis: &Diagnosis) -> String {
    let place = worst(diagnosis).map(gap);
    let clauses: Vec<String> = match diagnosis.verdict {
        Verdict::Effect => {
            let shrinks = change(diagnosis).map(|change| change.clause);
            place.into_iter().chain([named(diagnosis)]).chain(shrinks).collect()
        }
        Verdict::Unknown => place.into_iter().chain([unknown(diagnosis)]).collect(),
        Verdict::None => {
            let nothing = format!(
                "no effect is found (probability that something is missing: {})",
                percent(diagnosis.posterior.something)
            );
            let rest =
                place.map(|gap| format!("an error remains that no effect accounts for: {gap}"));
            std::iter::once(nothing).chain(rest).collect()
        }
    };
    format!("{}.", capital(&clauses.join("; ")))
}

/// An error in one situation.
fn gap(cell: &CellGap) -> String {
    format!(
        "glucose is {}-predicted by {} mg/dL {}",
        direction(cell),
        fixed(cell.mean_error_mg_dl.abs(), 0),
        situation(cell.factor.name(), &cell.level),
    )
}

/// Effects that are found, and those that are only suspected.
fn named(diagnosis: &Diagnosis) -> String {
    let listed = |standing: Standing| {
        let effects = diagnosis.effects.iter().filter(|found| found.standing() == standing);
        let effects: Vec<String> = effects.map(with_probability).collect();
        (!effects.is_empty()).then(|| list(effects))
    };
    match (listed(Standing::Found), listed(Standing::Suspected)) {
        (Some(found), None) => format!("found: {found}"),
        (Some(found), Some(suspected)) => format!("found: {found}; suspected: {suspected}"),
        (None, Some(suspected)) => format!("no effect is found; suspected: {suspected}"),
        (None, None) => "an effect is named, but the file does not say which".to_owned(),
    }
}

/// An effect with its probability, what cannot be separated from it, and why it is only suspected.
fn with_probability(found: &FoundEffect) -> String {
    let mut asides = vec![format!("probability {}", percent(found.probability))];
    if !found.confusable_with.is_empty() {
        let like = list(found.confusable_with.iter().map(|key| effect(key)));
        asides.push(format!("cannot be separated from {like}"));
    }
    asides.extend(why_suspected(found));
    format!("{} ({})", effect(&found.effect), asides.join("; "))
}

/// The first condition of being found that fails.
pub(crate) fn why_suspected(found: &FoundEffect) -> Option<String> {
    if found.standing() == Standing::Found {
        return None;
    }
    let why = if found.probability <= FOUND_ABOVE {
        "not more probable than not"
    } else if found.amplitude.lower <= 0.0 {
        "its size may be 0"
    } else if found.in_favour() == 0 {
        "nobody's own data favour it"
    } else if let Some(doubt) = found.questioned.first() {
        return Some(inside_a_sentence(doubt));
    } else {
        "the data of one person alone favour it"
    };
    Some(why.to_owned())
}

/// A sentence as a part of another.
pub(super) fn inside_a_sentence(sentence: &str) -> String {
    let mut letters = sentence.trim_end_matches('.').chars();
    let first = letters.next().map(|first| first.to_lowercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}

/// That something without a name is missing, and the most probable answer, although not probable enough.
fn unknown(diagnosis: &Diagnosis) -> String {
    let said = &diagnosis.posterior;
    let candidates = diagnosis.candidates.iter().filter(|candidate| candidate.effect != "none");
    let best = candidates.max_by(|a, b| a.probability.total_cmp(&b.probability));
    let best = best.map_or_else(String::new, |best| {
        let name = match best.effect.as_str() {
            "unknown" => "something that the library does not hold".to_owned(),
            name => effect(name),
        };
        let why = best.not_named.as_deref().map_or_else(
            || format!("an effect is named from {} on", percent(said.names_from)),
            inside_a_sentence,
        );
        format!(" (most probable: {name}, {}; {why})", percent(best.probability))
    });
    let probability = percent(said.something);
    format!("something is missing (probability {probability}) and no effect can be named{best}")
}
