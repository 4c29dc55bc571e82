//! `import-model`: published weights as model files.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context as _, Result, bail};
use nn_statespace::{PopulationModel, import};
use twins::published_twin;

use crate::files::{self, find, read_bytes};
use crate::stages::train;
use crate::{Manifest, OutputFolder, note};

/// A published model's format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ModelFormat {
    /// T1DSim_AI: a folder with the population's `.pt` and scalers, or with a twin's.
    T1dsim,
}

/// Settings of `import-model`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Format of the source.
    pub from: ModelFormat,
    /// Folder of the published files.
    pub folder: PathBuf,
    /// Population model that a published twin belongs to; the published one in the folder above the
    /// twin's if not given.
    pub model: Option<PathBuf>,
    /// Output folder.
    pub out: PathBuf,
}

/// The twin's file name in an output folder.
pub(crate) const TWIN: &str = "twin.safetensors";

/// The three files of a published population model.
struct PopulationFiles {
    weights: PathBuf,
    /// The scaler of its states.
    states: PathBuf,
    /// The scaler of its inputs.
    inputs: PathBuf,
}

impl PopulationFiles {
    fn all(&self) -> [&Path; 3] {
        [&self.weights, &self.states, &self.inputs]
    }
}

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    let ModelFormat::T1dsim = args.from;
    let folder = &args.folder;
    if !folder.is_dir() {
        bail!(
            "there is no folder '{}'; give the folder with the .pt and .pkl files",
            folder.display()
        );
    }
    let manifest = Manifest::new("import-model", serde_json::json!({ "from": args.from }), None);
    let twin = folder.join("individual_model.pt");
    if twin.is_file() {
        return import_twin(args, &twin, manifest);
    }
    let files = population_files(folder)?;
    let model = read_population(&files)?;
    let output = OutputFolder::begin(&args.out, manifest.with_inputs(files.all())?)?;
    output.write(train::MODEL, &model.to_safetensors())?;
    let place = output.finish()?;
    note(format!("import-model: {}", place.join(train::MODEL).display()));
    Ok(())
}

fn import_twin(args: &Settings, weights: &Path, manifest: Manifest) -> Result<()> {
    let scaler = args.folder.join("scaler_robust.pkl");
    let manifest = manifest.with_input(weights)?.with_input(&scaler)?;
    let (manifest, population) = match &args.model {
        Some(path) => (manifest.with_input(path)?, files::read_population(path)?),
        None => {
            let files = population_above(&args.folder)?;
            (manifest.with_inputs(files.all())?, read_population(&files)?)
        }
    };
    let population = Arc::new(population);
    let name = args.folder.file_name().map_or_else(
        || "published".to_owned(),
        |name| name.to_string_lossy().trim_start_matches("Model").to_owned(),
    );
    let twin = published_twin(&read_bytes(weights)?, &read_bytes(&scaler)?, population, &name)
        .with_context(|| format!("the twin in '{}'", args.folder.display()))?;
    let output = OutputFolder::begin(&args.out, manifest)?;
    output.write(TWIN, &twin.to_bytes()?)?;
    output.write(train::MODEL, &twin.population.to_safetensors())?;
    let place = output.finish()?;
    note(format!(
        "import-model: {} and the {} it belongs to",
        place.join(TWIN).display(),
        train::MODEL
    ));
    Ok(())
}

/// The published population model beside a twin's folder.
fn population_above(folder: &Path) -> Result<PopulationFiles> {
    let folder = folder
        .canonicalize()
        .with_context(|| format!("cannot find the folder '{}'", folder.display()))?;
    let parent = folder.parent().unwrap_or(&folder);
    population_files(parent).with_context(|| {
        format!(
            "a twin belongs to its population model, and there is none above '{}'; give it with \
             --model population.safetensors",
            folder.display()
        )
    })
}

fn population_files(folder: &Path) -> Result<PopulationFiles> {
    let weights = match find(folder, "population_model", ".pt")?.as_slice() {
        [one] => one.clone(),
        [] => bail!(
            "'{}' holds neither population_model*.pt nor individual_model.pt",
            folder.display()
        ),
        several => bail!(
            "'{}' holds {} files population_model*.pt; leave one",
            folder.display(),
            several.len()
        ),
    };
    Ok(PopulationFiles {
        weights,
        states: folder.join("scaler_states.pkl"),
        inputs: folder.join("scaler_inputs.pkl"),
    })
}

fn read_population(files: &PopulationFiles) -> Result<PopulationModel> {
    let PopulationFiles { weights, states, inputs } = files;
    let (of_states, of_inputs) = (read_bytes(states)?, read_bytes(inputs)?);
    // By themselves first, so that the message names the files at fault.
    import::scaler(&of_states, &of_inputs).with_context(|| {
        format!("the scalers '{}' and '{}'", states.display(), inputs.display())
    })?;
    import::population(&read_bytes(weights)?, &of_states, &of_inputs)
        .with_context(|| format!("the published model '{}'", weights.display()))
}
