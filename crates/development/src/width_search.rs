//! Which hidden widths to try next: a Latin hypercube first, then Bayesian optimisation (paper: 50 iterations each).
//!
//! A proposal follows from seed and trials so far alone, so that a search goes on from a list of them.

use bayesopt::{Range, SearchError, latin_hypercube};
pub use contract::widths::Trial;
use nn_statespace::training::{Provenance, TrainingConfig, train};
use nn_statespace::{PerCompartment, Widths};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use crate::error::DevelopmentError;
use crate::training_data::TrainingData;

/// Networks.
pub const NETWORKS: usize = 10;
/// Fewest and most hidden units (paper).
pub const RANGE: (usize, usize) = (4, 256);

/// The widths to try after these trials, of which the first `explore` explore.
///
/// The optimiser sees the logarithms of widths and of errors: a width of 8 differs from 4 as 256 does from 128, and one
/// training that failed must not hide the differences between good ones.
///
/// # Errors
/// [`DevelopmentError::Search`].
pub fn next_widths(
    trials: &[Trial],
    explore: usize,
    seed: u64,
) -> Result<[usize; NETWORKS], DevelopmentError> {
    let ranges = ranges().map_err(DevelopmentError::Search)?;
    if trials.len() < explore {
        let points = latin_hypercube(&ranges, explore, seed);
        return Ok(rounded(&points[trials.len()]));
    }
    let worst = trials.iter().filter_map(|t| t.error).fold(1.0, f64::max);
    let tried: Vec<(Vec<f64>, f64)> = trials
        .iter()
        .map(|trial| {
            let point = trial.widths.iter().map(|width| (*width as f64).log2()).collect();
            (point, trial.error.unwrap_or(2.0 * worst).ln())
        })
        .collect();
    // Its own seed for each proposal: the same search again would look at the same points.
    let number = trials.len() as u64;
    let own = seed.wrapping_mul(1_000_003).wrapping_add(number);
    let proposed = bayesopt::propose(&tried, &ranges, own).map_err(DevelopmentError::Search)?;
    let mut widths = rounded(&proposed);
    // The same widths again would teach nothing.
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(1 + number);
    while trials.iter().any(|trial| trial.widths == widths) {
        let network = rng.random_range(0..NETWORKS);
        widths[network] = rng.random_range(RANGE.0..=RANGE.1);
    }
    Ok(widths)
}

/// The lowest balanced error of a training with these widths, mg/dL; `None` if it broke off.
#[must_use]
pub fn error_of(
    widths: &[usize; NETWORKS],
    config: &TrainingConfig,
    data: &TrainingData,
) -> Option<f64> {
    let widths = Widths::new(PerCompartment::from_fn(|c| widths[c as usize])).ok()?;
    let provenance = Provenance { origin: String::new(), training_data_sha256: None };
    let trained =
        train(config, &widths, &data.training, &data.validation, provenance, |_| {}).ok()?;
    let errors = trained.report.epochs.iter().map(|epoch| epoch.validation.balanced());
    errors.filter(|error| error.is_finite()).min_by(f64::total_cmp)
}

/// The trial with the lowest error; `None` if every training broke off.
#[must_use]
pub fn best(trials: &[Trial]) -> Option<&Trial> {
    let errors = trials.iter().filter_map(|trial| Some((trial, trial.error?)));
    errors.min_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(trial, _)| trial)
}

/// The range of the logarithm of each width to the base of 2.
fn ranges() -> Result<[Range; NETWORKS], SearchError> {
    Ok([Range::new((RANGE.0 as f64).log2(), (RANGE.1 as f64).log2())?; NETWORKS])
}

fn rounded(log2: &[f64]) -> [usize; NETWORKS] {
    std::array::from_fn(|k| (log2[k].exp2().round() as usize).clamp(RANGE.0, RANGE.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Best where every network has 32 units, as a bowl in their logarithms.
    fn bowl(widths: &[usize; NETWORKS]) -> f64 {
        let square = |width: &usize| ((*width as f64).log2() - 5.0).powi(2);
        (0.1 * widths.iter().map(square).sum::<f64>()).exp()
    }

    fn searched(explore: usize, exploit: usize, seed: u64) -> Vec<Trial> {
        let mut trials = Vec::new();
        for number in 0..explore + exploit {
            let widths = next_widths(&trials, explore, seed).expect("a proposal");
            let error = (number != 3).then(|| bowl(&widths)); // one breaks off
            trials.push(Trial { widths, error });
        }
        trials
    }

    fn explored(points: usize, seed: u64) -> Vec<[usize; NETWORKS]> {
        let cube = latin_hypercube(&ranges().expect("rises"), points, seed);
        cube.iter().map(|point| rounded(point)).collect()
    }

    #[test]
    fn exploration_covers_the_range_of_every_width() {
        let points = explored(20, 4);
        for network in 0..NETWORKS {
            let mut widths: Vec<usize> = points.iter().map(|point| point[network]).collect();
            widths.sort_unstable();
            assert!(widths[0] <= 5 && widths[19] >= 205, "{widths:?}");
            // The eleventh of twenty parts: 2^5 to 2^5.3.
            assert!((32..=40).contains(&widths[10]), "{widths:?}");
        }
        assert_ne!(points, explored(20, 5));
    }

    #[test]
    fn proposals_get_better_than_exploration_and_follow_from_the_trials() {
        let trials = searched(12, 8, 1);
        let best =
            |trials: &[Trial]| trials.iter().filter_map(|t| t.error).fold(f64::INFINITY, f64::min);
        let (explored, found) = (best(&trials[..12]), best(&trials[12..]));
        assert!(found < explored, "{found} after {explored}");
        for stop in [5, 12, 17] {
            let again = next_widths(&trials[..stop], 12, 1).expect("a proposal");
            assert_eq!(again, trials[stop].widths, "after {stop}");
        }
        for (place, trial) in trials.iter().enumerate() {
            assert!(trials[..place].iter().all(|other| other.widths != trial.widths));
        }
    }
}
