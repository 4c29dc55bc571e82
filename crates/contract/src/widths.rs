//! `widths.json`: a search for the hidden widths of the ten networks.

use std::collections::BTreeMap;

/// A search and its best widths.
#[apply(strict!)]
pub struct WidthSearch {
    /// The widths with the least error.
    pub best: BestWidths,
    /// The settings.
    pub config: serde_json::Value,
    /// SHA-256 of the windows, hexadecimal.
    pub data_sha256: String,
    /// Trials that explore before any is proposed.
    pub explore: usize,
    /// Names of the networks, in the order of the widths of a trial.
    pub networks: Vec<String>,
    /// `widths/1`.
    pub schema: String,
    /// Every trial, in order.
    pub trials: Vec<Trial>,
}

/// Widths with the least error.
#[apply(strict!)]
pub struct BestWidths {
    /// Balanced error on the validation windows, mg/dL.
    pub balanced_error_mg_dl: Option<f64>,
    /// Hidden units by network.
    pub widths: BTreeMap<String, usize>,
}

/// Widths that were tried.
#[apply(strict!)]
pub struct Trial {
    /// Balanced error, mg/dL; null if training broke off.
    pub error: Option<f64>,
    /// Hidden units of each network, in the order of `networks`.
    pub widths: [usize; 10],
}
