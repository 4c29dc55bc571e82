//! `train`: the population network from simulated days of the ODE.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context as _, Result, ensure};
use contract::region::Unit;
use contract::training::Epoch;
use contract::{Document as _, RegionFile, Training};
use nn_statespace::training::{
    Advance, EarlyStop, EpochReport, KeptWeights, Provenance, Trained, TrainingConfig, TrainingRun,
    WindowSet,
};
use nn_statespace::{Signal, Widths};
use ode_sim::DevelopmentPlan;
use physiology::{Compartment, STEP};

use crate::checkpoint::CheckpointFile;
use crate::{Manifest, OutputFolder, Profile, Progress};
use development::TrainingData;
use development::weeks::{TRAINING_STRIDE, WINDOW};

/// How the population network is trained.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TrainingPreset {
    /// Ours: short roll-outs come first, gradients are limited, the best epoch is kept, and slopes keep the
    /// signs of physiology.
    Working,
    /// Ours, with slopes as they come.
    Unconstrained,
    /// As the paper says.
    Paper,
    /// As the published code does: glucose is also confined to 40-400 mg/dL after every step.
    AuthorsCode,
}

/// Settings of `train`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// How much to compute: the network's widths and the simulated days.
    pub profile: Profile,
    /// How the network is trained.
    pub preset: TrainingPreset,
    /// End after so many epochs without a lower error on the validation windows, and keep the best
    /// epoch's weights; all epochs if not given.
    pub patience: Option<usize>,
    /// Output folder.
    pub out: PathBuf,
    /// Seed of the simulated days, the initial weights and the order of the batches.
    pub seed: u64,
}

/// The model's file name in an output folder.
pub(crate) const MODEL: &str = "population.safetensors";
/// Updates between two checkpoints: seconds of work.
const CHECKPOINT_EVERY: usize = 2000;
/// What a profile trains, and on what.
#[derive(Debug, Clone)]
struct Recipe {
    plan: DevelopmentPlan,
    widths: Widths,
    config: TrainingConfig,
}

impl Recipe {
    fn new(args: &Settings) -> Self {
        let widths = match args.profile {
            Profile::Quick => Widths::quick(),
            Profile::Paper => Widths::paper(),
        };
        let mut config = match args.preset {
            TrainingPreset::Working => args.profile.training(args.seed),
            TrainingPreset::Unconstrained => TrainingConfig::unconstrained(args.seed),
            TrainingPreset::Paper => TrainingConfig::paper(args.seed),
            TrainingPreset::AuthorsCode => TrainingConfig::authors_code(args.seed),
        };
        if let Some(epochs) = args.patience {
            config.stop = EarlyStop::Patience(epochs);
            config.keep = KeptWeights::LowestValidationError;
        }
        Self { plan: args.profile.plan(args.seed), widths, config }
    }

    fn json(&self) -> serde_json::Value {
        let widths: BTreeMap<&str, usize> =
            Compartment::ALL.into_iter().map(|c| (c.name(), self.widths.of(c))).collect();
        serde_json::json!({
            "simulated_weeks": self.plan.weeks(),
            "simulated_days": self.plan.days(),
            "widths": widths,
            "window_minutes": WINDOW as f64 * STEP.0,
            "training_stride_minutes": TRAINING_STRIDE as f64 * STEP.0,
            "training": self.config,
        })
    }
}

/// The manifest of a run with these arguments.
pub(crate) fn manifest(args: &Settings) -> Manifest {
    Manifest::new("train", Recipe::new(args).json(), Some(args.seed))
}

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    ensure!(args.patience != Some(0), "--patience 0 must be at least 1 epoch");
    let began = Instant::now();
    let recipe = Recipe::new(args);
    let output = OutputFolder::begin(&args.out, manifest(args))?;

    let TrainingData { training, validation, sha256: hash } = simulated(&recipe.plan)?;
    let range = training_range(&training);

    let provenance = Provenance {
        origin: format!(
            "trained on {} simulated days of the ODE with population parameters",
            recipe.plan.days()
        ),
        training_data_sha256: Some(hash.clone()),
    };
    let checkpoint = CheckpointFile::beside(&args.out);
    let (run, progress) = trained(&recipe, &training, &validation, &checkpoint)
        .context("training the population network")?;
    let Trained { model, report } = run.finish(provenance)?;

    output.write(MODEL, &model.to_safetensors())?;
    output.write_document(&range)?;
    output.write_document(&Training {
        config: serde_json::to_value(&report.config)?,
        data: contract::training::TrainingData {
            hash,
            simulated_days: recipe.plan.days(),
            windows_train: report.training_windows,
            windows_validation: report.validation_windows,
        },
        epochs: report.epochs.iter().map(epoch).collect(),
        kept_epoch: report.kept_epoch,
        model: MODEL.to_owned(),
        schema: Training::SCHEMA.to_owned(),
        seconds: began.elapsed().as_secs_f64(),
        seed: args.seed,
        validation_loss_is: "balanced glucose error over the paper's three groups, mg/dL"
            .to_owned(),
    })?;
    let kept = &report.epochs[report.kept_epoch].validation;
    let place = output.finish()?;
    checkpoint.remove();
    progress.finish(&format!(
        "balanced validation error {:.1} mg/dL (in range, low, other: {}), {}",
        kept.balanced(),
        kept.rmse_mg_dl
            .iter()
            .map(|rmse| rmse.map_or("none".to_owned(), |rmse| format!("{rmse:.1}")))
            .collect::<Vec<_>>()
            .join(", "),
        place.join(MODEL).display()
    ));
    Ok(())
}

/// Simulates the development set of `plan` and says what it takes.
pub(crate) fn simulated(plan: &DevelopmentPlan) -> Result<TrainingData> {
    let progress = Progress::begin("simulate", plan.weeks());
    let data = TrainingData::simulate(plan, &|| progress.advance("weeks"))?;
    progress.finish(&format!(
        "{} days for the development set, {:.0} MB of training and validation rows",
        plan.days(),
        (data.training.bytes() + data.validation.bytes()) as f64 / 1e6
    ));
    Ok(data)
}

fn epoch(report: &EpochReport) -> Epoch {
    Epoch {
        epoch: report.epoch,
        learning_rate: report.learning_rate,
        steps: report.steps,
        train_loss: report.training_loss,
        validation_loss: report.validation.balanced(),
        validation_rmse_by_group_mg_dl: report.validation.rmse_mg_dl,
    }
}

/// The run with all its epochs done, from its checkpoint if there is one.
fn trained<'a>(
    recipe: &Recipe,
    training: &'a WindowSet,
    validation: &'a WindowSet,
    checkpoint: &CheckpointFile,
) -> Result<(TrainingRun<'a>, Progress)> {
    let Recipe { config, widths, .. } = recipe;
    let resumed = checkpoint.resumed("train", |bytes| {
        let run = TrainingRun::resume(bytes, config, widths, training, validation)?;
        let done = format!("{} updates", run.updates());
        Ok((run, done))
    });
    let mut run = match resumed {
        Some(run) => run,
        None => TrainingRun::begin(config, widths, training, validation)?,
    };
    let progress = Progress::begin("train", config.stages.iter().map(|stage| stage.epochs).sum());
    for _ in run.epochs() {
        progress.advance("resumed");
    }
    loop {
        match run.advance()? {
            Advance::Batch => {}
            Advance::Epoch(epoch) => progress.advance(&format!(
                "loss {:.4}, validation {:.1} mg/dL",
                epoch.training_loss,
                epoch.validation.balanced()
            )),
            Advance::Finished => return Ok((run, progress)),
        }
        if run.updates().is_multiple_of(CHECKPOINT_EVERY) {
            checkpoint.write(&run.checkpoint())?;
        }
    }
}

/// Lowest and highest scaled value of each signal over the training rows: the training region of
/// the conformance rows.
fn training_range(training: &WindowSet) -> RegionFile {
    let bounds = Signal::all().map(|signal| {
        let (least, greatest) = training.bounds(signal);
        (signal.name().to_owned(), [least, greatest])
    });
    RegionFile { bounds: bounds.collect(), half_spaces: Vec::new(), unit: Unit::Scaled }
}
