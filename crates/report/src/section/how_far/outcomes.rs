//! Equivalence of glucose outcomes before and after.

use super::super::words::metric;
use crate::html::{Column, Html};
use crate::number::{fixed, p_value};
use contract::diagnosis::OutcomeChange;

/// Level of the equivalence tests.
const LEVEL: f64 = 0.05;

pub(super) fn table(html: &mut Html, changes: &[OutcomeChange]) {
    let equivalent = |row: &OutcomeChange| (row.p_before < LEVEL, row.p_after < LEVEL);
    let words = |row: &OutcomeChange| match equivalent(row) {
        (false, true) => "becomes equivalent",
        (true, false) => "no longer equivalent",
        (true, true) => "equivalent, as before",
        (false, false) => "not shown, as before",
    };
    let changed = |row: &OutcomeChange| equivalent(row).0 != equivalent(row).1;
    html.rows(
        "Equivalence of the model's outcomes with those of the records (p of the two one-sided tests; below 0.05: \
         equivalent within the margin); bold: changes",
        changes,
        changed,
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
