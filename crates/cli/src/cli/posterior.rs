//! Options of `train-posterior`.

use std::path::PathBuf;

use clap::Args;

/// Options of `train-posterior`.
#[derive(Debug, Args)]
pub(crate) struct TrainPosteriorArgs {
    /// A table of `evidence`; may be given more than once.
    #[arg(long, value_name = "DIR", required = true)]
    pub table: Vec<PathBuf>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/posterior")]
    pub out: PathBuf,
    /// Seed of the networks.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}
