//! Every effect that was tried, and those that were not.

use super::verdict::PROBABILITY;
use super::words::{effect, sentence};
use crate::html::{Column, Html};
use crate::number::optional;
use contract::Diagnosis;
use contract::diagnosis::CandidateEffect;

/// Heading of the section.
pub(super) const HEADING: &str = "What was weighed";

pub(super) fn body(html: &mut Html, diagnosis: &Diagnosis) {
    let mut candidates: Vec<&CandidateEffect> = diagnosis.candidates.iter().collect();
    candidates.sort_by(|a, b| b.gain_nats.total_cmp(&a.gain_nats));
    if candidates.is_empty() {
        html.absent("No effect was tried.");
    }
    html.marked_rows(
        "Every answer that was weighed, by its held-out gain before any of them is in the model (that of a card \
         has those above it in the model); bold: named",
        &candidates,
        |c| diagnosis.effects.iter().any(|named| named.effect == c.effect),
        &[
            ("Effect", Column::Text, &|c| Html::from(effect(&c.effect))),
            ("Gain, nats", Column::Number, &|c| Html::from(optional(c.gain_nats, 1))),
            (&sentence(PROBABILITY), Column::Text, &|c| Html::bar(c.probability)),
        ],
    );
    html.rows(
        "Not tried; nothing is said about these",
        &diagnosis.untried,
        &[
            ("Effect", Column::Text, &|untried| effect(&untried.effect)),
            ("Why not", Column::Text, &|untried| untried.reason.clone()),
        ],
    );
}
