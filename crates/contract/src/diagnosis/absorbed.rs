//! What residual networks of twins have absorbed.

use serde::{Deserialize, Serialize};

use super::Verdict;

/// What residual networks have absorbed, all people together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Absorbed {
    /// The plant without the residual.
    pub without: String,
    /// Its verdict on the same people and days.
    pub verdict_without: Verdict,
    /// The effects named for it.
    pub found_without: Vec<String>,
    /// Evidence by effect, most before first.
    pub effects: Vec<AbsorbedEffect>,
    /// Errors of both plants, one entry a horizon.
    pub baseline: Vec<AbsorbedError>,
}

/// The evidence for an effect with both plants, before any effect is conditioned on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct AbsorbedEffect {
    /// The effect.
    pub effect: String,
    /// Held-out evidence that the plant without the residual lacks it, nats.
    pub evidence_before: f64,
    /// The same with the residual, nats.
    pub evidence_after: f64,
    /// Share of the evidence that is gone; negative where it grew. `None` below 4 nats before.
    pub share: Option<f64>,
}

/// Free-run error of both plants at one horizon: mean over people, mg/dL.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct AbsorbedError {
    /// Horizon, min.
    pub minutes: u32,
    /// Mean absolute error without the residual.
    pub mae_before: f64,
    /// Mean absolute error with it.
    pub mae_after: f64,
}
