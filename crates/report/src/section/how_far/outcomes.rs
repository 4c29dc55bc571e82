//! Equivalence of glucose outcomes before and after.

use super::RECONSTRUCTED;
use crate::html::{Column, Html};
use crate::number::{optional, p_value};
use crate::view::OutcomeChange;

/// Level of the equivalence tests.
const LEVEL: f64 = 0.05;

pub(super) fn table(html: &mut Html, changes: &[OutcomeChange]) {
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
                words.to_owned(),
                p(row.p_before),
                p(row.p_after),
                optional(row.margin, 1),
                optional(row.difference_before, 2),
                optional(row.difference_after, 2),
            ];
            (before != after, cells)
        })
        .collect();
    html.table(
        "Equivalence of simulated and real outcomes (p of the two one-sided tests; below 0.05: \
         equivalent within the margin); bold: changes",
        &[
            ("Outcome", Column::Text),
            ("In words", Column::Text),
            ("p before", Column::Number),
            ("p after", Column::Number),
            ("Margin", Column::Number),
            ("Simulated \u{2212} real before", Column::Number),
            ("after", Column::Number),
        ],
        &rows,
    );
}
