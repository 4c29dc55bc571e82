//! The answer in sentences, before anything else.

use super::words::{list, plain, sentence, situation};
use crate::Inputs;
use crate::html::Html;
use crate::number::{count, fixed, p_value};
use crate::view::{CellGap, Conformance, Diagnosis, DiagnosisVerdict, Outcomes, Verdict};

/// Family-wise level at which a situation is named in the verdict.
pub(super) const LEVEL: f64 = 0.05;

/// Title of the page.
pub(super) fn title(inputs: &Inputs) -> String {
    match &inputs.outcomes {
        Some(outcomes) => format!("Sim-to-real report: {}", outcomes.cohort),
        None => "Sim-to-real report".to_owned(),
    }
}

/// One sentence for each question that the inputs answer.
pub(super) fn body(inputs: &Inputs) -> Html {
    let mut html = Html::default();
    let sentences: Vec<String> = [
        inputs.diagnosis.as_ref().map(diagnosis),
        inputs.outcomes.as_ref().map(outcomes),
        inputs.conformance.as_ref().map(conformance),
    ]
    .into_iter()
    .flatten()
    .collect();
    html.literal("<div class=\"verdict\">\n");
    if sentences.is_empty() {
        html.absent("This folder holds no diagnosis, no outcomes and no conformance table, so there is no verdict.");
    }
    for sentence in &sentences {
        html.paragraph(sentence);
    }
    html.literal("</div>\n");
    html
}

/// Where the gap is, and what explains it.
fn diagnosis(diagnosis: &Diagnosis) -> String {
    match diagnosis.verdict {
        DiagnosisVerdict::None => {
            "No situation shows a gap between simulated and real glucose that these data can tell \
             from none."
                .to_owned()
        }
        DiagnosisVerdict::Unknown if diagnosis.sought_effects() => {
            format!("{} None of the effects tried explains it.", place(diagnosis))
        }
        DiagnosisVerdict::Unknown => {
            format!("{} Naming the effect is not part of this run.", place(diagnosis))
        }
        DiagnosisVerdict::Effect => {
            let named: Vec<String> = diagnosis
                .effects
                .iter()
                .map(|e| format!("{} (probability {})", plain(&e.effect), fixed(e.probability, 2)))
                .collect();
            let verb = if named.len() == 1 { "explains" } else { "explain" };
            let mut text = place(diagnosis);
            if !named.is_empty() {
                text.push_str(&format!(" {} {verb} it.", sentence(&list(&named))));
            }
            if let Some(change) =
                diagnosis.how_far.iter().flat_map(|h| &h.horizons).max_by_key(|h| h.minutes)
            {
                text.push_str(&format!(
                    " With it, the mean absolute error {} min ahead goes from {} to {} mg/dL.",
                    change.minutes,
                    fixed(change.mae_before, 1),
                    fixed(change.mae_after, 1)
                ));
            }
            text
        }
    }
}

/// The largest gap that stands out. People and horizons are left to their tables.
fn place(diagnosis: &Diagnosis) -> String {
    let worst = diagnosis
        .cells
        .iter()
        .filter(|cell| cell.p_adjusted < LEVEL)
        .filter(|cell| matches!(cell.factor.as_str(), "hour" | "context" | "glucose_band"))
        .max_by(|a, b| a.share_of_gap.total_cmp(&b.share_of_gap));
    match worst {
        Some(cell) => format!("{}.", gap(cell)),
        None => "There is a gap between simulated and real glucose.".to_owned(),
    }
}

/// One gap in words.
fn gap(cell: &CellGap) -> String {
    // The step-down p can be small where the single-step interval still reaches across zero, so the
    // ends keep their signs, seen in the direction of the error.
    let (direction, size, lower, upper) = if cell.mean_error_mg_dl > 0.0 {
        ("under", cell.mean_error_mg_dl, cell.lower, cell.upper)
    } else {
        ("over", -cell.mean_error_mg_dl, -cell.upper, -cell.lower)
    };
    let horizon = cell.horizon_minutes.map_or_else(String::new, |m| format!(", {m} min ahead"));
    format!(
        "Glucose is {direction}-predicted by {} mg/dL {}{horizon} (simultaneous interval {} to {}, \
         adjusted p {})",
        fixed(size, 0),
        situation(&cell.factor, &cell.level),
        fixed(lower, 0),
        fixed(upper, 0),
        p_value(cell.p_adjusted)
    )
}

/// Equivalence of the first method.
fn outcomes(outcomes: &Outcomes) -> String {
    let Some(method) = outcomes.methods.first() else {
        return "No method was evaluated against the real glucose outcomes.".to_owned();
    };
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
    let method = &method.label;
    match (shown.is_empty(), open.is_empty()) {
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
    }
}

/// How many physiological properties are proved.
fn conformance(conformance: &Conformance) -> String {
    let physical = || conformance.rows.iter().filter(|row| row.is_physical());
    let counted = |verdict: Verdict| physical().filter(|row| row.verdict == verdict).count();
    let proved = counted(Verdict::Proved);
    let verb = if proved == 1 { "is" } else { "are" };
    let mut text =
        format!("{proved} of {} physiological properties {verb} proved", physical().count());
    for (verdict, word) in [(Verdict::Violated, "violated"), (Verdict::Undecided, "undecided")] {
        let n = counted(verdict);
        if n > 0 {
            text.push_str(&format!(", {n} {word}"));
        }
    }
    text.push('.');
    text
}
