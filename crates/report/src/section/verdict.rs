//! The answer, before everything else: four tiles, one sentence, and what speaks against it.

mod how_far;
mod open;
mod others;
mod place;
mod sentence;
mod tiles;

pub(crate) use sentence::sentence;
pub(super) use sentence::why_suspected;
pub(super) use tiles::PROBABILITY;

use super::words::{effect, sentence as capital};
use crate::Inputs;
use crate::html::Html;

/// Family-wise level at which the verdict names a situation.
pub(super) const LEVEL: f64 = 0.05;

/// Title of the page.
pub(super) fn title(inputs: &Inputs) -> String {
    let only_check = inputs.blind_check.is_some() && inputs.diagnosis.is_none();
    match &inputs.outcomes {
        Some(outcomes) => format!("Sim-to-real report: {}", outcomes.cohort),
        None if only_check => "Blind check of the diagnosis".to_owned(),
        None => "Sim-to-real report".to_owned(),
    }
}

/// The tiles and the sentence of a diagnosis, then a sentence for each other question that the inputs
/// answer.
pub(super) fn body(html: &mut Html, inputs: &Inputs) {
    let mut others = others::sentences(inputs).into_iter();
    if let Some(diagnosis) = &inputs.diagnosis {
        tiles::tiles(html, diagnosis, inputs);
        html.paragraph_of("lead", &sentence(diagnosis));
        html.literal("<p class=\"open\"><strong>Not known.</strong> ");
        html.text(&open::open(diagnosis)).literal("</p>\n");
        // Why a name is doubtful, and what has to be known to read the answer.
        let doubted = diagnosis.effects.iter().filter(|found| !found.questioned.is_empty());
        let doubted = doubted.map(|found| {
            let name = capital(&effect(&found.effect));
            format!("{name} is doubtful. {}", found.questioned.join(" "))
        });
        let notes: Vec<String> = doubted.chain(diagnosis.notes.iter().cloned()).collect();
        html.list("<ul class=\"note\">", &notes);
    } else if let Some(first) = others.next() {
        html.paragraph_of("lead", &first);
    } else {
        html.absent(
            "This folder holds no diagnosis, no blind check, no outcomes and no conformance table, so \
             there is no verdict.",
        );
    }
    others.for_each(|paragraph| html.paragraph(&paragraph));
}
