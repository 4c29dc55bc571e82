//! `baselines.json`: the ODE fitted to each person in four ways. `P` are the parameters of a body in the type of
//! who fits them; here they are numbers by name.

use std::collections::BTreeMap;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::Document;

/// The ODE fitted to every person of a cohort.
#[apply(strict!)]
pub struct Baselines<P = BTreeMap<String, f64>> {
    /// `baselines/1`.
    pub schema: String,
    /// Where the virtual patients came from, in words, and how many there are.
    pub candidates: String,
    /// One entry a person who was fitted.
    pub people: Vec<OdeFits<P>>,
}

/// Every fit of one person.
#[apply(strict!)]
pub struct OdeFits<P = BTreeMap<String, f64>> {
    /// The person's identifier.
    pub person_id: String,
    /// The closest of the virtual population.
    pub closest: Fitted<P>,
    /// What the population calls it.
    pub closest_id: String,
    /// The sensitivities of Bayesian optimisation.
    pub bayesian_optimisation: Fitted<P>,
    /// Factors on S_f1, S_f2 and S_f3 behind them.
    pub sensitivity_factors: [f64; 3],
    /// The most probable parameters.
    pub maximum_a_posteriori: Fitted<P>,
    /// What is known around them.
    pub posterior: PosteriorSummary<P>,
}

/// A body of the ODE model.
#[apply(strict!)]
#[derive(Copy)]
pub struct Fitted<P = BTreeMap<String, f64>> {
    /// Model parameters by name, in the units of the ODE model.
    pub parameters: P,
    /// Weight by which doses are divided, kg.
    pub weight_kg: f64,
    /// Mean training loss, the same for all methods.
    pub loss: f64,
}

/// The posterior in the form in which it is kept.
#[apply(strict!)]
pub struct PosteriorSummary<P = BTreeMap<String, f64>> {
    /// Names of the factors, in the order of all lists here.
    pub factors: Vec<String>,
    /// The most probable log factors.
    pub mode: Vec<f64>,
    /// Mean log factors over draws.
    pub mean: Vec<f64>,
    /// Standard deviations of log factors over draws.
    pub sd: Vec<f64>,
    /// Standard deviation of what half an hour adds to a run's error, mg/dL, at the mode.
    pub sigma: f64,
    /// Share of a run's error that is left after half an hour, at the mode.
    pub autoregression: f64,
    /// Windows behind it.
    pub windows: usize,
    /// Whether the search for the mode came to rest.
    pub converged: bool,
    /// Whether to trust the draws.
    pub diagnostics: ChainDiagnostics,
    /// Parameters of the draws that were kept.
    pub draws: Vec<P>,
}

/// Whether the chains agree and how much they say, worst over what is sampled.
#[apply(strict!)]
#[derive(Copy)]
pub struct ChainDiagnostics {
    /// The largest rank-normalised split R-hat; below 1.01 chains agree.
    pub r_hat: f64,
    /// The smallest effective sample size of the bulk.
    pub ess_bulk: f64,
    /// The smallest effective sample size of the tails.
    pub ess_tail: f64,
    /// Trajectories that left the region where the integrator can be trusted.
    pub divergences: usize,
    /// Evaluations of the density with its slopes, tuning included.
    pub gradients: u64,
}

impl<P: Serialize + DeserializeOwned> Document for Baselines<P> {
    const FILE: &'static str = "baselines.json";
    const SCHEMA: &'static str = "baselines/1";
}
