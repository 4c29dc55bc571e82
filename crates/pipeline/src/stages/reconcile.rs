//! `reconcile`: a cohort whose logged carbohydrate is reconciled with the meals that its sensors show.

use std::path::PathBuf;

use anyhow::{Context as _, Result};
use cohort::{Cohort, RecordsFormat, write_folder};
use contract::meals::PersonMeals;
use contract::{Document as _, Meals};
pub use meals::reconcile::Rule;
use meals::reconcile::{
    EventRow, ReconcileSettings, Reconciled, count_fates, logged, reconcile_cohort,
};
use meals::{Detector, GridSettings, PlantSettings};

use crate::people::read_cohort;
use crate::{Manifest, OutputFolder, Progress, note};
use ::report::count;

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
    output.write_document(&file(&before, &people, &detector, &settings))?;
    let fates = count_fates(people.iter().flat_map(|person| &person.events));
    let after = Cohort { people: people.into_iter().map(|person| person.person).collect() };
    write_folder(&after, output.path(), RecordsFormat::Parquet).context("writing the cohort")?;
    let place = output.finish()?;
    let counts: Vec<String> =
        fates.iter().map(|(fate, count)| format!("{count} {}", fate.name())).collect();
    note(format!("reconcile: {}", counts.join(", ")));
    let people = count(after.people.len(), "person", "people");
    progress.finish(&format!("{people} in {}", place.display()));
    Ok(())
}

fn file(
    before: &Cohort,
    people: &[Reconciled],
    detector: &Detector,
    settings: &ReconcileSettings,
) -> Meals {
    let named = |events: &mut dyn Iterator<Item = &EventRow>| {
        let counts = count_fates(events).into_iter();
        counts.map(|(fate, count)| (fate.name().to_owned(), count)).collect()
    };
    Meals {
        schema: Meals::SCHEMA.to_owned(),
        detector: detector.name().to_owned(),
        rule: settings.rule,
        window_min: settings.window as f64 * physiology::STEP.0,
        smallest_bolus_u: settings.smallest_bolus,
        fates: named(&mut people.iter().flat_map(|person| &person.events)),
        people: before
            .people
            .iter()
            .zip(people)
            .map(|(before, after)| PersonMeals {
                person_id: before.id.clone(),
                weight_assumed: before.weight.is_none(),
                sensitivity: after.sensitivity,
                size_scale: after.size_scale,
                carbs_before_g: logged(before).0,
                carbs_after_g: logged(&after.person).0,
                fates: named(&mut after.events.iter()),
            })
            .collect(),
        events: people.iter().flat_map(|person| &person.events).map(Into::into).collect(),
    }
}
