//! Draws from the posterior by the No-U-Turn sampler of nuts-rs.

use std::collections::HashMap;

pub use contract::baselines::ChainDiagnostics;
use nuts_rs::{
    Chain as _, CpuLogpFunc, CpuMath, CpuMathError, DiagNutsSettings, HasDims, LogpError,
    Settings as _,
};
use ode_sim::personal::{FACTORS, PersonalFactors};
use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use stats::chains;

use super::MaximumAPosteriori;
use crate::density::{DIMENSION, factors_of, log_density_with_slopes};
use crate::error::OdeTwinError;
use crate::windows::FitWindows;

/// How a posterior is sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sampling {
    /// Chains, each from a start of its own.
    pub chains: usize,
    /// Draws of each chain that tune it and are thrown away.
    pub tune: usize,
    /// Draws of each chain that count.
    pub draws: usize,
    /// Draws handed on as plants, evenly spread over all that count.
    pub kept: usize,
}

impl Sampling {
    /// Four chains of 250 and 250 draws, 40 of them kept.
    #[must_use]
    pub const fn paper() -> Self {
        Self { chains: 4, tune: 250, draws: 250, kept: 40 }
    }

    /// Four chains of 60 and 60 draws, 16 of them kept.
    #[must_use]
    pub const fn quick() -> Self {
        Self { chains: 4, tune: 60, draws: 60, kept: 16 }
    }

    fn check(&self) -> Result<(), OdeTwinError> {
        for (setting, value, least, requirement) in [
            ("chains", self.chains, 2, "at least 2"),
            ("tune", self.tune, 20, "at least 20"),
            ("draws", self.draws, 8, "at least 8"),
            ("kept", self.kept, 1, "at least 1"),
        ] {
            if value < least {
                return Err(OdeTwinError::Setting { setting, value: value as f64, requirement });
            }
        }
        Ok(())
    }
}

/// Draws from a person's posterior.
#[derive(Debug, Clone, PartialEq)]
pub struct Posterior {
    /// Kept draws: log factors.
    pub draws: Vec<PersonalFactors>,
    /// Mean of each log factor over all draws.
    pub mean: [f64; FACTORS],
    /// Standard deviation of each log factor over all draws.
    pub sd: [f64; FACTORS],
    /// Whether to trust them.
    pub diagnostics: ChainDiagnostics,
}

/// Samples the posterior of factors and error model over windows that do not overlap.
///
/// Chains start around the mode, spread as its curvature says, and run along coordinates in which
/// that curvature is a sphere. The result depends on the seed and on nothing else.
///
/// # Errors
/// [`OdeTwinError::Setting`], and [`OdeTwinError::Sampler`] with the sampler's own words.
pub fn sample_posterior(
    windows: &FitWindows<'_>,
    mode: &MaximumAPosteriori,
    sampling: &Sampling,
    seed: u64,
) -> Result<Posterior, OdeTwinError> {
    sampling.check()?;
    let chains: Vec<Result<ChainRun, OdeTwinError>> = (0..sampling.chains)
        .into_par_iter()
        .map(|chain| run_chain(windows, mode, sampling, seed, chain))
        .collect();
    let chains: Vec<ChainRun> = chains.into_iter().collect::<Result<_, _>>()?;
    let mut diagnostics = ChainDiagnostics {
        r_hat: 1.0,
        ess_bulk: f64::INFINITY,
        ess_tail: f64::INFINITY,
        divergences: chains.iter().map(|chain| chain.divergences).sum(),
        gradients: chains.iter().map(|chain| chain.gradients).sum(),
    };
    for coordinate in 0..DIMENSION {
        let series: Vec<Vec<f64>> = chains
            .iter()
            .map(|chain| chain.positions.iter().map(|position| position[coordinate]).collect())
            .collect();
        let found = chains::diagnose(&series)?;
        diagnostics.r_hat = diagnostics.r_hat.max(found.r_hat);
        diagnostics.ess_bulk = diagnostics.ess_bulk.min(found.ess_bulk);
        diagnostics.ess_tail = diagnostics.ess_tail.min(found.ess_tail);
    }
    let all: Vec<PersonalFactors> = chains
        .iter()
        .flat_map(|chain| chain.positions.iter().map(|position| factors_of(&position[..FACTORS])))
        .collect();
    let count = all.len() as f64;
    let mean: [f64; FACTORS] =
        std::array::from_fn(|k| all.iter().map(|draw| draw.0[k]).sum::<f64>() / count);
    let sd = std::array::from_fn(|k| {
        let squares: f64 = all.iter().map(|draw| (draw.0[k] - mean[k]).powi(2)).sum();
        (squares / (count - 1.0)).sqrt()
    });
    let kept = sampling.kept.min(all.len());
    let draws = (0..kept).map(|n| all[n * all.len() / kept]).collect();
    Ok(Posterior { draws, mean, sd, diagnostics })
}

struct ChainRun {
    /// Draws that count: factors in prior standard deviations, then the error model.
    positions: Vec<[f64; DIMENSION]>,
    divergences: usize,
    gradients: u64,
}

fn run_chain(
    windows: &FitWindows<'_>,
    mode: &MaximumAPosteriori,
    sampling: &Sampling,
    seed: u64,
    chain: usize,
) -> Result<ChainRun, OdeTwinError> {
    let gives_up =
        |error: &dyn std::fmt::Display| OdeTwinError::Sampler { chain, reason: error.to_string() };
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(chain as u64);
    let settings = DiagNutsSettings {
        num_tune: sampling.tune as u64,
        num_draws: sampling.draws as u64,
        maxdepth: 6,
        num_chains: sampling.chains,
        seed,
        ..DiagNutsSettings::default()
    };
    let coordinates = Coordinates::new(mode);
    let target = Target { windows, coordinates: coordinates.clone() };
    let mut sampler = settings
        .new_chain(chain as u64, CpuMath::new(target), &mut rng)
        .map_err(|error| gives_up(&error))?;
    let start: Vec<f64> = (0..DIMENSION).map(|_| rng.sample(StandardNormal)).collect();
    sampler.set_position(&start).map_err(|error| gives_up(&error))?;
    let mut run = ChainRun { positions: Vec::new(), divergences: 0, gradients: 0 };
    for draw in 0..sampling.tune + sampling.draws {
        let (position, progress) = sampler.draw().map_err(|error| gives_up(&error))?;
        run.gradients += progress.num_gradients;
        if draw >= sampling.tune {
            run.divergences += usize::from(progress.diverging);
            run.positions.push(coordinates.position(&position));
        }
    }
    Ok(run)
}

/// The coordinates that are sampled: zero is the mode, one is a standard deviation by curvature.
#[derive(Debug, Clone)]
struct Coordinates {
    mode: [f64; DIMENSION],
    root: [[f64; FACTORS]; FACTORS],
    error_sd: [f64; DIMENSION - FACTORS],
}

impl Coordinates {
    fn new(mode: &MaximumAPosteriori) -> Self {
        let unbounded = mode.model.unbounded;
        let n = (mode.observations as f64).max(1.0);
        // Large-sample standard deviations of log sigma and of the transformed coefficient.
        let of_coefficient = (n * (1.0 - mode.model.coefficient().powi(2))).sqrt().recip();
        Self {
            mode: std::array::from_fn(|k| match k.checked_sub(FACTORS) {
                None => mode.standard[k],
                Some(k) => unbounded[k],
            }),
            root: mode.root,
            error_sd: [(2.0 * n).sqrt().recip(), of_coefficient],
        }
    }

    fn position(&self, coordinates: &[f64]) -> [f64; DIMENSION] {
        std::array::from_fn(|k| {
            self.mode[k]
                + match k.checked_sub(FACTORS) {
                    None => (0..=k).map(|j| self.root[k][j] * coordinates[j]).sum::<f64>(),
                    Some(error) => self.error_sd[error] * coordinates[k],
                }
        })
    }

    /// Slopes by the coordinates from those by the position.
    fn slopes(&self, by_position: &[f64; DIMENSION], by_coordinate: &mut [f64]) {
        for (k, slope) in by_coordinate.iter_mut().enumerate() {
            *slope = match k.checked_sub(FACTORS) {
                None => (k..FACTORS).map(|i| self.root[i][k] * by_position[i]).sum(),
                Some(error) => self.error_sd[error] * by_position[k],
            };
        }
    }
}

struct Target<'a> {
    windows: &'a FitWindows<'a>,
    coordinates: Coordinates,
}

impl HasDims for Target<'_> {
    fn dim_sizes(&self) -> HashMap<String, u64> {
        HashMap::from([("unconstrained_parameter".to_owned(), DIMENSION as u64)])
    }
}

/// A plant that cannot be simulated at a trial: the sampler takes it for a divergence.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
struct TargetError(OdeTwinError);

impl LogpError for TargetError {
    fn is_recoverable(&self) -> bool {
        true
    }
}

impl CpuLogpFunc for Target<'_> {
    type LogpError = TargetError;
    type FlowParameters = ();
    type ExpandedVector = Vec<f64>;

    fn dim(&self) -> usize {
        DIMENSION
    }

    fn logp(&mut self, position: &[f64], slopes: &mut [f64]) -> Result<f64, TargetError> {
        let at = self.coordinates.position(position);
        let mut by_position = [0.0; DIMENSION];
        let value =
            log_density_with_slopes(self.windows, &at, &mut by_position).map_err(TargetError)?;
        self.coordinates.slopes(&by_position, slopes);
        Ok(value)
    }

    fn expand_vector<R: rand::Rng + ?Sized>(
        &mut self,
        _rng: &mut R,
        array: &[f64],
    ) -> Result<Vec<f64>, CpuMathError> {
        Ok(array.to_vec())
    }
}
