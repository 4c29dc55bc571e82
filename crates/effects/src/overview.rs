//! The library as a document.

use crate::card::{Card, Channel};
use crate::effect::Effect;

impl Channel {
    /// What the channel is, in words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Clock => "clock",
            Self::Carbs => "logged carbohydrate",
            Self::Activity => "heart rate or steps",
            Self::Sleep => "sleep",
            Self::SetChange => "set changes (guessed where not logged)",
            Self::Glucose => "glucose",
            Self::Insulin => "insulin",
        }
    }
}

/// Cards of effects as Markdown: a table of all, then a paragraph on each.
///
/// `docs/effects.md` is this of [`library()`](crate::library()).
#[must_use]
pub fn overview(effects: &[Box<dyn Effect>]) -> String {
    let mut text = String::from(
        "# The library of effects\n\n\
         What a glucose model may be missing: where it enters, what an amplitude of 1 means, what it does to\n\
         the residuals, and what it is mistaken for. One file each in `crates/effects/src/library/`. This page\n\
         is printed by `cargo run -p effects --example table`; a test compares the two.\n\n\
         Amplitudes are log-normal between people, with median 1 (the published size). *Shapes* are the\n\
         alternatives of which one is chosen on training days.\n\n\
         | effect | port | signalled by | shapes | spread (log) | largest | confusable with |\n\
         |---|---|---|---|---|---|---|\n",
    );
    for effect in effects {
        let card = effect.card();
        let channels: Vec<&str> = card.channels.iter().map(|channel| channel.words()).collect();
        let confusable: Vec<String> =
            card.confusable_with.iter().map(|id| format!("`{id}`")).collect();
        text += &format!(
            "| `{}` | `{}` | {} | {} | {} | {} | {} |\n",
            card.id,
            card.port.name(),
            channels.join(", "),
            effect.variants(),
            card.prior.log_sd,
            card.prior.largest,
            confusable.join(", "),
        );
    }
    for effect in effects {
        text += &format!("\n{}\n", effect.card().in_words().trim_end());
    }
    text
}

impl Card {
    /// The card as Markdown: a heading, what the effect is, its size, its signature and its source.
    #[must_use]
    pub fn in_words(&self) -> String {
        let Self { id, summary, size_at_one, signature, source, .. } = self;
        let summary = capitalised(summary);
        format!(
            "## `{id}`\n\n{summary}.\n\n- At amplitude 1: {size_at_one}.\n\
             - Residuals of a model without it: {signature}.\n- Source: {source}.\n"
        )
    }
}

/// With a capital first letter.
fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::library::library;

    #[test]
    fn every_effect_has_its_row_and_its_paragraph() {
        let effects = library();
        let text = overview(&effects);
        for effect in &effects {
            let name = effect.card().id;
            assert!(text.contains(&format!("| `{name}` | `{}` |", effect.card().port.name())));
            assert!(text.contains(&format!("\n## `{name}`\n")));
        }
    }
}
