//! `train`: the population network from simulated days of the ODE.

use std::collections::BTreeMap;
use std::time::Instant;

use anyhow::{Context as _, Result};
use nn_statespace::training::{
    Advance, CarbStart, EarlyStop, KeptWeights, Provenance, Run, Trained, TrainingConfig,
    TrainingRun, WindowSet,
};
use nn_statespace::{Scaler, Widths};
use ode_sim::development_set::Subset;
use ode_sim::{DevelopmentPlan, DevelopmentSet};
use physiology::{Compartment, Plant as _, STEP, States, StepInput};
use sha2::{Digest as _, Sha256};

use crate::checkpoint::CheckpointFile;
use crate::cli::{Profile, TrainArgs, TrainingPreset};
use crate::manifest::{Manifest, hexadecimal};
use crate::output::OutputFolder;
use crate::progress::{Progress, note};

/// The model's file name in an output folder.
pub(crate) const MODEL: &str = "population.safetensors";
/// The range of the training data, as a region that `verify` reads.
pub(crate) const REGION: &str = "region.json";

/// Steps of a window: five hours (paper).
const WINDOW: usize = 60;
/// Steps between the starts of training windows: 75 % overlap (paper).
const TRAINING_STRIDE: usize = 15;
/// Updates between two checkpoints: seconds of work.
const CHECKPOINT_EVERY: usize = 2000;
/// Simulated weeks per call, which bounds memory.
const WEEKS_AT_ONCE: usize = 256;

/// What a profile trains, and on what.
#[derive(Debug, Clone)]
struct Recipe {
    plan: DevelopmentPlan,
    widths: Widths,
    config: TrainingConfig,
}

impl Recipe {
    fn new(args: &TrainArgs) -> Self {
        let seed = args.seed;
        let mut recipe = match args.profile {
            Profile::Quick => Self {
                plan: DevelopmentPlan::quick(seed),
                widths: Widths::quick(),
                config: TrainingConfig::quick(seed),
            },
            // A tenth of the paper's 46,200 weeks: the windows are held in memory.
            Profile::Paper => Self {
                plan: DevelopmentPlan {
                    meal_weeks: 24,
                    additional_weeks: 1020,
                    ..DevelopmentPlan::paper(seed)
                },
                widths: Widths::paper(),
                config: TrainingConfig::working(seed),
            },
        };
        match args.preset {
            TrainingPreset::Working => {}
            TrainingPreset::Paper => recipe.config = TrainingConfig::paper(seed),
            TrainingPreset::AuthorsCode => recipe.config = TrainingConfig::authors_code(seed),
        }
        if let Some(epochs) = args.patience {
            recipe.config.stop = EarlyStop::Patience(epochs);
            recipe.config.keep = KeptWeights::LowestValidationError;
        }
        recipe
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
pub(crate) fn manifest(args: &TrainArgs) -> Manifest {
    Manifest::new("train", Recipe::new(args).json(), Some(args.seed))
}

/// Runs the command.
pub(crate) fn run(args: &TrainArgs) -> Result<()> {
    let began = Instant::now();
    let recipe = Recipe::new(args);
    let manifest = manifest(args);
    let output = OutputFolder::begin(&args.out, manifest)?;

    let weeks = simulate_weeks(&recipe.plan)?;
    let (training, validation) = windows(&weeks)?;
    let range = training_range(&weeks, training.scaler());
    drop(weeks);
    let hash = hash(&training)?;

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
    output.write_json(REGION, &range)?;
    let curves: Vec<_> = report
        .epochs
        .iter()
        .map(|epoch| {
            serde_json::json!({
                "epoch": epoch.epoch,
                "train_loss": epoch.training_loss,
                "validation_loss": epoch.validation.balanced(),
                "validation_rmse_by_group_mg_dl": epoch.validation.rmse_mg_dl,
                "learning_rate": epoch.learning_rate,
                "steps": epoch.steps,
            })
        })
        .collect();
    output.write_json(
        "training.json",
        &serde_json::json!({
            "schema": "training/1",
            "model": MODEL,
            "seed": args.seed,
            "validation_loss_is": "balanced glucose error over the paper's three groups, mg/dL",
            "kept_epoch": report.kept_epoch,
            "epochs": curves,
            "data": {
                "windows_train": report.training_windows,
                "windows_validation": report.validation_windows,
                "simulated_days": recipe.plan.days(),
                "hash": hash,
            },
            "config": report.config,
            "seconds": began.elapsed().as_secs_f64(),
        }),
    )?;
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

/// The run with all its epochs done, from its checkpoint if there is one.
fn trained<'a>(
    recipe: &Recipe,
    training: &'a WindowSet,
    validation: &'a WindowSet,
    checkpoint: &CheckpointFile,
) -> Result<(TrainingRun<'a>, Progress)> {
    let Recipe { config, widths, .. } = recipe;
    let resumed = checkpoint.read().and_then(|bytes| {
        let place = checkpoint.path().display();
        match TrainingRun::resume(&bytes, config, widths, training, validation) {
            Ok(run) => {
                note(format!("train: goes on from '{place}' after {} updates", run.updates()));
                Some(run)
            }
            Err(error) => {
                note(format!("train: '{place}' is not used: {error}"));
                None
            }
        }
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

/// A simulated week in reporting units.
struct SimulatedWeek {
    subset: Subset,
    states: Vec<States>,
    inputs: Vec<StepInput>,
}

fn simulate_weeks(plan: &DevelopmentPlan) -> Result<Vec<SimulatedWeek>> {
    let set = DevelopmentSet::new(plan.clone()).context("the development set")?;
    let progress = Progress::begin("simulate", set.len());
    let mut weeks = Vec::with_capacity(set.len());
    for first in (0..set.len()).step_by(WEEKS_AT_ONCE) {
        let range = first..set.len().min(first + WEEKS_AT_ONCE);
        for (week, run) in set.simulate(range).context("simulating the development set")? {
            weeks.push(SimulatedWeek {
                subset: week.subset,
                states: run.states.iter().map(|x| set.plant().report(x)).collect(),
                inputs: run.inputs,
            });
            progress.advance("weeks");
        }
    }
    progress.finish(&format!("{} days for the development set", plan.days()));
    Ok(weeks)
}

fn of(weeks: &[SimulatedWeek], subset: Subset) -> impl Iterator<Item = &SimulatedWeek> {
    weeks.iter().filter(move |week| week.subset == subset)
}

/// Training and validation windows; the scaler sees training rows only.
fn windows(weeks: &[SimulatedWeek]) -> Result<(WindowSet, WindowSet)> {
    let runs = |subset| -> Vec<Run<'_>> {
        of(weeks, subset).map(|week| Run { states: &week.states, inputs: &week.inputs }).collect()
    };
    let training = runs(Subset::Train);
    let scaler = Scaler::fit(&training).context("the scaler")?;
    let cut = |runs: &[Run<'_>], stride| {
        WindowSet::new(&scaler, runs, WINDOW, stride, CarbStart::Reported).context("the windows")
    };
    Ok((cut(&training, TRAINING_STRIDE)?, cut(&runs(Subset::Validation), WINDOW)?))
}

/// Lowest and highest scaled value of each signal over the training rows: the training region of
/// the conformance rows.
fn training_range(weeks: &[SimulatedWeek], scaler: &Scaler) -> serde_json::Value {
    let mut bounds: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
    let mut widen = |name, value: f64| {
        let bound = bounds.entry(name).or_insert((value, value));
        *bound = (bound.0.min(value), bound.1.max(value));
    };
    for week in of(weeks, Subset::Train) {
        for states in &week.states {
            for (compartment, value) in scaler.scale(states).iter() {
                widen(compartment.name(), value);
            }
        }
        for input in &week.inputs {
            let scaled = scaler.scale_input(input);
            widen("u_insulin", scaled.insulin);
            widen("u_carbs", scaled.carbs);
        }
    }
    serde_json::json!({ "unit": "scaled", "bounds": bounds })
}

fn hash(windows: &WindowSet) -> Result<String> {
    let mut hasher = Hasher(Sha256::new());
    windows.write_canonical(&mut hasher).context("hashing the training windows")?;
    Ok(hexadecimal(&hasher.0.finalize()))
}

/// SHA-256 as something to write into.
struct Hasher(Sha256);

impl std::io::Write for Hasher {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}
