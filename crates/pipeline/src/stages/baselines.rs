//! `baselines`: the ODE model fitted to each person in four ways.

use std::path::PathBuf;

use anyhow::{Context as _, Result};
use contract::Document as _;
use ode_sim::OdeParameters;
use ode_sim::vpp_scenario::VirtualPatient;
use ode_twins::{Candidate, FitRecipe, OdeFits, Sampling, SensitivitySearch, fit_person};
use rayon::prelude::*;
use twins::PersonWindows;

use crate::files::read_population;
use crate::people::People;
use crate::stages::simulate::read_patients;
use crate::stages::twin;
use crate::{Manifest, OutputFolder, Profile, Progress};
use ::report::count;

/// Settings of `baselines`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Cohort folder.
    pub cohort: PathBuf,
    /// Population model; its scaling of glucose enters the loss.
    pub model: PathBuf,
    /// The virtual patients of whom the closest is taken, in the columns of the published population;
    /// 99 of our own where it is not given.
    pub patients: Option<PathBuf>,
    /// How much to compute.
    pub profile: Profile,
    /// Days from the start of each record that train; 14 if not given.
    pub training_days: Option<usize>,
    /// Output folder.
    pub out: PathBuf,
    /// Seed of the search and of the sampler.
    pub seed: u64,
}

/// Members of our own virtual population, as many as the published one has, and its seed.
const OWN_PATIENTS: u64 = 99;
const OWN_SEED: u64 = 2019;

/// `baselines.json`, with the parameters of the ODE.
pub(crate) type Baselines = contract::Baselines<OdeParameters>;

/// The manifest of a run with these arguments.
pub(crate) fn manifest(args: &Settings) -> Result<Manifest> {
    let (protocol, _) = twin::protocol(args.profile, args.training_days);
    let config = serde_json::json!({
        "profile": args.profile,
        "training_days": protocol.training_days,
        "published_patients": args.patients.is_some(),
    });
    Manifest::new("baselines", config, Some(args.seed))
        .with_input(&args.cohort)?
        .with_model(&args.model)?
        .with_inputs(&args.patients)
}

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    twin::check_training_days(args.training_days)?;
    let manifest = manifest(args)?;
    let in_use = People::read(&args.cohort)?;
    let cohort = in_use.used();
    let population = read_population(&args.model)?;
    let (protocol, plan) = twin::protocol(args.profile, args.training_days);
    let (search, sampling, posterior_stride) = match args.profile {
        Profile::Quick => (SensitivitySearch::quick(), Sampling::quick(), 2),
        Profile::Paper => (SensitivitySearch::paper(), Sampling::paper(), 1),
    };
    let (described, candidates) = candidates(args)?;
    let recipe = FitRecipe {
        protocol,
        loss: plan.loss,
        candidates,
        search,
        sampling,
        posterior_stride,
        seed: args.seed,
    };
    let output = OutputFolder::begin(&args.out, manifest)?;
    in_use.write(&output)?;
    let progress = Progress::begin("baselines", cohort.people.len());
    let people: Vec<Option<OdeFits>> = cohort
        .people
        .par_iter()
        .enumerate()
        .map(|(index, person)| {
            let of_person = || format!("person '{}'", person.id);
            let cut = PersonWindows::new(index, person, &protocol).with_context(of_person)?;
            let fit = || fit_person(index, person, &cut, &population, &recipe);
            let fits = cut.excluded.is_none().then(fit).transpose().with_context(of_person)?;
            progress.advance(&person.id);
            Ok(fits)
        })
        .collect::<Result<_>>()?;
    let people: Vec<OdeFits> = people.into_iter().flatten().collect();
    let worst = people.iter().map(|fits| fits.posterior.diagnostics.r_hat).fold(1.0, f64::max);
    let fitted = people.len();
    let schema = Baselines::SCHEMA.to_owned();
    output.write_document(&Baselines { schema, candidates: described, people })?;
    let place = output.finish()?;
    progress.finish(&format!(
        "{} fitted, {} left out, largest R-hat {worst:.2}, {}",
        count(fitted, "person", "people"),
        in_use.recorded.people.len() - fitted,
        place.join(Baselines::FILE).display()
    ));
    Ok(())
}

/// The virtual patients, and in words where they came from.
fn candidates(args: &Settings) -> Result<(String, Vec<Candidate>)> {
    let Some(path) = &args.patients else {
        let drawn = ode_sim::population(OWN_SEED, OWN_PATIENTS)
            .context("drawing the virtual population")?;
        let candidates = drawn.into_iter().map(|person| Candidate {
            id: person.index.to_string(),
            parameters: person.parameters,
            weight: person.weight,
        });
        let described = format!(
            "{OWN_PATIENTS} virtual people drawn from the published distributions (not the published 99)"
        );
        return Ok((described, candidates.collect()));
    };
    let patients = read_patients(path)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let described = format!("{} virtual patients of {name}", patients.len());
    let candidates = patients.into_iter().map(|(id, VirtualPatient { parameters, weight, .. })| {
        Candidate { id, parameters, weight }
    });
    Ok((described, candidates.collect()))
}
