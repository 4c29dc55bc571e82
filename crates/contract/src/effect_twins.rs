//! `effect_twins.json`: twins with named effects as inputs, beside twins without.

use std::collections::BTreeMap;

use crate::{Equivalence, Summary};

/// Every kind of model on held-out windows.
#[apply(strict!)]
pub struct EffectTwins {
    /// `effect-twins/1`.
    pub schema: String,
    /// Effects that are inputs.
    pub effects: Vec<InputEffect>,
    /// Effects that were named and cannot be inputs, with the reason.
    pub left_out: BTreeMap<String, String>,
    /// People judged.
    pub people: usize,
    /// Held-out windows, over all people.
    pub windows: usize,
    /// One entry a kind of model.
    pub kinds: Vec<KindRow>,
    /// Kinds that differ by the effect alone.
    pub comparisons: Vec<KindComparison>,
}

/// An effect that is an input.
#[apply(strict!)]
pub struct InputEffect {
    /// Its name.
    pub effect: String,
    /// Which of its variants is in use.
    pub variant: usize,
    /// Mean amplitude over people; 1 is the published size.
    pub mean_amplitude: f64,
    /// Its evidence on the training days, nats.
    pub gain_nats: f64,
}

/// One kind of model against the sensor.
#[apply(strict!)]
pub struct KindRow {
    /// Its name.
    pub name: String,
    /// Root mean squared error over the windows, mg/dL, over people.
    pub rmse_5h: Summary,
    /// One row an outcome.
    pub rows: Vec<Equivalence>,
}

/// The error of a kind with the effect minus that of a kind without it, over people.
#[apply(strict!)]
pub struct KindComparison {
    /// The kind with the effect.
    pub with: String,
    /// The kind without it.
    pub without: String,
    /// Mean difference, mg/dL; negative where the effect helps.
    pub value: f64,
    /// Lower end of the bootstrap interval, mg/dL.
    pub lower: f64,
    /// Upper end of the bootstrap interval, mg/dL.
    pub upper: f64,
    /// p of the signed-rank test.
    pub p: f64,
}
