//! What people's residual networks have already absorbed of the gap.

use super::words::{effect, list};
use crate::ReportError;
use crate::html::{Column, Html};
use crate::number::{ABSENT, fixed, optional, percent};
use contract::diagnosis::Absorbed;

pub(super) fn body(absorbed: &Absorbed) -> Result<Html, ReportError> {
    let mut html = Html::default();
    html.paragraph(
        "The same people and days, diagnosed with the population network alone and with each person's \
         residual network added. Evidence that is there without the residual and gone with it was \
         absorbed: the residual does what the effect would do, without its name.",
    );
    html.paragraph(&without(absorbed));
    let rows: Vec<(bool, Vec<String>)> = absorbed
        .effects
        .iter()
        .map(|row| {
            let cells = vec![
                effect(&row.effect),
                optional(row.evidence_before, 1),
                optional(row.evidence_after, 1),
                row.share.map_or_else(|| ABSENT.to_owned(), percent),
            ];
            (row.share.is_some_and(|share| share >= 0.5), cells)
        })
        .collect();
    if !rows.is_empty() {
        html.table(
            "Evidence by effect; bold: half or more is gone. No share is given of evidence below \
             4 nats, which is as likely to be chance; a negative share is evidence that grew",
            &[
                ("Effect", Column::Text),
                ("Without residual, nats", Column::Number),
                ("With residual, nats", Column::Number),
                ("Absorbed", Column::Number),
            ],
            &rows,
        );
    }
    let rows: Vec<(bool, Vec<String>)> = absorbed
        .baseline
        .iter()
        .map(|row| {
            let minutes = row.minutes.to_string();
            (false, vec![minutes, fixed(row.mae_before, 1), fixed(row.mae_after, 1)])
        })
        .collect();
    if !rows.is_empty() {
        html.table(
            "Mean absolute error of free runs on the same days, mg/dL",
            &[
                ("Minutes ahead", Column::Number),
                ("Without residual", Column::Number),
                ("With residual", Column::Number),
            ],
            &rows,
        );
    }
    Ok(html)
}

fn without(absorbed: &Absorbed) -> String {
    let found: Vec<String> = absorbed.found_without.iter().map(|name| effect(name)).collect();
    if found.is_empty() {
        "Without the residual no effect is named.".to_owned()
    } else {
        format!("Without the residual the answer is {}.", list(&found))
    }
}
