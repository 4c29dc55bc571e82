//! How an effect stands to what a diagnosis allows for in every body.

use serde::Serialize;

/// How an effect stands to what a diagnosis allows for in every body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Relations {
    /// What is allowed for in every body and is this effect itself: it is not allowed for where the effect is tested.
    pub is_itself: &'static [Allowance],
    /// Whether plants of different structure show it without having it.
    pub structure: Structure,
    /// What shows it.
    pub shown_by: ShownBy,
}

impl Relations {
    /// Those of most effects: nothing that is allowed for is the effect, no difference of structure mimics it, and
    /// the mean of a filter's innovations shows it.
    pub const USUAL: Self =
        Self { is_itself: &[], structure: Structure::Unlike, shown_by: ShownBy::Innovations };
}

/// What a diagnosis allows for in every body, because bodies and plants differ in it without any effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Allowance {
    /// A flux of glucose with a pattern over the day.
    Clock,
    /// A flux against low glucose.
    Defence,
    /// A flux against high glucose.
    Shedding,
}

/// Whether plants of different structure show an effect without having it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Structure {
    /// They do not.
    Unlike,
    /// They do, so that the effect needs more evidence.
    Mimics,
    /// They do, and every body has the effect to some degree: it is allowed for beside all other effects.
    Guard,
}

/// What shows an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ShownBy {
    /// The mean of a filter's innovations.
    Innovations,
    /// How fast a sensor follows: the likelihoods of filters with other lags. For an effect that changes
    /// [`Field::SensorLag`](crate::Field::SensorLag) alone, by the same factor in every step.
    SensorLag,
}
