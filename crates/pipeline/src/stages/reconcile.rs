//! `reconcile`: a cohort whose logged carbohydrate is reconciled with the meals that its sensors show.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Context as _, Result};
use cohort::{Cohort, RecordsFormat, write_folder};
pub use meals::reconcile::Rule;
use meals::reconcile::{
    EventRow, ReconcileSettings, Reconciled, count_fates, logged, reconcile_cohort,
};
use meals::{Detector, GridSettings, PlantSettings};
use serde::Serialize;

use crate::manifest::Manifest;
use crate::output::OutputFolder;
use crate::people::read_cohort;
use crate::progress::{Progress, note};

/// How meals are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum DetectorName {
    /// The published rate-of-rise detector; it estimates no sizes.
    Grid,
    /// A matched filter behind a Kalman filter on the ODE plant.
    Plant,
}

/// Settings of `reconcile`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Cohort folder.
    pub cohort: PathBuf,
    /// How meals are found.
    pub detector: DetectorName,
    /// How they and the log become one log.
    pub rule: Rule,
    /// Output folder.
    pub out: PathBuf,
}

/// What `meals.json` holds.
#[derive(Serialize)]
struct MealsFile<'a> {
    schema: &'static str,
    detector: &'static str,
    rule: Rule,
    window_min: f64,
    smallest_bolus_u: f64,
    /// Events by fate, of everybody.
    fates: BTreeMap<&'static str, usize>,
    people: Vec<PersonRow<'a>>,
    events: Vec<&'a EventRow>,
}

/// One person of `meals.json`.
#[derive(Serialize)]
struct PersonRow<'a> {
    person_id: &'a str,
    /// Whether the plant had to take the population's mean weight.
    weight_assumed: bool,
    /// Insulin sensitivity over the nominal one.
    sensitivity: Option<f64>,
    /// By what estimated sizes were multiplied before they were added.
    size_scale: f64,
    carbs_before_g: f64,
    carbs_after_g: f64,
    fates: BTreeMap<&'static str, usize>,
}

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    let detector = match args.detector {
        DetectorName::Grid => Detector::Grid(GridSettings::published()),
        DetectorName::Plant => Detector::Plant(PlantSettings::working()),
    };
    let settings = ReconcileSettings::new(args.rule);
    let config = serde_json::json!({
        "detector": args.detector,
        "rule": args.rule,
        "settings": format!("{detector:?}"),
        "window_steps": settings.window,
        "smallest_bolus_u": settings.smallest_bolus,
    });
    let manifest = Manifest::new("reconcile", config, None).with_input(&args.cohort)?;
    let before = read_cohort(&args.cohort)?;
    let output = OutputFolder::begin(&args.out, manifest)?;
    let progress = Progress::begin("reconcile", before.people.len());
    let done = |person: &str| progress.advance(person);
    let people = reconcile_cohort(&before, &detector, &settings, &done)
        .context("reconciling the log of carbohydrate")?;
    output.write_json("meals.json", &file(&before, &people, &detector, &settings))?;
    let fates = count_fates(people.iter().flat_map(|person| &person.events));
    let after = Cohort { people: people.into_iter().map(|person| person.person).collect() };
    write_folder(&after, output.path(), RecordsFormat::Parquet).context("writing the cohort")?;
    let place = output.finish()?;
    let counts: Vec<String> =
        fates.iter().map(|(fate, count)| format!("{count} {}", fate.name())).collect();
    note(format!("reconcile: {}", counts.join(", ")));
    progress.finish(&format!("{} people in {}", after.people.len(), place.display()));
    Ok(())
}

fn file<'a>(
    before: &'a Cohort,
    people: &'a [Reconciled],
    detector: &Detector,
    settings: &ReconcileSettings,
) -> MealsFile<'a> {
    let named = |events: &mut dyn Iterator<Item = &'a EventRow>| {
        count_fates(events).into_iter().map(|(fate, count)| (fate.name(), count)).collect()
    };
    MealsFile {
        schema: "meals/1",
        detector: detector.name(),
        rule: settings.rule,
        window_min: settings.window as f64 * physiology::STEP.0,
        smallest_bolus_u: settings.smallest_bolus,
        fates: named(&mut people.iter().flat_map(|person| &person.events)),
        people: before
            .people
            .iter()
            .zip(people)
            .map(|(before, after)| PersonRow {
                person_id: &before.id,
                weight_assumed: before.weight.is_none(),
                sensitivity: after.sensitivity,
                size_scale: after.size_scale,
                carbs_before_g: logged(before).0,
                carbs_after_g: logged(&after.person).0,
                fates: named(&mut after.events.iter()),
            })
            .collect(),
        events: people.iter().flat_map(|person| &person.events).collect(),
    }
}
