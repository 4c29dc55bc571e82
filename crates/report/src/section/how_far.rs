//! How far the gap shrinks once the effects found are added.

mod before_after;
mod people;

use super::words::{ahead, effect, metric, sentence};
use crate::figure::{ForestFrame, ForestRow, forest};
use crate::html::{Column, Html};
use crate::number::{fixed, interval, optional, p_value, percent};
use contract::Diagnosis;
use contract::diagnosis::{HorizonChange, HowFar, OutcomeChange};

/// Marks a figure that depends on events inferred from the very readings to be predicted.
const RECONSTRUCTED: &str = " (reconstructed)";
/// Level of the equivalence tests.
const LEVEL: f64 = 0.05;

pub(super) fn body(html: &mut Html, diagnosis: &Diagnosis) {
    let how_far = &diagnosis.how_far;
    if how_far.horizons.is_empty() && how_far.outcomes.is_empty() {
        html.absent(
            "No effect was added to the model in this run, so there is no before and after.",
        );
    }
    horizons(html, &how_far.horizons);
    outcomes(html, &how_far.outcomes);
    html.rows(
        "Size of the effects as fitted on training days (1 = published)",
        &how_far.amplitudes,
        &[
            ("Effect", Column::Text, &|row| effect(&row.effect)),
            ("Mean over people (interval)", Column::Number, &|row| interval(row.mean, 2)),
            ("SD between people", Column::Number, &|row| fixed(row.sd, 2)),
        ],
    );
    if let Some(innovations) = &how_far.innovations {
        html.paragraph(&format!(
            "The log-likelihood of a held-out day's readings, each predicted from those before it, \
             changes by {} nats.",
            interval(innovations.difference, 1)
        ));
    }
    people::body(html, how_far);
    notes(html, how_far);
}

/// Name of a row in a figure.
fn name(row: &HorizonChange) -> String {
    let mark = if row.reconstructed { "*" } else { "" };
    format!("{}{mark}", ahead(row.minutes))
}

/// The error of a perfect model, unless an error was measured that is smaller: then it is no floor.
fn floor(row: &HorizonChange) -> Option<f64> {
    row.floor.filter(|floor| *floor <= row.mae_before.min(row.mae_after))
}

fn horizons(html: &mut Html, changes: &[HorizonChange]) {
    html.figure(
        before_after::figure(changes),
        "Mean absolute error on days that were held out. The lower bar is shorter where the effects \
         help. Bars with * know the events: they are no forecast.",
    );
    let row = |row: &HorizonChange| {
        let value = row.difference;
        let stands_out = value.upper < 0.0 || value.lower > 0.0;
        ForestRow { label: name(row), value, stands_out }
    };
    let frame = ForestFrame::around_zero(
        "Change of the held-out error by horizon",
        "After \u{2212} before (mg/dL)",
    );
    html.figure(
        forest(&frame, &changes.iter().map(row).collect::<Vec<_>>()),
        "Change of that error with its interval over people. Left of the dashed line the error \
         is smaller with the effects.",
    );
    html.marked_rows(
        "Mean absolute error on held-out days, mg/dL; bold: smaller with the effects",
        changes,
        |row| row.difference.upper < 0.0,
        &[
            ("Ahead", Column::Text, &|row| {
                let mark = if row.reconstructed { RECONSTRUCTED } else { "" };
                format!("{}{mark}", ahead(row.minutes))
            }),
            ("Before", Column::Number, &|row| fixed(row.mae_before, 1)),
            ("After", Column::Number, &|row| fixed(row.mae_after, 1)),
            ("After \u{2212} before (interval over people)", Column::Number, &|row| {
                interval(row.difference, 1)
            }),
            ("Perfect model", Column::Number, &|row| optional(floor(row), 1)),
            ("Excess removed", Column::Number, &|row| {
                percent(floor(row).and(row.share_above_floor).map(|share| share.value))
            }),
            ("People", Column::Number, &|row| row.people.to_string()),
            ("Runs", Column::Number, &|row| row.runs.to_string()),
        ],
    );
}

/// Equivalence of glucose outcomes before and after.
fn outcomes(html: &mut Html, changes: &[OutcomeChange]) {
    let equivalent = |row: &OutcomeChange| (row.p_before < LEVEL, row.p_after < LEVEL);
    let words = |row: &OutcomeChange| match equivalent(row) {
        (false, true) => "becomes equivalent",
        (true, false) => "no longer equivalent",
        (true, true) => "equivalent, as before",
        (false, false) => "not shown, as before",
    };
    html.marked_rows(
        "Equivalence of the model's outcomes with those of the records (p of the two one-sided tests; below 0.05: \
         equivalent within the margin); bold: changes",
        changes,
        |row| equivalent(row).0 != equivalent(row).1,
        &[
            ("Outcome", Column::Text, &|row| metric(&row.metric)),
            ("In words", Column::Text, &|row| words(row).to_owned()),
            ("p before", Column::Number, &|row| p_value(row.p_before)),
            ("p after", Column::Number, &|row| p_value(row.p_after)),
            ("Margin, in the outcome's unit", Column::Number, &|row| fixed(row.margin, 1)),
            ("Simulated \u{2212} measured, before", Column::Number, &|row| {
                fixed(row.difference_before, 2)
            }),
            ("Simulated \u{2212} measured, after", Column::Number, &|row| {
                fixed(row.difference_after, 2)
            }),
        ],
    );
}

/// A note with the keys of effects in words.
fn in_words(note: &str) -> String {
    let word = |text: &str| {
        let key = text.trim_end_matches([',', '.', ';', ':']);
        match key.contains('_') {
            true => format!("{}{}", effect(key), &text[key.len()..]),
            false => text.to_owned(),
        }
    };
    let text = note.split(' ').map(word).collect::<Vec<_>>().join(" ");
    let begins_with_key = note.split(' ').next().is_some_and(|first| first.contains('_'));
    let end = if note.ends_with('.') { "" } else { "." };
    format!("{}{end}", if begins_with_key { sentence(&text) } else { text })
}

fn notes(html: &mut Html, how_far: &HowFar) {
    let mut notes: Vec<String> = how_far.notes.iter().map(|note| in_words(note)).collect();
    let any = |is: fn(&HorizonChange) -> bool| how_far.horizons.iter().any(is);
    for (applies, note) in [
        (
            any(|row| row.floor.is_some() && floor(row).is_none()),
            "Where a perfect model would leave more error than was measured, the bound is wrong and is \
             not shown: the filter assumes more noise than these data have.",
        ),
        (
            any(|row| floor(row).and(row.share_above_floor).is_some()),
            "Excess: the error before above that of a perfect model. The latter is a bound under the \
             noise that the filter assumes, not a measurement.",
        ),
        (
            any(|row| row.reconstructed),
            "Rows marked as reconstructed (* in figures) use events that were inferred from the \
             held-out readings themselves. They are no prediction: they say what knowing the events \
             would remove.",
        ),
    ] {
        notes.extend(applies.then(|| note.to_owned()));
    }
    html.list("<ul class=\"note\">", &notes);
}
