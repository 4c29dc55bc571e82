//! How far the gap shrinks once the effects found are added.

use crate::html::{Column, Html};
use crate::number::{fixed, interval, p_value};
use crate::{Inputs, ReportError};

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
        return Ok(html);
    }
    if !how_far.horizons.is_empty() {
        let rows: Vec<(bool, Vec<String>)> = how_far
            .horizons
            .iter()
            .map(|row| {
                let cells = vec![
                    row.minutes.to_string(),
                    fixed(row.mae_before, 1),
                    fixed(row.mae_after, 1),
                    interval(row.difference, 1),
                ];
                (row.difference.upper < 0.0, cells)
            })
            .collect();
        html.table(
            "Mean absolute error on held-out days, mg/dL; bold: smaller with the effect",
            &[
                ("Min ahead", Column::Number),
                ("Before", Column::Number),
                ("After", Column::Number),
                ("After \u{2212} before (interval over people)", Column::Number),
            ],
            &rows,
        );
    }
    if !how_far.outcomes.is_empty() {
        let rows: Vec<(bool, Vec<String>)> = how_far
            .outcomes
            .iter()
            .map(|row| {
                let cells = vec![
                    row.metric.to_uppercase(),
                    fixed(row.margin, 1),
                    p_value(row.p_before),
                    p_value(row.p_after),
                ];
                (row.p_after < 0.05 && row.p_before >= 0.05, cells)
            })
            .collect();
        html.table(
            "Equivalence of outcomes (p of the paired two one-sided tests); bold: becomes equivalent",
            &[
                ("Outcome", Column::Text),
                ("Margin", Column::Number),
                ("p before", Column::Number),
                ("p after", Column::Number),
            ],
            &rows,
        );
    }
    Ok(html)
}
