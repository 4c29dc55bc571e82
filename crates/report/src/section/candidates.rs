//! Every effect that was tried, and those that were not.

use super::verdict::PROBABILITY;
use super::words::{effect, sentence};
use crate::ReportError;
use crate::html::{Column, Html};
use crate::number::optional;
use contract::Diagnosis;

/// Heading of the section.
pub(super) const HEADING: &str = "What was weighed";

pub(super) fn body(diagnosis: &Diagnosis) -> Result<Html, ReportError> {
    let mut html = Html::default();
    let mut candidates: Vec<_> = diagnosis.candidates.iter().collect();
    candidates.sort_by(|a, b| b.gain_nats.total_cmp(&a.gain_nats));
    if candidates.is_empty() {
        html.absent("No effect was tried.");
    } else {
        let rows: Vec<(bool, Vec<Html>)> = candidates
            .into_iter()
            .map(|c| {
                let found = diagnosis.effects.iter().any(|named| named.effect == c.effect);
                let cells = vec![
                    Html::of_text(&effect(&c.effect)),
                    Html::of_text(&optional(c.gain_nats, 1)),
                    Html::bar(c.probability),
                ];
                (found, cells)
            })
            .collect();
        html.table_of(
            "Every answer that was weighed, by its held-out gain before any of them is in the model (that of a card \
             has those above it in the model); bold: named",
            &[
                ("Effect", Column::Text),
                ("Gain, nats", Column::Number),
                (&sentence(PROBABILITY), Column::Text),
            ],
            &rows,
        );
    }
    html.rows(
        "Not tried; nothing is said about these",
        &diagnosis.untried,
        |_| false,
        &[
            ("Effect", Column::Text, &|untried| effect(&untried.effect)),
            ("Why not", Column::Text, &|untried| untried.reason.clone()),
        ],
    );
    Ok(html)
}
