//! What a reader can do next, from what the folder says.

use super::candidates;
use super::words::{effect, list};
use crate::html::Html;
use crate::number::count;
use contract::diagnosis::{Standing, Verdict};
use contract::quality::CheckOutcome;
use contract::{DataInUse, Diagnosis};

/// Days below which one person's answer is weak.
const FEW_DAYS: usize = 14;

pub(super) fn body(html: &mut Html, (diagnosis, in_use): (&Diagnosis, Option<&DataInUse>)) {
    let mut steps: Vec<String> = in_use.and_then(data).into_iter().collect();
    steps.extend(of_verdict(diagnosis));
    steps.extend(more_data(diagnosis));
    if !diagnosis.untried.is_empty() {
        steps.push(format!(
            "Record what signals the effects that could not be tried: {}. The section \u{201c}{}\u{201d} \
             says what is missing for each.",
            list(diagnosis.untried.iter().map(|untried| effect(&untried.effect))),
            candidates::HEADING
        ));
    }
    steps.push(
        "Repeat the run with another seed. An answer that changes with the seed is none."
            .to_owned(),
    );
    html.list("<ul>", &steps);
}

fn data(in_use: &DataInUse) -> Option<String> {
    let doubtful = in_use
        .people
        .iter()
        .filter(|person| person.checks.iter().any(|check| check.result != CheckOutcome::Pass));
    let n = doubtful.count();
    (n > 0).then(|| {
        let have = if n == 1 { "has" } else { "have" };
        format!(
            "Look at the data first: {} {have} a warning or a failed check. A clock or a unit that is wrong \
             looks like physiology.",
            count(n, "person", "people")
        )
    })
}

fn of_verdict(diagnosis: &Diagnosis) -> Vec<String> {
    match diagnosis.verdict {
        Verdict::Effect => {
            let of = |standing: Standing| -> Vec<String> {
                let effects = diagnosis.effects.iter().filter(|e| e.standing() == standing);
                effects.map(|found| effect(&found.effect)).collect()
            };
            let (found, suspected) = (of(Standing::Found), of(Standing::Suspected));
            let mut steps = Vec::new();
            if !found.is_empty() {
                steps.push(format!(
                    "Test what was found on data that this run has not seen: {}. Later days of the same \
                     people, or other people.",
                    list(&found)
                ));
            }
            if !suspected.is_empty() {
                let wait = list(&suspected);
                steps.push(format!("Do not build on a suspicion: {wait}. Record more first."));
            }
            steps
        }
        Verdict::Unknown => vec![
            "Look at the hours and the place in the model at which something is missing, and at the days \
             with the largest errors. An effect of one's own can be added to the library."
                .to_owned(),
        ],
        Verdict::None => vec![
            "Do not read this as proof that the model is complete: effects that are small, or that follow no \
             record, are not found."
                .to_owned(),
        ],
    }
}

fn more_data(diagnosis: &Diagnosis) -> Option<String> {
    let used = diagnosis.people.iter().filter(|p| p.excluded.is_none());
    let days: usize = used.clone().map(|p| p.days).sum();
    let recorded = count(days, "day", "days");
    match used.count() {
        1 => Some(format!(
            "Ask more people or more days: one person with {recorded} says nothing of others."
        )),
        n if days < FEW_DAYS * n => Some(format!(
            "Record more days: {recorded} for {n} people are fewer than {FEW_DAYS} each on average."
        )),
        _ => None,
    }
}
