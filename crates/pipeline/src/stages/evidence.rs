//! `evidence`: what the diagnosis reads of worlds whose truth is known, or of cohorts; a row each.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::PathBuf;

use anyhow::{Context as _, Result};
use candle_core::{Device, Tensor};
use cohort::Cohort;
use contract::Document as _;
use contract::blind_check::{Label, Labels};
use contract::posterior::StatisticNames;
use gap::{DiagnosisConfig, cohort_statistics};
use world::blind::{Plan, Variation};

use crate::bounds;
use crate::labels::{another_hand, label};
use crate::people::read_cohort;
use crate::{Manifest, OutputFolder, Progress, note};

/// Settings of `evidence`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Worlds in which something is missing.
    pub worlds: usize,
    /// Worlds in which nothing is missing.
    pub nulls: usize,
    /// Whether everyday life varies as little as in the embedded cohort, and effects have their typical forms.
    pub narrow: bool,
    /// Cohorts to be read in the place of worlds.
    pub cohort: Vec<PathBuf>,
    /// Worlds of another hand to be read in the place of ours: a folder with `worlds/` and `labels.json` (schema
    /// `blind_labels/1`).
    pub labelled: Vec<PathBuf>,
    /// Output folder.
    pub out: PathBuf,
    /// Seed of the worlds.
    pub seed: u64,
}

/// Most worlds of one table.
const MOST_WORLDS: usize = 100_000;

/// What another hand is called, whose worlds are given as cohorts with labels.
const ANOTHER: &str = "another";

/// Statistics of one world or cohort by name.
type Row = BTreeMap<String, f64>;

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    bounds::worlds(("--worlds", args.worlds), ("--nulls", args.nulls), MOST_WORLDS)?;
    let settings = serde_json::json!({
        "worlds": args.worlds, "nulls": args.nulls, "narrow": args.narrow,
    });
    let manifest = Manifest::new("evidence", settings, Some(args.seed))
        .with_inputs(args.cohort.iter().chain(&args.labelled))?;
    let output = OutputFolder::begin(&args.out, manifest)?;
    let rows = if !args.labelled.is_empty() {
        of_labelled(args)?
    } else if args.cohort.is_empty() {
        of_worlds(args)?
    } else {
        of_cohorts(args)?
    };
    let names: BTreeSet<String> = rows.iter().flat_map(|(_, row)| row.keys().cloned()).collect();
    let values: Vec<f32> = rows
        .iter()
        .flat_map(|(_, row)| names.iter().map(|name| row.get(name).map_or(f32::NAN, |v| *v as f32)))
        .collect();
    let table = Tensor::from_vec(values, (rows.len(), names.len()), &Device::Cpu)?;
    let file = output.path().join("statistics.safetensors");
    candle_core::safetensors::save(&HashMap::from([("statistics", table)]), &file)
        .with_context(|| format!("cannot write '{}'", file.display()))?;
    let read = format!("{} rows of {} statistics", rows.len(), names.len());
    output.write_document(&StatisticNames(names.into_iter().collect()))?;
    output.write_document(&Labels(rows.into_iter().map(|(label, _)| label).collect()))?;
    let place = output.finish()?;
    note(format!("evidence: {read}: {}", place.display()));
    Ok(())
}

/// Draws worlds and reads them; those of which nobody can be read are left out.
fn of_worlds(args: &Settings) -> Result<Vec<(Label, Row)>> {
    let variation = if args.narrow { Variation::Narrow } else { Variation::Wide };
    let plan = Plan { variation, ..Plan::training(args.worlds, args.nulls) };
    let planned = plan.worlds(args.seed);
    let world = |index: usize| -> Result<(Label, Cohort)> {
        let lived = planned[index].realise()?;
        Ok((label(&format!("{}-{index}", args.seed), &lived)?, lived.cohort()))
    };
    of_each(planned.len(), world)
}

/// Reads worlds of another hand, which goes by the name of this.
fn of_labelled(args: &Settings) -> Result<Vec<(Label, Row)>> {
    let mut asked: Vec<(PathBuf, Label)> = Vec::new();
    for folder in &args.labelled {
        let labels = another_hand::read(&folder.join(Labels::FILE), ANOTHER)?;
        asked
            .extend(labels.into_iter().map(|label| (folder.join("worlds").join(&label.id), label)));
    }
    let world = |index: usize| -> Result<(Label, Cohort)> {
        let (folder, label) = &asked[index];
        Ok((label.clone(), read_cohort(folder)?))
    };
    of_each(asked.len(), world)
}

/// Rows of so many worlds; those of which nobody can be read are left out.
fn of_each(
    count: usize,
    world: impl Fn(usize) -> Result<(Label, Cohort)> + Sync,
) -> Result<Vec<(Label, Row)>> {
    let (library, config) = (effects::library(), DiagnosisConfig::working());
    let progress = Progress::begin("worlds", count);
    let row = |index: usize| -> Result<Option<(Label, Row)>> {
        let (label, cohort) = world(index)?;
        let found = cohort_statistics(&cohort, &library, &config)?;
        Ok(found.map(|row| (label, row)))
    };
    let rows =
        progress.each(count, |index| row(index).with_context(|| format!("world {}", index + 1)))?;
    let rows: Vec<(Label, Row)> = rows.into_iter().flatten().collect();
    progress.finish(&format!("{} of {count} worlds read", rows.len()));
    Ok(rows)
}

/// Reads cohorts. Their labels say nothing but the folder: what is true of them is not known here.
fn of_cohorts(args: &Settings) -> Result<Vec<(Label, Row)>> {
    let (library, config) = (effects::library(), DiagnosisConfig::working());
    let progress = Progress::begin("cohorts", args.cohort.len());
    let mut rows = Vec::new();
    for folder in &args.cohort {
        let cohort = read_cohort(folder)?;
        let found = cohort_statistics(&cohort, &library, &config)
            .with_context(|| format!("'{}'", folder.display()))?;
        progress.advance("");
        let Some(row) = found else {
            note(format!("evidence: nobody in '{}' can be read", folder.display()));
            continue;
        };
        let label = Label::null(&folder.display().to_string(), "", "", cohort.people.len(), 0);
        rows.push((label, row));
    }
    progress.finish(&format!("{} cohorts read", rows.len()));
    Ok(rows)
}
