//! What people's residual networks have already absorbed of the gap.

use super::words::{effect, list};
use crate::html::{Column, Html};
use crate::number::{fixed, optional, percent};
use contract::diagnosis::Absorbed;

pub(super) fn body(html: &mut Html, absorbed: &Absorbed) {
    html.paragraph(
        "The same people and days, diagnosed with the population network alone and with each person's \
         residual network added. Evidence that is there without the residual and gone with it was \
         absorbed: the residual does what the effect would do, without its name.",
    );
    let found = list(absorbed.found_without.iter().map(|name| effect(name)));
    html.paragraph(&match absorbed.found_without.is_empty() {
        true => "Without the residual no effect is named.".to_owned(),
        false => format!("Without the residual the answer is {found}."),
    });
    html.marked_rows(
        "Evidence by effect; bold: half or more is gone. No share is given of evidence below \
         4 nats, which is as likely to be chance; a negative share is evidence that grew",
        &absorbed.effects,
        |row| row.share.is_some_and(|share| share >= 0.5),
        &[
            ("Effect", Column::Text, &|row| effect(&row.effect)),
            ("Without residual, nats", Column::Number, &|row| optional(row.evidence_before, 1)),
            ("With residual, nats", Column::Number, &|row| optional(row.evidence_after, 1)),
            ("Absorbed", Column::Number, &|row| percent(row.share)),
        ],
    );
    html.rows(
        "Mean absolute error of free runs on the same days, mg/dL",
        &absorbed.baseline,
        &[
            ("Minutes ahead", Column::Number, &|row| row.minutes.to_string()),
            ("Without residual", Column::Number, &|row| fixed(row.mae_before, 1)),
            ("With residual", Column::Number, &|row| fixed(row.mae_after, 1)),
        ],
    );
}
