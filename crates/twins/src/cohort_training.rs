//! Twins for the people of a cohort.

use std::collections::BTreeMap;
use std::sync::Arc;

use cohort::{Cohort, Person, Window};
use nn_statespace::PopulationModel;
use physiology::STEPS_PER_HOUR;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rayon::prelude::*;
use serde_json::json;

use crate::error::TwinError;
use crate::fingerprint::windows_fingerprint;
use crate::gains::{self, Doses};
use crate::heart_rate::HeartRateScaler;
use crate::inputs::{InputSet, MissingContext};
use crate::prepared::PreparedWindow;
use crate::protocol::{Exclusion, PersonWindows, Protocol, inputs_within, measured};
use crate::residual::ResidualNetwork;
use crate::start::{SteadyStates, window_starts_with};
use crate::training::{Trained, TrainingPlan, train};
use crate::twin::{Twin, TwinCard};

/// What to build twins from.
#[derive(Debug, Clone)]
pub struct TwinRecipe {
    /// The population model, frozen.
    pub population: Arc<PopulationModel>,
    /// How records are cut.
    pub protocol: Protocol,
    /// How networks are trained.
    pub plan: TrainingPlan,
    /// Which personal inputs the networks see.
    pub inputs: InputSet,
    /// Whether twins have gains of their own on doses.
    pub doses: Doses,
    /// Seed of all people; each gets a stream of its own by index.
    pub seed: u64,
}

/// One person's twin, or why there is none.
#[derive(Debug, Clone)]
pub struct PersonTwin {
    /// The person's identifier.
    pub person_id: String,
    /// Complete training windows, those held out not counted.
    pub windows_train: usize,
    /// Complete test windows.
    pub windows_test: usize,
    /// The twin, or the reason for leaving the person out.
    pub result: Result<BuiltTwin, Exclusion>,
}

/// A twin with its training history.
#[derive(Debug, Clone)]
pub struct BuiltTwin {
    /// The twin.
    pub twin: Twin,
    /// How its network came about.
    pub trained: Trained,
    /// Personal inputs that the training windows lacked.
    pub missing: MissingContext,
    /// Training windows whose start is no steady state although one was asked for.
    pub not_at_rest: usize,
}

/// Builds a twin for each person, in parallel; the result does not depend on the number of threads.
///
/// `finished` hears of each person when they are done, in any order.
///
/// # Errors
/// The first error by order of people.
pub fn build_twins(
    cohort: &Cohort,
    recipe: &TwinRecipe,
    finished: &(dyn Fn(&PersonTwin) + Sync),
) -> Result<Vec<PersonTwin>, TwinError> {
    build_twins_from(cohort, recipe, &BTreeMap::new(), finished)
}

/// The same; training goes on from a person's twin in `before`, if there is one, as in
/// [`build_twin`].
///
/// # Errors
/// The first error by order of people.
pub fn build_twins_from(
    cohort: &Cohort,
    recipe: &TwinRecipe,
    before: &BTreeMap<String, Twin>,
    finished: &(dyn Fn(&PersonTwin) + Sync),
) -> Result<Vec<PersonTwin>, TwinError> {
    let steady = SteadyStates::new(&*recipe.population);
    let results: Vec<Result<PersonTwin, TwinError>> = cohort
        .people
        .par_iter()
        .enumerate()
        .map(|(index, person)| {
            let built = build_with(index, person, recipe, before.get(&person.id), &steady);
            if let Ok(built) = &built {
                finished(built);
            }
            built
        })
        .collect();
    results.into_iter().collect()
}

/// Builds one person's twin; `index` is their place in the cohort.
///
/// With `before`, training goes on from that twin's network and keeps its heart-rate scaler, so
/// that new days refine it instead of starting over.
///
/// # Errors
/// Those of [`PersonWindows::new`], [`window_starts`](crate::window_starts), [`PreparedWindow::new`] and [`train`], and
/// [`TwinError::OtherPerson`] if `before` is someone else's, and [`TwinError::SeenDays`] if it was trained on days that
/// are to test now.
pub fn build_twin(
    index: usize,
    person: &Person,
    recipe: &TwinRecipe,
    before: Option<&Twin>,
) -> Result<PersonTwin, TwinError> {
    build_with(index, person, recipe, before, &SteadyStates::new(&*recipe.population))
}

fn build_with(
    index: usize,
    person: &Person,
    recipe: &TwinRecipe,
    before: Option<&Twin>,
    steady: &SteadyStates<'_, PopulationModel>,
) -> Result<PersonTwin, TwinError> {
    if let Some(twin) = before.filter(|twin| twin.card.person_id != person.id) {
        return Err(TwinError::OtherPerson {
            person: person.id.clone(),
            twin: twin.card.person_id.clone(),
        });
    }
    let days = recipe.protocol.training_days_of(&person.record);
    let seen = before.and_then(|twin| twin.training_days_of(&person.record));
    if let Some(seen) = seen.filter(|seen| *seen > days) {
        return Err(TwinError::SeenDays { seen, days });
    }
    let cut = PersonWindows::new(index, person, &recipe.protocol)?;
    let result = match cut.excluded {
        Some(reason) => Err(reason),
        None => Ok(train_person(index, person, &cut, recipe, before, steady)
            .map_err(|error| error.of_person(&person.id))?),
    };
    Ok(PersonTwin {
        person_id: person.id.clone(),
        windows_train: cut.train.len(),
        windows_test: cut.test.len(),
        result,
    })
}

fn train_person(
    index: usize,
    person: &Person,
    cut: &PersonWindows,
    recipe: &TwinRecipe,
    before: Option<&Twin>,
    steady: &SteadyStates<'_, PopulationModel>,
) -> Result<BuiltTwin, TwinError> {
    // Which steps some training window holds.
    let mut covered = vec![false; cut.inputs.len()];
    for window in &cut.train {
        covered[window.range()].fill(true);
    }
    let scaler = match before {
        Some(twin) => twin.heart_rate_scaler,
        None => {
            let inputs = cut.inputs.iter().zip(&covered).filter(|(_, covered)| **covered);
            HeartRateScaler::fit(inputs.filter_map(|(i, _)| i.context.heart_rate_over_baseline))?
        }
    };
    let mut seeds = ChaCha8Rng::seed_from_u64(recipe.seed);
    seeds.set_stream(index as u64);
    let (weights_seed, order_seed) = (seeds.random(), seeds.random());
    let (mut population, mut start) = match before {
        Some(twin) => (Arc::clone(&twin.population), twin.residual.clone()),
        None => (Arc::clone(&recipe.population), ResidualNetwork::untrained(weights_seed)),
    };
    let starts = |population: &PopulationModel, windows: &[Window]| {
        let steps: Vec<usize> = windows.iter().map(|window| window.start).collect();
        let steady = steady.of(population);
        window_starts_with(&steady, person, &cut.inputs, &steps, cut.start, cut.mean_basal)
    };
    // Windows made ready, and how many starts are not at rest.
    let prepared = |population: &PopulationModel, windows: &[Window]| {
        let starts = starts(population, windows)?;
        let windows = windows.iter().zip(starts.states);
        let prepared = windows.map(|(window, start)| {
            let inputs = inputs_within(&cut.inputs, window).to_vec();
            let (glucose, scaler) = (measured(person, window)?, scaler.as_ref());
            PreparedWindow::new(population, inputs, &glucose, start, scaler, recipe.inputs)
        });
        let prepared: Result<Vec<PreparedWindow>, TwinError> = prepared.collect();
        Ok::<_, TwinError>((prepared?, starts.not_at_rest))
    };
    let (mut windows, not_at_rest) = prepared(&population, &cut.train)?;
    if before.is_none() && recipe.doses == Doses::Scaled {
        let hours = covered.iter().filter(|covered| **covered).count() / STEPS_PER_HOUR;
        let fitted = gains::fit(&recipe.population, &windows, hours as f64, &|population| {
            Ok(starts(population, &cut.train)?.states)
        })?;
        let own = PopulationModel::clone(&recipe.population).with_dose_gains(fitted.gains)?;
        population = Arc::new(own);
        windows = prepared(&population, &cut.train)?.0;
        start.add_to_output(fitted.rate);
    }
    let (held_out, _) = prepared(&population, &cut.held_out)?;
    let trained = train(&population, start, &windows, &held_out, &recipe.plan, order_seed)?;
    let card = TwinCard {
        person_id: person.id.clone(),
        origin: match before {
            Some(_) => "trained further on new days of the person's record".to_owned(),
            None => "trained on the person's record".to_owned(),
        },
        version: env!("CARGO_PKG_VERSION").to_owned(),
        training_data_sha256: Some(windows_fingerprint(&windows)),
        training: Some(json!({
            "plan": recipe.plan,
            "training_days": recipe.protocol.training_days,
            "held_out": recipe.protocol.held_out,
            "window_steps": recipe.protocol.training.len,
            "window_overlap": recipe.protocol.training.overlap,
            "start": recipe.protocol.start,
            "dose_gains": population.scaler().dose_gains(),
            "windows": windows.len(),
            "held_out_windows": held_out.len(),
            "kept_epoch": trained.kept,
            "seed": recipe.seed,
            "stream": index,
            "continued_from": before.map(|twin| &twin.card.training_data_sha256),
        })),
    };
    let missing = MissingContext::count(windows.iter().flat_map(PreparedWindow::inputs));
    let twin = Twin {
        population,
        residual: trained.network.clone(),
        heart_rate_scaler: scaler,
        inputs: recipe.inputs,
        card,
    };
    Ok(BuiltTwin { twin, trained, missing, not_at_rest })
}
