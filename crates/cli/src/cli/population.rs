//! Options of the commands on the population network.

use std::path::PathBuf;

use clap::Args;
use pipeline::Profile;
use pipeline::stages::import_model::ModelFormat;
use pipeline::stages::train::TrainingPreset;
use pipeline::stages::verify::MilpForm;

use super::words::{MILP_FORM, MODEL_FORMAT, PROFILE, TRAINING_PRESET, one_of};

/// Options of `development-set`.
#[derive(Debug, Args)]
pub(crate) struct DevelopmentSetArgs {
    /// How many days: quick 420, paper 323,400 (two minutes, 3 GB).
    #[arg(long, value_parser = one_of(PROFILE), default_value = "quick", hide_possible_values = true)]
    pub profile: Profile,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/development-set")]
    pub out: PathBuf,
    /// Seed of meals, starts and doses.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Options of `train`.
#[derive(Debug, Args)]
pub(crate) struct TrainArgs {
    /// How much to compute: the network's widths and the simulated days.
    #[arg(long, value_parser = one_of(PROFILE), default_value = "quick")]
    pub profile: Profile,
    /// How the network is trained.
    #[arg(long, value_parser = one_of(TRAINING_PRESET), default_value = "working")]
    pub preset: TrainingPreset,
    /// End after so many epochs without a lower error on the validation windows, and keep the best
    /// epoch's weights [default: all epochs].
    #[arg(long, value_name = "EPOCHS")]
    pub patience: Option<usize>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/train")]
    pub out: PathBuf,
    /// Seed of the simulated days, the initial weights and the order of the batches.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Options of `import-model`.
#[derive(Debug, Args)]
pub(crate) struct ImportModelArgs {
    /// Format of the source.
    #[arg(long, value_parser = one_of(MODEL_FORMAT), value_name = "FORMAT")]
    pub from: ModelFormat,
    /// Folder of the published files.
    pub folder: PathBuf,
    /// Population model that a published twin belongs to [default: the published one in the folder
    /// above the twin's].
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/import-model")]
    pub out: PathBuf,
}

/// Options of `verify`.
#[derive(Debug, Args)]
pub(crate) struct VerifyArgs {
    /// Population model.
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// Box over which to verify [default: the range of the model's training data; an imported model has none].
    #[arg(long, value_name = "FILE")]
    pub region: Option<PathBuf>,
    /// Verify a person's twin on this population model in its place: insulin-action and glucose directions of dQ1/dt, over
    /// the ranges of the person's record.
    #[arg(long, value_name = "FILE", requires = "cohort", conflicts_with_all = ["region", "repair",
        "widen", "delta", "milp"])]
    pub twin: Option<PathBuf>,
    /// The cohort with that person's record.
    #[arg(long, value_name = "DIR", requires = "twin")]
    pub cohort: Option<PathBuf>,
    /// Widen every interval of the box at both ends by this share of its length: the paper's generalisation region.
    #[arg(long, value_name = "SHARE", default_value_t = 0.0)]
    pub widen: f64,
    /// Longest step for the paper's z, scaled [default: ten times the smallest change of the input between simulated steps].
    #[arg(long, value_name = "DELTA")]
    pub delta: Option<f64>,
    /// Programme that HiGHS solves beside the certified search, for networks of up to four inputs.
    #[arg(long, value_parser = one_of(MILP_FORM), default_value = "gradient")]
    pub milp: MilpForm,
    /// Time limit of one row, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0)]
    pub limit: f64,
    /// Change the model as little as it takes to have every physical property, and verify what comes out.
    #[arg(long)]
    pub repair: bool,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/verify")]
    pub out: PathBuf,
    /// Seed of the sampled share of the box.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Options of `steady-state`.
#[derive(Debug, Args)]
pub(crate) struct SteadyStateArgs {
    /// Population model.
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// A table of scaled initial states by glucose to compare with.
    #[arg(long, value_name = "FILE")]
    pub compare: Option<PathBuf>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/steady-state")]
    pub out: PathBuf,
}

/// Options of `trajectories`.
#[derive(Debug, Args)]
pub(crate) struct TrajectoriesArgs {
    /// Population model.
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// A person's twin on that model.
    #[arg(long, value_name = "FILE")]
    pub twin: Option<PathBuf>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/trajectories")]
    pub out: PathBuf,
}

/// Options of `widths`.
#[derive(Debug, Args)]
pub(crate) struct WidthsArgs {
    /// How much each training computes.
    #[arg(long, value_parser = one_of(PROFILE), default_value = "quick")]
    pub profile: Profile,
    /// Trainings that explore the range of widths.
    #[arg(long, value_name = "N", default_value_t = 12)]
    pub explore: usize,
    /// Trainings of widths that the trials before them propose.
    #[arg(long, value_name = "N", default_value_t = 12)]
    pub exploit: usize,
    /// Trainings side by side while exploring; each takes some megabytes beside the common data.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub at_once: usize,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/widths")]
    pub out: PathBuf,
    /// Seed of simulated days, initial weights and proposals.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

/// Options of `held-out`.
#[derive(Debug, Args)]
pub(crate) struct HeldOutArgs {
    /// Population model.
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// Another population model, on the same windows.
    #[arg(long, value_name = "FILE")]
    pub beside: Option<PathBuf>,
    /// The development set whose test subset is used: that of `train` with this profile and seed.
    #[arg(long, value_parser = one_of(PROFILE), default_value = "quick")]
    pub profile: Profile,
    /// Seed of the development set.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/held-out")]
    pub out: PathBuf,
}
