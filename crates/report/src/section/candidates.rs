//! Every effect that was tried, and those that were not.

use super::verdict::PROBABILITY;
use super::words::{effect, sentence};
use crate::html::{Column, Html};
use crate::number::optional;
use contract::Diagnosis;

/// Heading of the section.
pub(super) const HEADING: &str = "What was weighed";

pub(super) fn body(html: &mut Html, diagnosis: &Diagnosis) {
    let mut candidates: Vec<_> = diagnosis.candidates.iter().collect();
    candidates.sort_by(|a, b| b.gain_nats.total_cmp(&a.gain_nats));
    if candidates.is_empty() {
        html.absent("No effect was tried.");
    } else {
        let rows = candidates.into_iter().map(|c| {
            let found = diagnosis.effects.iter().any(|named| named.effect == c.effect);
            let (name, gain) = (effect(&c.effect), optional(c.gain_nats, 1));
            (found, vec![Html::from(name), Html::from(gain), Html::bar(c.probability)])
        });
        html.table(
            "Every answer that was weighed, by its held-out gain before any of them is in the model (that of a card \
             has those above it in the model); bold: named",
            &[
                ("Effect", Column::Text),
                ("Gain, nats", Column::Number),
                (&sentence(PROBABILITY), Column::Text),
            ],
            rows.collect(),
        );
    }
    html.rows(
        "Not tried; nothing is said about these",
        &diagnosis.untried,
        &[
            ("Effect", Column::Text, &|untried| effect(&untried.effect)),
            ("Why not", Column::Text, &|untried| untried.reason.clone()),
        ],
    );
}
