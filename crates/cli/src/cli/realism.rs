//! Options of `realism`.

use std::path::PathBuf;

use clap::Args;

/// Options of `realism`.
#[derive(Debug, Args)]
pub(crate) struct RealismArgs {
    /// A cohort of real people; may be given more than once.
    #[arg(long, value_name = "DIR", required = true)]
    pub cohort: Vec<PathBuf>,
    /// Worlds in which something is missing.
    #[arg(long, value_name = "N", default_value_t = 120)]
    pub worlds: usize,
    /// Worlds in which nothing is missing.
    #[arg(long, value_name = "N", default_value_t = 120)]
    pub nulls: usize,
    /// People in each world.
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub people: usize,
    /// Days of each person; of longer records those with the most readings.
    #[arg(long, value_name = "N", default_value_t = 14)]
    pub days: usize,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/realism")]
    pub out: PathBuf,
    /// Seed of the worlds.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}
