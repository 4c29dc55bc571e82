//! What an effect is, in words and numbers.

use serde::Serialize;

use crate::effect_id::EffectId;
use crate::port::Port;
use crate::relations::Relations;

/// A channel that signals an effect. Without it the effect is not tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Channel {
    /// The clock: always there.
    Clock,
    /// Logged carbohydrate.
    Carbs,
    /// Heart rate or steps.
    Activity,
    /// Sleep.
    Sleep,
    /// Logged infusion set changes.
    SetChange,
    /// Filtered glucose.
    Glucose,
    /// Insulin doses.
    Insulin,
}

/// Prior of an effect's amplitude: log-normal between people.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Prior {
    /// Median amplitude; 1 is the published size.
    pub median: f64,
    /// Standard deviation of the logarithm between people.
    pub log_sd: f64,
    /// Largest amplitude that is believed.
    pub largest: f64,
}

/// An effect's card.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Card {
    /// Which effect it is of, with the name that files use.
    #[serde(rename = "name")]
    pub id: EffectId,
    /// Where it enters.
    pub port: Port,
    /// What it is, in one sentence.
    pub summary: &'static str,
    /// What an amplitude of 1 means, with its unit.
    pub size_at_one: &'static str,
    /// Where form and size come from.
    pub source: &'static str,
    /// What the residuals show when a model lacks it.
    pub signature: &'static str,
    /// The channels that signal it.
    pub channels: &'static [Channel],
    /// Effects that are easily mistaken for it.
    pub confusable_with: &'static [EffectId],
    /// How it stands to what is allowed for in every body.
    pub relations: Relations,
    /// Prior of the amplitude.
    pub prior: Prior,
}
