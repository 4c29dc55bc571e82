//! All fits of one person, in the form in which they are kept.

use cohort::Person;
use contract::baselines;
use nn_statespace::PopulationModel;
use ode_sim::personal::Factor;
use ode_sim::{OdeParameters, OdePlant};
use physiology::Kilograms;
use twins::{PersonWindows, Protocol, TwinLoss};

use crate::closest::{Candidate, closest};
use crate::error::OdeTwinError;
use crate::posterior::{Sampling, maximum_a_posteriori, sample_posterior};
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

/// A body of the ODE model, with its loss.
pub type Fitted = baselines::Fitted<OdeParameters>;
/// The posterior in the form in which it is kept.
pub type PosteriorSummary = baselines::PosteriorSummary<OdeParameters>;
/// Every fit of one person.
pub type OdeFits = baselines::OdeFits<OdeParameters>;

/// The plant of a fit as the authors run it.
#[must_use]
pub fn plant_of(fitted: &Fitted) -> OdePlant {
    OdePlant::reproduction(fitted.parameters, Kilograms(fitted.weight_kg))
}

/// The plants of the posterior's kept draws.
#[must_use]
pub fn posterior_plants(fits: &OdeFits) -> Vec<OdePlant> {
    let weight = Kilograms(fits.maximum_a_posteriori.weight_kg);
    let draws = fits.posterior.draws.iter();
    draws.map(|parameters| OdePlant::reproduction(*parameters, weight)).collect()
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
    let nominal = OdeParameters::nominal();
    // A body of the person's weight.
    let own = |parameters, loss| Fitted { parameters, weight_kg, loss };
    let at_mode = OdePlant::reproduction(mode.parameters(), windows.weight());
    Ok(OdeFits {
        person_id: person.id.clone(),
        closest: Fitted {
            parameters: candidate.parameters,
            weight_kg: candidate.weight.0,
            loss: chosen.loss,
        },
        closest_id: candidate.id.clone(),
        bayesian_optimisation: own(with_sensitivities(found.factors), found.loss),
        sensitivity_factors: found.factors,
        maximum_a_posteriori: own(mode.parameters(), windows.loss(&at_mode)?),
        posterior: PosteriorSummary {
            factors: Factor::ALL.map(name_in_file).to_vec(),
            mode: mode.factors.0.to_vec(),
            mean: posterior.mean.to_vec(),
            sd: posterior.sd.to_vec(),
            sigma: mode.sigma,
            autoregression: mode.autoregression,
            windows: evidence.measured.len(),
            converged: mode.converged,
            diagnostics: posterior.diagnostics,
            draws: posterior.draws.iter().map(|draw| draw.applied_to(&nominal)).collect(),
        },
    })
}

fn name_in_file(factor: Factor) -> String {
    match factor {
        Factor::Action => "insulin_action",
        one => one.parameter(),
    }
    .to_owned()
}
