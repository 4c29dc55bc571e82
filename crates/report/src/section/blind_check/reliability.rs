//! Whether stated probabilities come true.

use crate::html::{Column, Html};
use crate::number::{optional, percent, share};
use crate::{ReportError, figure};
use contract::BlindCheck;

pub(in super::super) fn body(check: &BlindCheck) -> Result<Html, ReportError> {
    let mut html = Html::default();
    let reliability = &check.reliability;
    if reliability.bins.is_empty() {
        html.absent("No probability was stated.");
        return Ok(html);
    }
    let error = optional(reliability.expected_calibration_error, 3);
    let interval = match (reliability.lower, reliability.upper) {
        (lower @ Some(_), upper @ Some(_)) => {
            format!(" (95 % interval {} to {})", optional(lower, 3), optional(upper, 3))
        }
        _ => String::new(),
    };
    html.paragraph(&format!(
        "Expected calibration error {error}{interval}, over {} stated probabilities.",
        reliability.probabilities
    ));
    html.figure(
        figure::reliability(&reliability.bins)?,
        "Stated probability against the share that came true. On the dashed line, \u{201c}80 \
         %\u{201d} is true four times in five; below it the diagnosis is too sure of itself.",
    );
    let rows: Vec<(bool, Vec<String>)> = reliability
        .bins
        .iter()
        .map(|bin| (false, vec![percent(bin.mean_probability), share(&bin.came_true)]))
        .collect();
    html.table(
        "Probabilities of about one size",
        &[("Stated, mean", Column::Number), ("Came true (95 % interval)", Column::Number)],
        &rows,
    );
    Ok(html)
}
