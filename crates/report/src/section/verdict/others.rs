//! What the other parts of a folder say, a sentence or two each.

use crate::Inputs;
use crate::number::{count, fixed, percent};
use crate::section::what_if::{CONSTRAINED, SAME};
use crate::section::words::list;
use contract::conformance::Verdict as ProofVerdict;
use contract::outcomes::{MethodRows, OutcomeRow};
use contract::{BlindCheck, Conformance, OutcomesTable, WhatIf};

/// Most twins that a sentence names.
const NAMED: usize = 12;

/// The sentences, that of a blind check first.
pub(super) fn sentences(inputs: &Inputs) -> Vec<String> {
    let mut sentences: Vec<String> = inputs.blind_check.iter().flat_map(blind_check).collect();
    sentences.extend(inputs.outcomes.iter().flat_map(outcomes));
    // Which twins are not to be used for what-ifs, of each kind.
    let free = inputs.what_if.as_ref().and_then(|answers| what_if(answers, ["twin", "twins"]));
    let kept = inputs.what_if_constrained.as_ref();
    let kept = kept.and_then(|answers| what_if(answers, CONSTRAINED));
    let told: Vec<String> = free.into_iter().chain(kept).collect();
    sentences.extend((!told.is_empty()).then(|| told.join(" ")));
    sentences.extend(inputs.conformance.as_ref().map(conformance));
    sentences
}

/// How many targets are met, and the two that matter most.
fn blind_check(check: &BlindCheck) -> Vec<String> {
    let of = |met: Option<bool>| check.targets.iter().filter(|t| t.met == met).count();
    let worlds = count(check.worlds.len(), "world", "worlds");
    let told = match check.targets.len() {
        0 => "no target was set".to_owned(),
        all => {
            let met = of(Some(true));
            let targets = count(all, "target", "targets");
            let others = also([(of(Some(false)), "missed"), (of(None), "not tested")]);
            format!("{met} of {targets} {} met{others}", is(met, all))
        }
    };
    let mut paragraphs = vec![format!("Blind check on {worlds}: {told}.")];
    if let Some((named, value)) = check.target("named_at_5").and_then(|t| Some((t, t.value?))) {
        let worlds = count(named.of, "world", "worlds");
        let limits = named.lower.zip(named.upper);
        let ends = limits.map_or_else(String::new, interval_of_share);
        paragraphs.push(format!(
            "An effect that moves glucose by 5 mg/dL or more is named, and no other, in {} of {worlds}{ends}.",
            percent(value)
        ));
    }
    let alarms = check.false_alarms;
    if alarms.of > 0 {
        let worlds = count(alarms.of, "world", "worlds");
        let ends = interval_of_share((alarms.lower, alarms.upper));
        let found = alarms.count;
        paragraphs
            .push(format!("Where nothing acts, something was found in {found} of {worlds}{ends}."));
    }
    paragraphs
}

/// Counts with their words behind another count; of nothing nothing is said.
fn also(counts: [(usize, &str); 2]) -> String {
    let told = counts.into_iter().filter(|(n, _)| *n > 0);
    told.map(|(n, word)| format!(", {n} {word}")).collect()
}

/// The limits of a share's interval, in brackets.
fn interval_of_share((lower, upper): (f64, f64)) -> String {
    let (lower, upper) = (fixed(100.0 * lower, 0), fixed(100.0 * upper, 0));
    format!(" (95\u{a0}% interval {lower} to {upper}\u{a0}%)")
}

/// Equivalence of the first method, and of twins whose courses are drawn.
fn outcomes(outcomes: &OutcomesTable) -> Vec<String> {
    let Some((first, others)) = outcomes.methods.split_first() else {
        return vec!["No method was evaluated against the measured glucose outcomes.".to_owned()];
    };
    let spread = others.iter().filter(|method| method.name == "spread_twin");
    std::iter::once(first).chain(spread).map(|method| equivalence(outcomes, method)).collect()
}

/// The names of the outcomes of which something holds.
fn names(rows: &[OutcomeRow], holds: impl Fn(&OutcomeRow) -> bool) -> Vec<String> {
    rows.iter().filter(|row| holds(row)).map(|row| row.metric.to_uppercase()).collect()
}

fn equivalence(outcomes: &OutcomesTable, method: &MethodRows) -> String {
    let shown = names(&method.rows, |row| row.equivalent);
    let open = names(&method.rows, |row| !row.equivalent);
    let over = format!(
        "over {} and {}",
        count(outcomes.people, "person", "people"),
        count(outcomes.windows, "window", "windows")
    );
    let label = &method.label;
    let mut text = match (shown.len(), open.len()) {
        (0, 0) => format!("{label}: no outcome was tested."),
        (1, 0) => format!(
            "{label}: the one glucose outcome is equivalent to the measured one within its margin, {over}."
        ),
        (0, 1) => format!(
            "{label}: the one glucose outcome is not shown to be equivalent to the measured one, {over}."
        ),
        (all, 0) => format!(
            "{label}: all {all} glucose outcomes are equivalent to the measured ones within their \
             margins, {over}."
        ),
        (0, all) => format!(
            "{label}: none of the {all} glucose outcomes is shown to be equivalent to the measured ones, \
             {over}."
        ),
        (n, others) => format!(
            "{label}: {n} of {} glucose outcomes {} equivalent to the measured ones within their \
             margins ({}), {over}; equivalence is not shown for {}.",
            n + others,
            is(n, n + others),
            list(&shown),
            list(&open)
        ),
    };
    let hopeless = names(&method.rows, OutcomeRow::cannot_be_shown);
    if !hopeless.is_empty() {
        text.push_str(&format!(
            " For {} the differences of this method vary too much over so few people to show it, even if it had no bias.",
            list(&hopeless)
        ));
    }
    // What these leave out, and what a person's own earlier days do not show either.
    let earlier = names(&outcomes.training_days, |row| !row.equivalent);
    let mut floor = open;
    floor.retain(|name| earlier.contains(name) && !hopeless.contains(name));
    if !floor.is_empty() {
        text.push_str(&format!(
            " For {} the sensor on the training days does not show it either.",
            list(&floor)
        ));
    }
    text
}

fn what_if(answers: &WhatIf, [one, many]: [&str; 2]) -> Option<String> {
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
    let (proved, of) = (counted(ProofVerdict::Proved), physical().count());
    let all = count(of, "physiological property", "physiological properties");
    let others = also([
        (counted(ProofVerdict::Violated), "violated"),
        (counted(ProofVerdict::Undecided), "undecided"),
    ]);
    format!("{proved} of {all} {} proved{others}.", is(proved, of))
}

/// The verb of `n` of so many.
const fn is(n: usize, of: usize) -> &'static str {
    if n == 1 || of == 1 { "is" } else { "are" }
}
