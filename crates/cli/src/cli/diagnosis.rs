//! Options of the diagnosis, and of the worlds that it is trained and checked on.

use std::path::PathBuf;

use clap::Args;
use pipeline::stages::worlds::{Generator, RegimeName};

use super::words::{self, REGIME, one_of};

/// Options of `diagnose`.
#[derive(Debug, Args)]
pub(crate) struct DiagnoseArgs {
    /// Cohort folder.
    #[arg(long, value_name = "DIR")]
    pub cohort: PathBuf,
    /// The plant to diagnose: `ode`, the file of a population model or of a person's twin, or an output
    /// folder of the command twin.
    #[arg(long, value_name = "MODEL", default_value = "ode")]
    pub model: String,
    /// The population model that twins were trained on, if it does not lie beside them.
    #[arg(long, value_name = "FILE")]
    pub population: Option<PathBuf>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/diagnose")]
    pub out: PathBuf,
    /// Seed of the bootstrap.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// A posterior, as `train-posterior` writes it, in place of that in use.
    #[arg(long, value_name = "FILE", hide = true)]
    pub posterior: Option<PathBuf>,
}

/// Options of `blind-check`.
#[derive(Debug, Args)]
pub(crate) struct BlindCheckArgs {
    /// Worlds with one effect, two effects, or one outside the library [default: 28; 252 with
    /// --full].
    #[arg(long, value_name = "N")]
    pub worlds: Option<usize>,
    /// Worlds without an effect [default: 12; 150 with --full].
    #[arg(long, value_name = "N")]
    pub nulls: Option<usize>,
    /// As many worlds as it takes to test every target.
    #[arg(long)]
    pub full: bool,
    /// The plant that is asked: `ode`, or the file of a population model.
    #[arg(long, value_name = "MODEL", default_value = "ode")]
    pub model: String,
    /// In place of worlds: effects planted into the records of this cohort of real people.
    #[arg(long, value_name = "COHORT", conflicts_with_all = ["worlds", "nulls", "full", "model"])]
    pub planted: Option<PathBuf>,
    /// In place of worlds: finished checks, scored as one; given once for each folder.
    #[arg(long, value_name = "DIR",
        conflicts_with_all = ["worlds", "nulls", "full", "model", "planted", "seed"])]
    pub together: Vec<PathBuf>,
    /// With --planted: multiples of each effect's usual size [default: 1,2].
    #[arg(long, value_name = "TIMES", value_delimiter = ',', requires = "planted")]
    pub sizes: Vec<f64>,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/blind-check")]
    pub out: PathBuf,
    /// Seed of the worlds [default: a fresh one, which is said].
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
}

/// Options of `worlds`.
#[derive(Debug, Args)]
pub(crate) struct WorldsArgs {
    /// What acts: an effect, two of them joined by `+`, or `none`.
    #[arg(long, value_name = "NAME", default_value = "none")]
    pub effect: String,
    /// Mean absolute shift of glucose that each effect is to cause, mg/dL.
    #[arg(long, value_name = "MG_DL", default_value_t = 5.0)]
    pub shift: f64,
    /// Generator of the bodies: `hovorka`, `padova`, `minimal` or `saturating` [default: all in turns].
    #[arg(long, value_name = "NAME", value_parser = words::generator)]
    pub generator: Option<Generator>,
    /// How basal insulin is decided [default: drawn].
    #[arg(long, value_parser = one_of(REGIME), value_name = "REGIME")]
    pub regime: Option<RegimeName>,
    /// People in each world.
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub people: usize,
    /// Days of each.
    #[arg(long, value_name = "N", default_value_t = 14)]
    pub days: usize,
    /// Missing heart rates, gaps, uneven days and unlogged set changes as in a blind check.
    #[arg(long)]
    pub nuisances: bool,
    /// Worlds.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub count: usize,
    /// In place of one effect: this many worlds with effects, mixed as in a blind check.
    #[arg(long, value_name = "N", conflicts_with_all = ["effect", "shift", "regime", "people",
        "days", "nuisances", "count"])]
    pub mixture: Option<usize>,
    /// With --mixture: worlds without an effect.
    #[arg(long, value_name = "N", default_value_t = 0, requires = "mixture")]
    pub nulls: usize,
    /// Output folder.
    #[arg(long, value_name = "DIR", default_value = "out/worlds")]
    pub out: PathBuf,
    /// Seed of the worlds.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
}

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
