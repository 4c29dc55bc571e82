//! `repair.json`: what it took to give every network its properties.

use std::collections::BTreeMap;

/// A repair of a model.
#[apply(strict!)]
pub struct Repair {
    /// Balanced error on held-out days, mg/dL.
    pub held_out_balanced_error_mg_dl: BeforeAfter,
    /// What was done to each network.
    pub networks: BTreeMap<String, RepairedNetwork>,
    /// Whether every physical property is proved.
    pub proved: bool,
    /// `repair/1`.
    pub schema: String,
}

/// What was done to one network.
#[apply(strict!)]
pub struct RepairedNetwork {
    /// Whether each unit has the right signs by itself, since no network had a margin on all pieces.
    pub by_unit: bool,
    /// Linear pieces on which a property was asked for.
    pub pieces: usize,
    /// Whether every property of the network is proved.
    pub proved: bool,
    /// Rounds of verification.
    pub rounds: usize,
    /// Mean squared error on training windows; 0 in both where the network was proved as it came.
    pub training_windows_mse: BeforeAfter,
}

/// A number before the repair and after it.
#[apply(strict!)]
#[derive(Copy)]
pub struct BeforeAfter {
    /// After.
    pub after: f64,
    /// Before.
    pub before: f64,
}
