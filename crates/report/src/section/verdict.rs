//! The answer in sentences, before everything else.

use super::words::{ahead, effect, list, number, port, situation};
use crate::Inputs;
use crate::html::Html;
use crate::number::{count, fixed, p_value, percent};
use contract::conformance::Verdict as ProofVerdict;
use contract::diagnosis::{
    CellFactor, CellGap, FoundEffect, HorizonChange, PosteriorSaid, Verdict,
};
use contract::outcomes::MethodRows;
use contract::{BlindCheck, Conformance, Diagnosis, OutcomesTable, WhatIf};

/// Family-wise level at which the verdict names a situation.
pub(super) const LEVEL: f64 = 0.05;

/// Power from which an effect counts as one that would have been found.
pub(super) const POWER: f64 = 0.9;

/// Most twins that a sentence names.
const NAMED: usize = 12;

/// Title of the page.
pub(super) fn title(inputs: &Inputs) -> String {
    let only_check = inputs.blind_check.is_some() && inputs.diagnosis.is_none();
    match &inputs.outcomes {
        Some(outcomes) => format!("Sim-to-real report: {}", outcomes.cohort),
        None if only_check => "Blind check of the diagnosis".to_owned(),
        None => "Sim-to-real report".to_owned(),
    }
}

/// One sentence for each question that the inputs answer.
pub(super) fn body(inputs: &Inputs) -> Html {
    let mut html = Html::default();
    let mut paragraphs: Vec<String> = inputs.diagnosis.as_ref().map(diagnosis).unwrap_or_default();
    paragraphs.extend(inputs.blind_check.as_ref().map(blind_check).unwrap_or_default());
    paragraphs.extend(inputs.outcomes.iter().flat_map(outcomes));
    paragraphs.extend(what_ifs(inputs));
    paragraphs.extend(inputs.conformance.as_ref().map(conformance));
    html.literal("<div class=\"verdict\">\n");
    if paragraphs.is_empty() {
        html.absent(
            "This folder holds no diagnosis, no blind check, no outcomes and no conformance table, so \
             there is no verdict.",
        );
    }
    for (index, paragraph) in paragraphs.iter().enumerate() {
        if index == 0 {
            html.literal("<p class=\"lead\">").text(paragraph).literal("</p>\n");
        } else {
            html.paragraph(paragraph);
        }
    }
    html.literal("</div>\n");
    html
}

/// What is missing, where the gap is, and what changes; the answer comes first.
fn diagnosis(diagnosis: &Diagnosis) -> Vec<String> {
    let mut parts: Vec<String> = Vec::new();
    match diagnosis.verdict {
        Verdict::None => {
            parts.push(match &diagnosis.posterior {
                Some(said) => format!(
                    "No effect was found (probability that something is missing: {}).",
                    percent(said.something)
                ),
                None => "No effect was found among those that these data could show.".to_owned(),
            });
            parts.extend(would_have_been_found(diagnosis));
            if let Some(cell) = worst(diagnosis) {
                parts.push(format!("An error remains that no effect accounts for: {}.", gap(cell)));
            }
        }
        Verdict::Unknown => {
            parts.push(missing(diagnosis));
            parts.extend(worst(diagnosis).map(|cell| format!("{}.", gap(cell))));
        }
        Verdict::Effect => {
            parts.push(found(&diagnosis.effects));
            parts.extend(diagnosis.effects.iter().filter_map(questioned));
            parts.extend(worst(diagnosis).map(|cell| format!("{}.", gap(cell))));
            parts.extend(shrinks(diagnosis));
        }
    }
    parts.extend(diagnosis.notes.iter().cloned());
    parts
}

/// The effects found, in one sentence.
fn found(effects: &[FoundEffect]) -> String {
    if effects.is_empty() {
        return "An effect was found.".to_owned();
    }
    let named: Vec<String> = effects
        .iter()
        .map(|found| {
            let stated = format!("probability {}", percent(found.probability));
            let like: Vec<String> = found.confusable_with.iter().map(|key| effect(key)).collect();
            let set =
                (!like.is_empty()).then(|| format!("cannot be told apart from {}", list(&like)));
            let aside: Vec<String> = std::iter::once(stated).chain(set).collect();
            format!("{} ({})", effect(&found.effect), aside.join("; "))
        })
        .collect();
    match effects.len() {
        1 => format!("One effect was found: {}.", list(&named)),
        n => format!("{} effects were found: {}.", number(n), list(&named)),
    }
}

/// Why a name is doubtful.
fn questioned(found: &FoundEffect) -> Option<String> {
    (!found.questioned.is_empty()).then(|| {
        let name = effect(&found.effect);
        format!("Doubt this name, {name}. {}", found.questioned.join(" "))
    })
}

/// The verdict where something without a name is missing.
fn missing(diagnosis: &Diagnosis) -> String {
    let what = match &diagnosis.posterior {
        Some(said) => believed_missing(diagnosis, said),
        None => "Something is missing that nothing in the library explains.".to_owned(),
    };
    let Some(best) = super::ports::best(diagnosis) else {
        return what;
    };
    let mut places = vec![port(&best.port)];
    places
        .extend(best.confusable_with.iter().filter(|other| **other != best.port).map(|p| port(p)));
    let apart = if places.len() > 1 { " (the data cannot tell which)" } else { "" };
    format!("{what} Most probably it concerns {}{apart}.", places.join(" or "))
}

/// That something is missing, and what is most probable although not probable enough.
fn believed_missing(diagnosis: &Diagnosis, said: &PosteriorSaid) -> String {
    let probability = percent(said.something);
    let candidates = diagnosis.candidates.iter().filter(|candidate| candidate.effect != "none");
    let best = candidates
        .map(|candidate| (candidate.effect.as_str(), candidate.probability))
        .max_by(|a, b| a.1.total_cmp(&b.1));
    let likely = match best {
        Some(("unknown", p)) => {
            format!("It is most probably nothing that the library holds ({})", percent(p))
        }
        Some((name, p)) => format!("The most probable effect is {} ({})", effect(name), percent(p)),
        None => return format!("Something is missing (probability {probability})."),
    };
    format!(
        "Something is missing (probability {probability}), and no effect is probable enough to be named. {likely}; an \
         effect is named from {} on.",
        percent(said.names_from)
    )
}

/// From which shift on effects would have been found, and which effects would not have been found
/// at any.
fn would_have_been_found(diagnosis: &Diagnosis) -> Option<String> {
    let mut names: Vec<&str> = Vec::new();
    for row in &diagnosis.power {
        if !names.contains(&row.effect.as_str()) {
            names.push(&row.effect);
        }
    }
    let (mut largest, mut never): (Option<f64>, Vec<String>) = (None, Vec::new());
    for name in names {
        let least = least_found(diagnosis, name);
        match least {
            Some(shift) => largest = Some(largest.map_or(shift, |known| known.max(shift))),
            None => never.push(effect(name)),
        }
    }
    let found = largest.map(|shift| {
        format!(
            "Effects that move glucose by at least {} mg/dL would have been found with {} \
             probability.",
            fixed(shift, if shift.fract() == 0.0 { 0 } else { 1 }),
            percent(POWER)
        )
    });
    let not = (!never.is_empty()).then(|| {
        let also =
            if found.is_some() { "This does not hold for" } else { "There was no such power for" };
        format!("{also} {}, at any size that was tried.", list(&never))
    });
    let both: Vec<String> = [found, not].into_iter().flatten().collect();
    (!both.is_empty()).then(|| both.join(" "))
}

/// The smallest shift from which every tested larger one has the power.
fn least_found(diagnosis: &Diagnosis, name: &str) -> Option<f64> {
    let mut rows: Vec<(f64, f64)> = diagnosis
        .power
        .iter()
        .filter(|row| row.effect == name)
        .map(|row| (row.shift_mg_dl, row.power))
        .collect();
    rows.sort_by(|a, b| b.0.total_cmp(&a.0));
    rows.iter().take_while(|(_, power)| *power >= POWER).last().map(|(shift, _)| *shift)
}

/// What the effects do to the error, at the longest horizon with a certain change, or at the
/// longest of all.
fn shrinks(diagnosis: &Diagnosis) -> Option<String> {
    // A reconstruction is no prediction.
    let predicted = || diagnosis.how_far.horizons.iter().filter(|h| !h.reconstructed);
    let certain = |h: &&HorizonChange| h.difference.upper < 0.0;
    let change = predicted()
        .filter(certain)
        .max_by_key(|h| h.minutes)
        .or_else(|| predicted().max_by_key(|h| h.minutes))?;
    let with = if diagnosis.effects.len() == 1 { "With it" } else { "With them" };
    let open = if certain(&change) { "" } else { ", a change that the data cannot tell from none" };
    Some(format!(
        "{with}, the mean absolute error {} ahead on held-out days goes from {} to {} mg/dL{open}.",
        ahead(change.minutes),
        fixed(change.mae_before, 1),
        fixed(change.mae_after, 1)
    ))
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
        text.push_str(&format!("{met} of {} targets are met", check.targets.len()));
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
            "An effect that moves glucose by 5 mg/dL or more is named in {} of {worlds}{ends}.",
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

/// The situation that stands out with the largest share of the error.
fn worst(diagnosis: &Diagnosis) -> Option<&CellGap> {
    diagnosis
        .cells
        .iter()
        .filter(|cell| cell.p_adjusted < LEVEL)
        .filter(|cell| {
            matches!(cell.factor, CellFactor::Hour | CellFactor::Context | CellFactor::GlucoseBand)
        })
        .max_by(|a, b| a.share_of_gap.total_cmp(&b.share_of_gap))
}

/// One gap in words.
fn gap(cell: &CellGap) -> String {
    // The step-down p can be small while the single-step interval still includes zero, so the
    // limits keep their signs, in the direction of the error.
    let (direction, size, lower, upper) = if cell.mean_error_mg_dl > 0.0 {
        ("under", cell.mean_error_mg_dl, cell.lower, cell.upper)
    } else {
        ("over", -cell.mean_error_mg_dl, -cell.upper, -cell.lower)
    };
    let horizon = format!(", {} ahead", ahead(cell.horizon_minutes));
    format!(
        "Glucose is {direction}-predicted by {} mg/dL {}{horizon} (simultaneous interval {} to {}, \
         adjusted p {})",
        fixed(size, 0),
        situation(cell.factor.name(), &cell.level),
        fixed(lower, 0),
        fixed(upper, 0),
        p_value(cell.p_adjusted)
    )
}

/// Equivalence of the first method, and of twins whose courses are drawn.
fn outcomes(outcomes: &OutcomesTable) -> Vec<String> {
    let Some(first) = outcomes.methods.first() else {
        return vec!["No method was evaluated against the real glucose outcomes.".to_owned()];
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
            " For {} so few people, scattered so much, could not have shown it of any method.",
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
    let text = match (shown.is_empty(), open.is_empty()) {
        (true, true) => format!("{method}: no outcome was tested."),
        (false, true) => format!(
            "{method}: all {} glucose outcomes are equivalent to the real ones within their \
             margins, {over}.",
            shown.len()
        ),
        (true, false) => format!(
            "{method}: none of the {} glucose outcomes is shown to be equivalent to the real ones, \
             {over}.",
            open.len()
        ),
        (false, false) => format!(
            "{method}: {} of {} glucose outcomes are equivalent to the real ones within their \
             margins ({}), {over}; equivalence is not shown for {}.",
            shown.len(),
            shown.len() + open.len(),
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
    let answer = if out.len() == 1 { "answers" } else { "answer" };
    let are = if out.len() == 1 { "is" } else { "are" };
    match (answers.order.len(), out.len()) {
        (0, _) => None,
        (_, 0) => Some(format!("Less insulin never means less glucose in any of {of}.")),
        (_, n) => Some(format!(
            "{n} of {of} {answer} other doses out of order and {are} not to be used for what-ifs: {}.",
            if n <= NAMED { list(&out) } else { "the table below names them".to_owned() }
        )),
    }
}

/// How many physiological properties are proved.
fn conformance(conformance: &Conformance) -> String {
    let physical = || conformance.rows.iter().filter(|row| row.is_physical());
    let counted = |verdict: ProofVerdict| physical().filter(|row| row.verdict == verdict).count();
    let proved = counted(ProofVerdict::Proved);
    let verb = if proved == 1 { "is" } else { "are" };
    let mut text =
        format!("{proved} of {} physiological properties {verb} proved", physical().count());
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
