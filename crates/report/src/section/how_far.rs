//! How far the gap shrinks once the effects found are added.

mod outcomes;
mod people;

use super::words::{ahead, effect, sentence};
use crate::ReportError;
use crate::figure::{Bars, ForestFrame, ForestRow, before_after, forest};
use crate::html::{Column, Html};
use crate::number::{ABSENT, fixed, interval, optional, percent};
use contract::Diagnosis;
use contract::diagnosis::{HorizonChange, HowFar};

/// Marks a figure that depends on events inferred from the very readings to be predicted.
const RECONSTRUCTED: &str = " (reconstructed)";

pub(super) fn body(diagnosis: &Diagnosis) -> Result<Html, ReportError> {
    let mut html = Html::default();
    let how_far = &diagnosis.how_far;
    if how_far.horizons.is_empty() && how_far.outcomes.is_empty() {
        html.absent(
            "No effect was added to the model in this run, so there is no before and after.",
        );
    }
    horizons(&mut html, &how_far.horizons)?;
    outcomes::table(&mut html, &how_far.outcomes);
    fits(&mut html, how_far);
    people::body(&mut html, how_far)?;
    notes(&mut html, how_far);
    Ok(html)
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

fn horizons(html: &mut Html, changes: &[HorizonChange]) -> Result<(), ReportError> {
    if changes.is_empty() {
        return Ok(());
    }
    let bars: Vec<Bars<'_>> = changes.iter().map(|row| (name(row), row, floor(row))).collect();
    html.figure(
        before_after(&bars)?,
        "Mean absolute error on days that were held out. The lower bar is shorter where the effects \
         help. Bars with * know the events: they are no forecast.",
    );
    let rows: Vec<ForestRow> = changes
        .iter()
        .map(|row| {
            let value = row.difference;
            let stands_out = value.upper < 0.0 || value.lower > 0.0;
            ForestRow { label: name(row), value, stands_out }
        })
        .collect();
    let frame = ForestFrame::around_zero(
        "Change of the held-out error by horizon",
        "After \u{2212} before (mg/dL)",
    );
    html.figure(
        forest(&frame, &rows)?,
        "Change of that error with its interval over people. Left of the dashed line the error \
         is smaller with the effects.",
    );
    html.rows(
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
                let removed = floor(row).and(row.share_above_floor);
                removed.map_or_else(|| ABSENT.to_owned(), |share| percent(share.value))
            }),
            ("People", Column::Number, &|row| row.people.to_string()),
            ("Runs", Column::Number, &|row| row.runs.to_string()),
        ],
    );
    Ok(())
}

/// What was fitted on training days, and the one-step fit of the days held out.
fn fits(html: &mut Html, how_far: &HowFar) {
    html.rows(
        "Size of the effects as fitted on training days (1 = published)",
        &how_far.amplitudes,
        |_| false,
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
    if how_far.horizons.iter().any(|row| row.floor.is_some() && floor(row).is_none()) {
        notes.push(
            "Where a perfect model would leave more error than was measured, the bound is wrong and is \
             not shown: the filter assumes more noise than these data have."
                .to_owned(),
        );
    }
    if how_far.horizons.iter().any(|row| floor(row).and(row.share_above_floor).is_some()) {
        notes.push(
            "Excess: the error before above that of a perfect model. The latter is a bound under the \
             noise that the filter assumes, not a measurement."
                .to_owned(),
        );
    }
    if how_far.horizons.iter().any(|row| row.reconstructed) {
        notes.push(
            "Rows marked as reconstructed (* in figures) use events that were inferred from the \
             held-out readings themselves. They are no prediction: they say what knowing the events \
             would remove."
                .to_owned(),
        );
    }
    html.list("<ul class=\"note\">", &notes);
}
