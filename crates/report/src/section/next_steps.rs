//! What a reader can do next, from what the folder says.

use super::candidates;
use super::words::{effect, list};
use crate::ReportError;
use crate::html::Html;
use crate::number::count;
use contract::diagnosis::{Standing, Verdict};
use contract::quality::CheckOutcome;
use contract::{DataInUse, Diagnosis};

/// Days below which one person's answer is weak.
const FEW_DAYS: usize = 14;

pub(super) fn body(diagnosis: &Diagnosis, in_use: Option<&DataInUse>) -> Result<Html, ReportError> {
    let mut html = Html::default();
    let mut steps: Vec<String> = in_use.and_then(data).into_iter().collect();
    steps.extend(of_verdict(diagnosis));
    steps.extend(more_data(diagnosis));
    steps.extend(channels(diagnosis));
    steps.push(
        "Repeat the run with another seed. An answer that changes with the seed is none."
            .to_owned(),
    );
    html.list("<ul>", &steps);
    Ok(html)
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
    let of = |standing: Standing| -> Vec<String> {
        let effects = diagnosis.effects.iter().filter(|e| e.standing() == standing);
        effects.map(|found| effect(&found.effect)).collect()
    };
    let mut steps = Vec::new();
    match diagnosis.verdict {
        Verdict::Effect => {
            let (found, suspected) = (of(Standing::Found), of(Standing::Suspected));
            if !found.is_empty() {
                steps.push(format!(
                    "Test what was found on data that this run has not seen: {}. Later days of the same \
                     people, or other people.",
                    list(&found)
                ));
            }
            if !suspected.is_empty() {
                steps.push(format!("Do not build on a suspicion: {}. Record more first.", list(&suspected)));
            }
        }
        Verdict::Unknown => steps.push(
            "Look at the hours and the place in the model at which something is missing, and at the days \
             with the largest errors. An effect of one's own can be added to the library."
                .to_owned(),
        ),
        Verdict::None => steps.push(
            "Do not read this as proof that the model is complete: effects that are small, or that follow no \
             record, are not found."
                .to_owned(),
        ),
    }
    steps
}

fn more_data(diagnosis: &Diagnosis) -> Option<String> {
    let used: Vec<usize> =
        diagnosis.people.iter().filter(|p| p.excluded.is_none()).map(|p| p.days).collect();
    let days: usize = used.iter().sum();
    match used.len() {
        1 => Some(format!(
            "Ask more people or more days: one person with {} says nothing of others.",
            count(days, "day", "days")
        )),
        n if n > 1 && days < FEW_DAYS * n => Some(format!(
            "Record more days: {} for {n} people are fewer than {FEW_DAYS} each on average.",
            count(days, "day", "days")
        )),
        _ => None,
    }
}

fn channels(diagnosis: &Diagnosis) -> Option<String> {
    let untried: Vec<String> = diagnosis.untried.iter().map(|u| effect(&u.effect)).collect();
    (!untried.is_empty()).then(|| {
        format!(
            "Record what signals the effects that could not be tried: {}. The section \u{201c}{}\u{201d} \
             says what is missing for each.",
            list(&untried),
            candidates::HEADING
        )
    })
}
