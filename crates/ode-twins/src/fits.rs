//! All fits of one person, in the form in which they are kept.

use cohort::Person;
use nn_statespace::PopulationModel;
use ode_sim::personal::{FACTORS, Factor};
use ode_sim::{OdeParameters, OdePlant};
use physiology::Kilograms;
use serde::{Deserialize, Serialize};
use twins::{PersonWindows, Protocol, TwinLoss};

use crate::closest::{Candidate, closest};
use crate::error::OdeTwinError;
use crate::posterior::{ChainDiagnostics, Sampling, maximum_a_posteriori, sample_posterior};
use crate::sensitivities::{SensitivitySearch, search_sensitivities, with_sensitivities};
use crate::windows::FitWindows;

/// What is fitted and how.
#[derive(Debug, Clone, PartialEq)]
pub struct FitRecipe {
    /// How records are cut; the same as for twins.
    pub protocol: Protocol,
    /// The loss of the first two methods; the same that trains twins.
    pub loss: TwinLoss,
    /// The virtual population.
    pub candidates: Vec<Candidate>,
    /// The search for sensitivities.
    pub search: SensitivitySearch,
    /// The sampling of the posterior.
    pub sampling: Sampling,
    /// Of the windows that do not overlap, every how many-th feeds the posterior.
    pub posterior_stride: usize,
    /// Seed of all people; each gets streams of its own by index.
    pub seed: u64,
}

/// A body of the ODE model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Fitted {
    /// Model parameters.
    pub parameters: OdeParameters,
    /// Weight by which doses are divided, kg.
    pub weight_kg: f64,
    /// Mean training loss, the same for all methods.
    pub loss: f64,
}

impl Fitted {
    /// The plant as the authors run it.
    #[must_use]
    pub fn plant(&self) -> OdePlant {
        OdePlant::reproduction(self.parameters, Kilograms(self.weight_kg))
    }
}

/// The posterior in the form in which it is kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PosteriorSummary {
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
    pub draws: Vec<OdeParameters>,
}

/// Every fit of one person.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OdeFits {
    /// The person.
    pub person_id: String,
    /// The closest of the virtual population, and its name there.
    pub closest: Fitted,
    /// What the population calls it.
    pub closest_id: String,
    /// The sensitivities of Bayesian optimisation.
    pub bayesian_optimisation: Fitted,
    /// Factors on S_f1, S_f2 and S_f3 behind them.
    pub sensitivity_factors: [f64; 3],
    /// The most probable parameters.
    pub maximum_a_posteriori: Fitted,
    /// What is known around them.
    pub posterior: PosteriorSummary,
}

impl OdeFits {
    /// The plants of the posterior's kept draws.
    #[must_use]
    pub fn posterior_plants(&self) -> Vec<OdePlant> {
        let weight = Kilograms(self.maximum_a_posteriori.weight_kg);
        let draws = self.posterior.draws.iter();
        draws.map(|parameters| OdePlant::reproduction(*parameters, weight)).collect()
    }
}

/// Fits one person; `index` is their place in the cohort.
///
/// # Errors
/// Those of each fit.
pub fn fit_person(
    index: usize,
    person: &Person,
    cut: &PersonWindows,
    population: &PopulationModel,
    recipe: &FitRecipe,
) -> Result<OdeFits, OdeTwinError> {
    let windows =
        FitWindows::training(person, cut, recipe.protocol.start, recipe.loss, population)?;
    let weight_kg = windows.weight().0;
    let seed = recipe.seed.wrapping_mul(1_000_003).wrapping_add(index as u64);

    let chosen = closest(&windows, &recipe.candidates)?;
    let candidate = &recipe.candidates[chosen.place];
    let found = search_sensitivities(&windows, &recipe.search, seed)?;
    let evidence = windows.apart(recipe.posterior_stride);
    let mode = maximum_a_posteriori(&evidence)?;
    let posterior = sample_posterior(&evidence, &mode, &recipe.sampling, seed)?;
    let at_mode = OdePlant::reproduction(mode.parameters(), windows.weight());
    Ok(OdeFits {
        person_id: person.id.clone(),
        closest: Fitted {
            parameters: candidate.parameters,
            weight_kg: candidate.weight.0,
            loss: chosen.loss,
        },
        closest_id: candidate.id.clone(),
        bayesian_optimisation: Fitted {
            parameters: with_sensitivities(found.factors),
            weight_kg,
            loss: found.loss,
        },
        sensitivity_factors: found.factors,
        maximum_a_posteriori: Fitted {
            parameters: mode.parameters(),
            weight_kg,
            loss: windows.loss(&at_mode)?,
        },
        posterior: PosteriorSummary {
            factors: factor_names(),
            mode: mode.factors.0.to_vec(),
            mean: posterior.mean.to_vec(),
            sd: posterior.sd.to_vec(),
            sigma: mode.sigma,
            autoregression: mode.autoregression,
            windows: evidence.len(),
            converged: mode.converged,
            diagnostics: posterior.diagnostics,
            draws: posterior.parameters().collect(),
        },
    })
}

fn factor_names() -> Vec<String> {
    let names: [&str; FACTORS] = Factor::ALL.map(|factor| match factor {
        Factor::Action => "insulin_action",
        Factor::Egp0 => "egp_0",
        Factor::TMaxG => "t_max_g",
        Factor::TMaxI => "t_max_i",
        Factor::AG => "a_g",
        Factor::F01 => "f_01",
    });
    names.map(str::to_owned).to_vec()
}
