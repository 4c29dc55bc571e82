//! `widths`: hidden widths of the ten networks by Bayesian optimisation of the balanced error.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Context as _, Result, ensure};
use contract::widths::BestWidths;
use contract::{Document as _, WidthSearch};
use nn_statespace::training::TrainingConfig;
use ode_sim::DevelopmentPlan;
use physiology::Compartment;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::bounds::within;
use crate::checkpoint::CheckpointFile;
use crate::stages::train::simulated;
use crate::{Manifest, OutputFolder, Profile, Progress};
use development::width_search::{NETWORKS, Trial, best, error_of, next_widths};

/// Settings of `widths`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// How much each training computes.
    pub profile: Profile,
    /// Trainings that explore the range of widths.
    pub explore: usize,
    /// Trainings of widths that the trials before them propose.
    pub exploit: usize,
    /// Trainings side by side while exploring; each takes some megabytes beside the common data.
    pub at_once: usize,
    /// Output folder.
    pub out: PathBuf,
    /// Seed of simulated days, initial weights and proposals.
    pub seed: u64,
}

/// Most trainings of one search, and most of them side by side.
const MOST_TRIALS: usize = 10_000;
const MOST_AT_ONCE: usize = 256;

/// What a search trains, and on what.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Search {
    simulated_weeks: usize,
    training: TrainingConfig,
    explore: usize,
    seed: u64,
}

/// A search that was ended.
#[derive(Debug, Serialize, Deserialize)]
struct Ended {
    settings: Search,
    trials: Vec<Trial>,
}

fn plan(args: &Settings) -> DevelopmentPlan {
    match args.profile {
        Profile::Quick => DevelopmentPlan::quick(args.seed),
        // A fiftieth of the paper's 46,200 weeks: a hundred trainings on all of them would take a day.
        Profile::Paper => DevelopmentPlan {
            meal_weeks: 10,
            starts_per_week: 2,
            additional_weeks: 324,
            ..DevelopmentPlan::paper(args.seed)
        },
    }
}

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    within("--explore", args.explore, 2, MOST_TRIALS)?;
    within("--exploit", args.exploit, 0, MOST_TRIALS)?;
    within("--at-once", args.at_once, 1, MOST_AT_ONCE)?;
    let plan = plan(args);
    let settings = Search {
        simulated_weeks: plan.weeks(),
        training: args.profile.training(args.seed),
        explore: args.explore,
        seed: args.seed,
    };
    let manifest = Manifest::new("widths", serde_json::to_value(&settings)?, Some(args.seed));
    let output = OutputFolder::begin(&args.out, manifest)?;
    let checkpoint = CheckpointFile::beside(&args.out);
    // The trials of a search that was ended, if it is this one.
    let resumed = checkpoint.resumed("widths", |bytes| {
        let ended: Ended = serde_json::from_slice(bytes)?;
        ensure!(ended.settings == settings, "it is of another search");
        let done = format!("{} trials", ended.trials.len());
        Ok((ended.trials, done))
    });
    let mut trials = resumed.unwrap_or_default();

    let data = simulated(&plan)?;
    let total = args.explore + args.exploit;
    let progress = Progress::begin("widths", total);
    for _ in &trials {
        progress.advance("resumed");
    }
    while trials.len() < total {
        // What explores does not depend on the trials before it.
        let left = args.explore.saturating_sub(trials.len());
        let count = left.min(args.at_once).max(1);
        let proposed: Vec<[usize; NETWORKS]> = (0..count)
            .map(|ahead| {
                let mut known = trials.clone();
                known.extend((0..ahead).map(|_| Trial { widths: [0; NETWORKS], error: None }));
                next_widths(&known, args.explore, args.seed)
            })
            .collect::<Result<_, _>>()?;
        let found: Vec<Trial> = proposed
            .into_par_iter()
            .map(|widths| Trial { widths, error: error_of(&widths, &settings.training, &data) })
            .collect();
        for trial in found {
            progress
                .advance(&trial.error.map_or("broke off".to_owned(), |e| format!("{e:.2} mg/dL")));
            trials.push(trial);
        }
        let ended = Ended { settings: settings.clone(), trials: trials.clone() };
        checkpoint.write(&serde_json::to_vec(&ended)?)?;
    }
    let best = best(&trials).context("every training broke off")?;
    let width = |c: Compartment| (c.name().to_owned(), best.widths[c as usize]);
    let widths = BTreeMap::from(Compartment::ALL.map(width));
    let said: String = widths.iter().map(|(name, width)| format!("{name} {width} ")).collect();
    let error = best.error.unwrap_or(f64::NAN);
    output.write_document(&WidthSearch {
        best: BestWidths { balanced_error_mg_dl: best.error, widths },
        config: serde_json::to_value(&settings)?,
        data_sha256: data.sha256,
        explore: args.explore,
        networks: Compartment::ALL.map(|compartment| compartment.name().to_owned()).to_vec(),
        schema: WidthSearch::SCHEMA.to_owned(),
        trials,
    })?;
    let place = output.finish()?;
    checkpoint.remove();
    progress.finish(&format!(
        "{said}with a balanced error of {error:.2} mg/dL, {}",
        place.join(WidthSearch::FILE).display()
    ));
    Ok(())
}
