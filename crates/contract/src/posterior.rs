//! `working.json` and `names.json`: what a posterior is trained on.

use serde::{Deserialize, Serialize};

/// What a posterior was trained on: `working.json`, and `without-HAND.json` of the one that has not seen a hand.
#[apply(strict!)]
pub struct PosteriorCard {
    /// The command that trained it.
    pub source: String,
    /// Hands whose worlds it saw, with the number of worlds.
    pub hands: Vec<(String, usize)>,
    /// Share of the worlds in which nothing is missing: its prior.
    pub nothing: f64,
    /// Networks of the ensemble; the regressions are one more member.
    pub members: usize,
    /// Added to the log odds that nothing is missing, so that "nothing" is stated as often as it is true, in the mean of
    /// hands left out.
    pub offset: f64,
    /// Probability from which on something is said to be missing: at most one in twenty worlds in which nothing is
    /// missing reaches it, in the mean of hands left out.
    pub speaks_from: f64,
}

/// Names of the statistics of a table of evidence, in the order of its columns.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct StatisticNames(pub Vec<String>);
