//! Options of `evidence`.

use std::path::PathBuf;

use clap::Args;

/// Options of `evidence`.
#[derive(Debug, Args)]
pub(crate) struct EvidenceArgs {
    /// Worlds in which something is missing.
    #[arg(long, value_name = "N", default_value_t = 252)]
    pub worlds: usize,
    /// Worlds in which nothing is missing.
    #[arg(long, value_name = "N", default_value_t = 150)]
    pub nulls: usize,
    /// Let everyday life vary as little as in the embedded cohort, and effects have their typical forms.
    #[arg(long, conflicts_with_all = ["cohort", "labelled"])]
    pub narrow: bool,
    /// Cohorts to be read in the place of worlds; may be given more than once.
    #[arg(long, value_name = "DIR")]
    pub cohort: Vec<PathBuf>,
    /// Worlds of another hand to be read in the place of ours: a folder with `worlds/` and `labels.json` (schema
    /// `blind_labels/1`); may be given more than once.
    #[arg(long, value_name = "DIR", conflicts_with = "cohort")]
    pub labelled: Vec<PathBuf>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/evidence")]
    pub out: PathBuf,
    /// Seed of the worlds.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}
