//! Options of the commands on people's twins, and on what they are compared with.

use std::path::PathBuf;

use clap::Args;
use pipeline::Profile;
use pipeline::stages::replay::Initial;

use super::words::{self, PROFILE, one_of};

/// Options of `twin`.
#[derive(Debug, Args)]
pub(crate) struct TwinArgs {
    /// Cohort folder.
    #[arg(long, value_name = "DIR")]
    pub cohort: PathBuf,
    /// Population model.
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// How much to compute.
    #[arg(long, value_parser = one_of(PROFILE), default_value = "quick")]
    pub profile: Profile,
    /// Also train twins that see other personal inputs (the paper's ablation), and twins whose
    /// network keeps physiology's signs.
    #[arg(long)]
    pub variants: bool,
    /// Output folder of an earlier run, whose twins are trained further; say with `--training-days`
    /// how many days there are now.
    #[arg(long, value_name = "DIR")]
    pub continue_from: Option<PathBuf>,
    /// Days from the start of each record that train; the profile's 14 if not given.
    #[arg(long, value_name = "N")]
    pub training_days: Option<usize>,
    /// Passes over the windows; the profile's if not given. Further training needs fewer.
    #[arg(long, value_name = "N")]
    pub epochs: Option<usize>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/twin")]
    pub out: PathBuf,
    /// Seed of the initial weights and the order of the batches.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Options of `baselines`.
#[derive(Debug, Args)]
pub(crate) struct BaselinesArgs {
    /// Cohort folder.
    #[arg(long, value_name = "DIR")]
    pub cohort: PathBuf,
    /// Population model; its scaling of glucose enters the loss.
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// The virtual patients of whom the closest is taken, in the columns of the published population;
    /// 99 of our own where it is not given.
    #[arg(long, value_name = "FILE")]
    pub patients: Option<PathBuf>,
    /// How much to compute.
    #[arg(long, value_parser = one_of(PROFILE), default_value = "quick")]
    pub profile: Profile,
    /// Days from the start of each record that train; 14 if not given.
    #[arg(long, value_name = "N")]
    pub training_days: Option<usize>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/baselines")]
    pub out: PathBuf,
    /// Seed of the search and of the sampler.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Options of `replay`.
#[derive(Debug, Args)]
pub(crate) struct ReplayArgs {
    /// Cohort folder.
    #[arg(long, value_name = "DIR")]
    pub cohort: PathBuf,
    /// Population model.
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// A twin of that population model.
    #[arg(long, value_name = "FILE")]
    pub twin: Option<PathBuf>,
    /// `steady-state`, or `table:FILE` with scaled states by glucose.
    #[arg(long, value_parser = words::initial, value_name = "START", default_value = "steady-state")]
    pub initial: Initial,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/replay")]
    pub out: PathBuf,
}

/// Options of `evaluate`.
#[derive(Debug, Args)]
pub(crate) struct EvaluateArgs {
    /// Cohort folder.
    #[arg(long, value_name = "DIR")]
    pub cohort: PathBuf,
    /// Output folder of `twin`.
    #[arg(long, value_name = "DIR")]
    pub twins: PathBuf,
    /// Output folder of `baselines`.
    #[arg(long, value_name = "DIR")]
    pub baselines: Option<PathBuf>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/evaluate")]
    pub out: PathBuf,
    /// Seed of the bootstrap.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Options of `effect-twins`.
#[derive(Debug, Args)]
pub(crate) struct EffectTwinsArgs {
    /// Cohort folder.
    #[arg(long, value_name = "DIR")]
    pub cohort: PathBuf,
    /// Population model.
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// How much to compute.
    #[arg(long, value_parser = one_of(PROFILE), default_value = "quick")]
    pub profile: Profile,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/effect-twins")]
    pub out: PathBuf,
    /// Seed of weights, order, folds and bootstrap.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}
