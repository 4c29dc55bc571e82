//! What the other parts of a folder say, a sentence or two each.

use crate::Inputs;
use crate::number::{count, fixed, percent};
use crate::section::what_if::SAME;
use crate::section::words::list;
use contract::conformance::Verdict as ProofVerdict;
use contract::outcomes::MethodRows;
use contract::{BlindCheck, Conformance, OutcomesTable, WhatIf};

/// Most twins that a sentence names.
const NAMED: usize = 12;

/// The sentences, that of a blind check first.
pub(super) fn sentences(inputs: &Inputs) -> Vec<String> {
    let mut sentences: Vec<String> = inputs.blind_check.iter().flat_map(blind_check).collect();
    sentences.extend(inputs.outcomes.iter().flat_map(outcomes));
    sentences.extend(what_ifs(inputs));
    sentences.extend(inputs.conformance.as_ref().map(conformance));
    sentences
}

/// How many targets are met, and the two that matter most.
fn blind_check(check: &BlindCheck) -> Vec<String> {
    let (met, missed, untested) = (
        check.targets.iter().filter(|t| t.met == Some(true)).count(),
        check.targets.iter().filter(|t| t.met == Some(false)).count(),
        check.targets.iter().filter(|t| t.met.is_none()).count(),
    );
    let worlds = count(check.worlds.len(), "world", "worlds");
    let mut text = format!("Blind check on {worlds}: ");
    if check.targets.is_empty() {
        text.push_str("no target was set");
    } else {
        let all = count(check.targets.len(), "target", "targets");
        text.push_str(&format!("{met} of {all} {} met", is(met, check.targets.len())));
        for (n, word) in [(missed, "missed"), (untested, "not tested")] {
            if n > 0 {
                text.push_str(&format!(", {n} {word}"));
            }
        }
    }
    let mut paragraphs = vec![format!("{text}.")];
    let named = check.targets.iter().find(|t| t.name == "named_at_5");
    if let Some((named, value)) = named.and_then(|t| Some((t, t.value?))) {
        let worlds = count(named.of, "world", "worlds");
        let ends = interval_of_share(named.lower, named.upper);
        paragraphs.push(format!(
            "An effect that moves glucose by 5 mg/dL or more is named, and no other, in {} of {worlds}{ends}.",
            percent(value)
        ));
    }
    let alarms = check.false_alarms;
    if alarms.of > 0 {
        let worlds = count(alarms.of, "world", "worlds");
        let ends = interval_of_share(Some(alarms.lower), Some(alarms.upper));
        let found = alarms.count;
        paragraphs
            .push(format!("Where nothing acts, something was found in {found} of {worlds}{ends}."));
    }
    paragraphs
}

/// The limits of a share's interval, in brackets, if there are any.
fn interval_of_share(lower: Option<f64>, upper: Option<f64>) -> String {
    let (Some(lower), Some(upper)) = (lower, upper) else {
        return String::new();
    };
    let (lower, upper) = (fixed(100.0 * lower, 0), fixed(100.0 * upper, 0));
    format!(" (95\u{a0}% interval {lower} to {upper}\u{a0}%)")
}

/// Equivalence of the first method, and of twins whose courses are drawn.
fn outcomes(outcomes: &OutcomesTable) -> Vec<String> {
    let Some(first) = outcomes.methods.first() else {
        return vec!["No method was evaluated against the measured glucose outcomes.".to_owned()];
    };
    let spread = outcomes.methods[1..].iter().filter(|method| method.name == "spread_twin");
    std::iter::once(first).chain(spread).map(|method| equivalence(outcomes, method)).collect()
}

fn equivalence(outcomes: &OutcomesTable, method: &MethodRows) -> String {
    let names = |equivalent: bool| -> Vec<String> {
        let rows = method.rows.iter().filter(|row| row.equivalent == equivalent);
        rows.map(|row| row.metric.to_uppercase()).collect()
    };
    let (shown, open) = (names(true), names(false));
    let over = format!(
        "over {} and {}",
        count(outcomes.people, "person", "people"),
        count(outcomes.windows, "window", "windows")
    );
    let hopeless = method.rows.iter().filter(|row| row.cannot_be_shown());
    let hopeless: Vec<String> = hopeless.map(|row| row.metric.to_uppercase()).collect();
    // What these leave out, and what a person's own earlier days do not show either.
    let floor = outcomes.training_days.iter().filter(|row| !row.equivalent);
    let floor: Vec<String> = floor.map(|row| row.metric.to_uppercase()).collect();
    let floor: Vec<String> = open
        .iter()
        .filter(|name| floor.contains(name) && !hopeless.contains(name))
        .cloned()
        .collect();
    let mut aside = String::new();
    if !hopeless.is_empty() {
        aside.push_str(&format!(
            " For {} the differences of this method vary too much over so few people to show it, even if it had no bias.",
            list(&hopeless)
        ));
    }
    if !floor.is_empty() {
        aside.push_str(&format!(
            " For {} the sensor on the training days does not show it either.",
            list(&floor)
        ));
    }
    let method = &method.label;
    let text = match (shown.len(), open.len()) {
        (0, 0) => format!("{method}: no outcome was tested."),
        (1, 0) => format!(
            "{method}: the one glucose outcome is equivalent to the measured one within its margin, {over}."
        ),
        (0, 1) => format!(
            "{method}: the one glucose outcome is not shown to be equivalent to the measured one, {over}."
        ),
        (_, 0) => format!(
            "{method}: all {} glucose outcomes are equivalent to the measured ones within their \
             margins, {over}.",
            shown.len()
        ),
        (0, _) => format!(
            "{method}: none of the {} glucose outcomes is shown to be equivalent to the measured ones, \
             {over}.",
            open.len()
        ),
        (n, _) => format!(
            "{method}: {n} of {} glucose outcomes {} equivalent to the measured ones within their \
             margins ({}), {over}; equivalence is not shown for {}.",
            n + open.len(),
            is(n, n + open.len()),
            list(&shown),
            list(&open)
        ),
    };
    text + &aside
}

/// Which twins are not to be used for what-ifs, of each kind.
fn what_ifs(inputs: &Inputs) -> Option<String> {
    let free = inputs.what_if.as_ref().and_then(|answers| what_if(answers, "twin", "twins"));
    let kept = inputs.what_if_constrained.as_ref().and_then(|answers| {
        what_if(answers, "twin that keeps physiology's signs", "twins that keep physiology's signs")
    });
    let told: Vec<String> = free.into_iter().chain(kept).collect();
    (!told.is_empty()).then(|| told.join(" "))
}

fn what_if(answers: &WhatIf, one: &str, many: &str) -> Option<String> {
    let out = answers.order.iter().filter(|twin| !twin.ordered);
    let out: Vec<String> = out.map(|twin| twin.person_id.clone()).collect();
    let of = count(answers.order.len(), one, many);
    match (answers.order.len(), out.len()) {
        (0, _) => None,
        (all, 0) => Some(format!(
            "More insulin always lowers mean glucose, and never raises glucose by more than {SAME} mg/dL, in \
             {all} of {of}."
        )),
        (_, n) => Some(format!(
            "More insulin does not always mean less glucose in {n} of {of}, which must not be used for \
             what-ifs: {}.",
            if n <= NAMED { list(&out) } else { "the table below names them".to_owned() }
        )),
    }
}

/// How many physiological properties are proved.
fn conformance(conformance: &Conformance) -> String {
    let physical = || conformance.rows.iter().filter(|row| row.is_physical());
    let counted = |verdict: ProofVerdict| physical().filter(|row| row.verdict == verdict).count();
    let proved = counted(ProofVerdict::Proved);
    let of = physical().count();
    let all = count(of, "physiological property", "physiological properties");
    let mut text = format!("{proved} of {all} {} proved", is(proved, of));
    for (verdict, word) in
        [(ProofVerdict::Violated, "violated"), (ProofVerdict::Undecided, "undecided")]
    {
        let n = counted(verdict);
        if n > 0 {
            text.push_str(&format!(", {n} {word}"));
        }
    }
    text.push('.');
    text
}

/// The verb of `n` of so many.
const fn is(n: usize, of: usize) -> &'static str {
    if n == 1 || of == 1 { "is" } else { "are" }
}
