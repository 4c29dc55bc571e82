//! `replay`: a cohort's record through a model, freely from the first reading.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context as _, Result};
use cohort::MissingDoses;
use nn_statespace::import::FILE_ORDER;
use twins::{ReplayStart, replay};

use crate::files::{read_population, read_twin};
use crate::people::read_cohort;
use crate::stages::steady_state::read_table;
use crate::{Manifest, OutputFolder, Progress, note};

/// Where a replay starts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Initial {
    /// The model's own steady state at the first reading.
    SteadyState,
    /// The row of a published table of scaled states by glucose.
    Table(PathBuf),
}

/// Settings of `replay`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Cohort folder.
    pub cohort: PathBuf,
    /// Population model.
    pub model: PathBuf,
    /// A twin of that population model.
    pub twin: Option<PathBuf>,
    /// Where it starts.
    pub initial: Initial,
    /// Output folder.
    pub out: PathBuf,
}

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    let (initial, file) = match &args.initial {
        Initial::SteadyState => ("steady-state", None),
        Initial::Table(path) => ("table", Some(path)),
    };
    let config = serde_json::json!({ "initial": initial, "missing_doses": "zero" });
    let manifest = Manifest::new("replay", config, None)
        .with_input(&args.cohort)?
        .with_model(&args.model)?
        .with_inputs(&args.twin)?
        .with_inputs(file)?;
    let cohort = read_cohort(&args.cohort)?;
    let population = Arc::new(read_population(&args.model)?);
    let read = |path: &PathBuf| read_twin(path, Arc::clone(&population));
    let twin = args.twin.as_ref().map(read).transpose()?;
    let table = file.map(|path| read_table(path)).transpose()?;
    if let Some(twin) = &twin {
        let (id, people) = (&twin.card.person_id, cohort.people.len());
        if people > 1 {
            note(format!("replay: the twin of person {id} is used for all {people} people"));
        }
        for person in cohort.people.iter().filter(|person| person.id != *id) {
            note(format!(
                "replay: warning: this is the twin of '{id}', and the record is that of '{}'; a twin answers \
                 for its own person",
                person.id
            ));
        }
    }
    let output = OutputFolder::begin(&args.out, manifest)?;
    let progress = Progress::begin("replay", cohort.people.len());
    let mut text = String::from("person_id,time,step");
    for compartment in FILE_ORDER {
        let _ = write!(text, ",{compartment}");
    }
    text.push('\n');
    let start = table.as_ref().map_or(ReplayStart::SteadyState, ReplayStart::Table);
    let missing: usize =
        cohort.people.iter().map(|person| person.record.steps_without_doses()).sum();
    if missing > 0 {
        note(format!(
            "replay: {missing} steps have a basal rate, bolus or meal that was not recorded; it is \
             taken as none given"
        ));
    }
    for person in &cohort.people {
        let rows = match &twin {
            Some(twin) => replay(person, twin, &population, start, MissingDoses::Zero),
            None => replay(person, &*population, &population, start, MissingDoses::Zero),
        }
        .with_context(|| format!("person {}", person.id))?;
        for row in &rows {
            let time = row.time.format("%Y-%m-%dT%H:%M:%S");
            let _ = write!(text, "{},{time},{}", person.id, row.step);
            for compartment in FILE_ORDER {
                let _ = write!(text, ",{}", row.states[compartment]);
            }
            text.push('\n');
        }
        progress.advance(&person.id);
    }
    output.write("traces.csv", text.as_bytes())?;
    let place = output.finish()?;
    progress.finish(&place.join("traces.csv").display().to_string());
    Ok(())
}
