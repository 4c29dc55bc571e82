//! The six outcomes of every method with margins and tests, and forecast errors.

use crate::figure::equivalence;
use crate::html::{Column, Html};
use crate::number::{ABSENT, count, fixed, interval, p_value, spread};
use crate::view::Outcomes;
use crate::{Inputs, ReportError};

pub(super) fn body(inputs: &Inputs) -> Result<Html, ReportError> {
    let mut html = Html::default();
    let Some(outcomes) = &inputs.outcomes else {
        html.absent("There are no outcomes in this folder, so no method was evaluated.");
        return Ok(html);
    };
    html.paragraph(&format!(
        "{} and {} of {} min, outcomes averaged over the windows of each person. Equivalence is \
         concluded where both one-sided paired t-tests reject at 0.05.",
        count(outcomes.people, "person", "people"),
        count(outcomes.windows, "window", "windows"),
        outcomes.window_minutes
    ));
    match equivalence(&outcomes.methods)? {
        Some((svg, keys)) => {
            html.figure(
                &svg,
                &keys,
                "Simulated minus actual with 90 % intervals, in units of the equivalence margin. An \
                 outcome is equivalent where the whole interval lies in the shaded band. Values \
                 beyond four margins are drawn at the edge; the table has them in full.",
            );
        }
        None => {
            html.absent("No outcome was tested.");
        }
    }
    for method in &outcomes.methods {
        let rows: Vec<(bool, Vec<String>)> = method
            .rows
            .iter()
            .map(|row| {
                let digits = if row.margin < 2.0 { 2 } else { 1 };
                let name = row.metric.to_uppercase();
                let cells = vec![
                    if row.unit.is_empty() { name } else { format!("{name} ({})", row.unit) },
                    spread(row.actual, digits),
                    spread(row.simulated, digits),
                    interval(row.difference, digits),
                    format!("\u{b1}{}", fixed(row.margin, usize::from(row.margin.fract() != 0.0))),
                    p_value(row.p),
                    if row.equivalent { "yes" } else { "not shown" }.to_owned(),
                ];
                (row.equivalent, cells)
            })
            .collect();
        html.table(
            &format!("{}: mean \u{b1} SD over people; bold: equivalent", method.label),
            &[
                ("Outcome", Column::Text),
                ("Actual", Column::Number),
                ("Simulated", Column::Number),
                ("Difference (90 % interval)", Column::Number),
                ("Margin", Column::Number),
                ("p (TOST)", Column::Number),
                ("Equivalent", Column::Text),
            ],
            &rows,
        );
    }
    forecast(&mut html, outcomes);
    comparisons(&mut html, outcomes);
    Ok(html)
}

/// Forecast errors: methods down, horizons across.
fn forecast(html: &mut Html, outcomes: &Outcomes) {
    if outcomes.forecast.is_empty() {
        html.absent("No forecast was evaluated.");
        return;
    }
    let mut horizons: Vec<u32> = outcomes.forecast.iter().map(|row| row.minutes).collect();
    horizons.sort_unstable();
    horizons.dedup();
    let mut methods: Vec<&str> = Vec::new();
    for row in &outcomes.forecast {
        if !methods.contains(&row.method.as_str()) {
            methods.push(&row.method);
        }
    }
    let rows: Vec<(bool, Vec<String>)> = methods
        .into_iter()
        .map(|method| {
            let mut cells = vec![label(outcomes, method)];
            cells.extend(horizons.iter().map(|minutes| {
                let found = outcomes
                    .forecast
                    .iter()
                    .find(|row| row.method == method && row.minutes == *minutes);
                found.map_or_else(|| ABSENT.to_owned(), |row| spread(row.rmse, 1))
            }));
            (false, cells)
        })
        .collect();
    let titles: Vec<String> = horizons.iter().map(|m| format!("{m} min")).collect();
    let mut columns = vec![("Method", Column::Text)];
    columns.extend(titles.iter().map(|title| (title.as_str(), Column::Number)));
    html.table("Forecast RMSE, mg/dL, mean \u{b1} SD over people", &columns, &rows);
}

/// Two methods within people.
fn comparisons(html: &mut Html, outcomes: &Outcomes) {
    if outcomes.comparisons.is_empty() {
        return;
    }
    let rows: Vec<(bool, Vec<String>)> = outcomes
        .comparisons
        .iter()
        .map(|row| {
            let cells = vec![
                format!("{} ({})", row.quantity, row.unit),
                label(outcomes, &row.first),
                label(outcomes, &row.second),
                interval(row.difference, 1),
                row.p.map_or_else(|| ABSENT.to_owned(), p_value),
            ];
            (row.difference.upper < 0.0 || row.difference.lower > 0.0, cells)
        })
        .collect();
    let level = outcomes
        .interval
        .as_ref()
        .map_or_else(String::new, |interval| format!("{} % ", fixed(100.0 * interval.level, 0)));
    html.table(
        "Methods compared within people; bold: the interval leaves out zero",
        &[
            ("Quantity", Column::Text),
            ("First", Column::Text),
            ("Second", Column::Text),
            (&format!("First \u{2212} second ({level}interval)"), Column::Number),
            ("p (signed rank)", Column::Number),
        ],
        &rows,
    );
}

/// Name of a method for people, or its key where it is not among the methods.
fn label(outcomes: &Outcomes, name: &str) -> String {
    let known = outcomes.methods.iter().find(|method| method.name == name);
    known.map_or_else(|| name.to_owned(), |method| method.label.clone())
}
