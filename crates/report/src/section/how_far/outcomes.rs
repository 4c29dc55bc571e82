//! Equivalence of glucose outcomes before and after.

use super::super::words::metric;
use crate::html::{Column, Html};
use crate::number::{fixed, p_value};
use contract::diagnosis::OutcomeChange;

/// Level of the equivalence tests.
const LEVEL: f64 = 0.05;

pub(super) fn table(html: &mut Html, changes: &[OutcomeChange]) {
    if changes.is_empty() {
        return;
    }
    let equivalent = |p: f64| p < LEVEL;
    let rows: Vec<(bool, Vec<String>)> = changes
        .iter()
        .map(|row| {
            let (before, after) = (equivalent(row.p_before), equivalent(row.p_after));
            let words = match (before, after) {
                (false, true) => "becomes equivalent",
                (true, false) => "no longer equivalent",
                (true, true) => "equivalent, as before",
                (false, false) => "not shown, as before",
            };
            let cells = vec![
                metric(&row.metric),
                words.to_owned(),
                p_value(row.p_before),
                p_value(row.p_after),
                fixed(row.margin, 1),
                fixed(row.difference_before, 2),
                fixed(row.difference_after, 2),
            ];
            (before != after, cells)
        })
        .collect();
    html.table(
        "Equivalence of the model's outcomes with those of the records (p of the two one-sided tests; below 0.05: \
         equivalent within the margin); bold: changes",
        &[
            ("Outcome", Column::Text),
            ("In words", Column::Text),
            ("p before", Column::Number),
            ("p after", Column::Number),
            ("Margin, in the outcome's unit", Column::Number),
            ("Simulated \u{2212} measured, before", Column::Number),
            ("Simulated \u{2212} measured, after", Column::Number),
        ],
        &rows,
    );
}
