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
        "Expected calibration error {error}{interval}, over {} stated probabilities. As many that come true \
         as often as they say would have {} in the mean.",
        reliability.probabilities,
        optional(reliability.error_if_calibrated, 3)
    ));
    html.figure(
        figure::reliability(&reliability.bins)?,
        "Stated probability against the share that came true. On the dashed line, \u{201c}80 \
         %\u{201d} is true four times in five; below it the diagnosis is too sure of itself.",
    );
    html.rows(
        "Probabilities of about one size",
        &reliability.bins,
        |_| false,
        &[
            ("Stated, mean", Column::Number, &|bin| percent(bin.mean_probability)),
            ("Came true (95 % interval)", Column::Number, &|bin| share(&bin.came_true)),
        ],
    );
    Ok(html)
}
