//! How far the gap shrinks once the effects found are added.

use super::words::ahead;
use crate::figure::{ForestFrame, ForestRow, before_after, forest};
use crate::html::{Column, Html};
use crate::number::{optional, p_value, range};
use crate::view::{HorizonChange, HowFar, OutcomeChange};
use crate::{Inputs, ReportError};

/// Level of the equivalence tests.
const LEVEL: f64 = 0.05;
/// What marks a figure that rests on a reconstructed driver.
const RECONSTRUCTED: &str = " (reconstructed)";

pub(super) fn body(inputs: &Inputs) -> Result<Html, ReportError> {
    let mut html = Html::default();
    let Some(diagnosis) = &inputs.diagnosis else {
        html.absent("There is no diagnosis in this folder, so nothing was added to the model.");
        return Ok(html);
    };
    let how_far = diagnosis.how_far.clone().unwrap_or_default();
    if how_far.horizons.is_empty() && how_far.outcomes.is_empty() {
        html.absent(
            "No effect was added to the model in this run, so there is no before and after.",
        );
    }
    horizons(&mut html, &how_far.horizons)?;
    outcomes(&mut html, &how_far.outcomes);
    notes(&mut html, &how_far);
    Ok(html)
}

fn name(row: &HorizonChange) -> String {
    let mark = if row.reconstructed { "*" } else { "" };
    format!("{}{mark}", ahead(row.minutes))
}

fn horizons(html: &mut Html, changes: &[HorizonChange]) -> Result<(), ReportError> {
    if changes.is_empty() {
        return Ok(());
    }
    let bars: Vec<_> =
        changes.iter().map(|row| (name(row), row.mae_before, row.mae_after)).collect();
    if let Some((svg, keys)) = before_after(&bars)? {
        html.figure(
            &svg,
            &keys,
            "Mean absolute error of forecasts on days that were held out. The lower bar is shorter \
             where the effects help.",
        );
    }
    let rows: Vec<ForestRow> = changes
        .iter()
        .filter_map(|row| {
            let value = row.difference?.whole()?;
            let stands_out = value.upper < 0.0 || value.lower > 0.0;
            Some(ForestRow { label: name(row), value, stands_out })
        })
        .collect();
    let frame = ForestFrame::around_zero(
        "Change of the held-out error by horizon",
        "After \u{2212} before (mg/dL)",
    );
    if let Some((svg, keys)) = forest(&frame, &rows)? {
        html.figure(
            &svg,
            &keys,
            "Change of that error with its interval over people. Left of the dashed line the error \
             is smaller with the effects.",
        );
    }
    let rows: Vec<(bool, Vec<String>)> = changes
        .iter()
        .map(|row| {
            let smaller = row.difference.and_then(|d| d.upper).is_some_and(|upper| upper < 0.0);
            let mark = if row.reconstructed { RECONSTRUCTED } else { "" };
            let cells = vec![
                format!("{}{mark}", ahead(row.minutes)),
                optional(row.mae_before, 1),
                optional(row.mae_after, 1),
                range(row.difference, 1),
            ];
            (smaller, cells)
        })
        .collect();
    html.table(
        "Mean absolute error on held-out days, mg/dL; bold: smaller with the effects",
        &[
            ("Ahead", Column::Text),
            ("Before", Column::Number),
            ("After", Column::Number),
            ("After \u{2212} before (interval over people)", Column::Number),
        ],
        &rows,
    );
    Ok(())
}

fn outcomes(html: &mut Html, changes: &[OutcomeChange]) {
    if changes.is_empty() {
        return;
    }
    let equivalent = |p: Option<f64>| p.is_some_and(|p| p < LEVEL);
    let rows: Vec<(bool, Vec<String>)> = changes
        .iter()
        .map(|row| {
            let (before, after) = (equivalent(row.p_before), equivalent(row.p_after));
            let words = match (row.p_before.is_some() && row.p_after.is_some(), before, after) {
                (false, ..) => "not tested",
                (_, false, true) => "becomes equivalent",
                (_, true, false) => "no longer equivalent",
                (_, true, true) => "equivalent, as before",
                (_, false, false) => "not shown, as before",
            };
            let mark = if row.reconstructed { RECONSTRUCTED } else { "" };
            let p = |p: Option<f64>| p_value(p.unwrap_or(f64::NAN));
            let cells = vec![
                format!("{}{mark}", row.metric.to_uppercase()),
                optional(row.margin, 1),
                p(row.p_before),
                p(row.p_after),
                words.to_owned(),
            ];
            (before != after, cells)
        })
        .collect();
    html.table(
        "Equivalence of simulated and real outcomes (p of the two one-sided tests; below 0.05: \
         equivalent within the margin); bold: changes",
        &[
            ("Outcome", Column::Text),
            ("Margin", Column::Number),
            ("p before", Column::Number),
            ("p after", Column::Number),
            ("In words", Column::Text),
        ],
        &rows,
    );
}

fn notes(html: &mut Html, how_far: &HowFar) {
    let mut notes = how_far.notes.clone();
    let reconstructed = how_far.horizons.iter().any(|row| row.reconstructed)
        || how_far.outcomes.iter().any(|row| row.reconstructed);
    if reconstructed {
        notes.push(
            "Rows marked as reconstructed (* in figures) use events that the record does not hold \
             and that were inferred from the same readings; they say how well the effect describes \
             the data, not how well it forecasts."
                .to_owned(),
        );
    }
    if notes.is_empty() {
        return;
    }
    html.literal("<ul class=\"note\">\n");
    for note in &notes {
        html.element("li", note);
    }
    html.literal("</ul>\n");
}
