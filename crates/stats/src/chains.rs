//! Whether chains of a sampler agree, and how many independent draws they are worth.
//!
//! Rank-normalised split R-hat and effective sample sizes of bulk and tails after Vehtari, Gelman,
//! Simpson, Carpenter and Bürkner, "Rank-normalization, folding, and localization: an improved R-hat
//! for assessing convergence of MCMC", Bayesian Analysis 16 (2021), 667-718.

use statrs::distribution::{ContinuousCDF, Normal};

use crate::StatsError;
use crate::error::{at_least, finite};
use crate::moments::{mean, mean_and_sd};
use crate::quantile::quantile;

/// Fewest draws of a chain: two halves of which a lag can be taken.
const FEWEST_DRAWS: usize = 8;
/// Quantiles whose effective sample sizes stand for the tails.
const TAILS: [f64; 2] = [0.05, 0.95];

/// What the draws of one quantity say about the chains that made them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChainSummary {
    /// The larger of the rank-normalised split R-hats of draws and of folded draws; near 1 where the
    /// chains cannot be told apart.
    pub r_hat: f64,
    /// Effective sample size of the rank-normalised draws, for means and medians.
    pub ess_bulk: f64,
    /// The smaller effective sample size of the 5 % and 95 % quantiles.
    pub ess_tail: f64,
}

/// Diagnoses one quantity over at least two chains of equal length.
///
/// Where every draw is the same, nothing can be told: R-hat is 1 and both sizes are the number of
/// draws.
///
/// # Errors
/// [`StatsError::TooFew`] below two chains of eight draws, [`StatsError::Unpaired`] for chains of
/// different length, [`StatsError::NonFinite`].
pub fn diagnose(chains: &[Vec<f64>]) -> Result<ChainSummary, StatsError> {
    at_least(2, "chains", chains.len())?;
    let length = chains[0].len();
    for chain in chains {
        if chain.len() != length {
            return Err(StatsError::Unpaired { left: length, right: chain.len() });
        }
        finite("draw", chain)?;
    }
    at_least(FEWEST_DRAWS, "draws", length)?;
    let halves = split(chains);
    let mut all: Vec<f64> = halves.iter().flatten().copied().collect();
    all.sort_by(f64::total_cmp);
    if all.iter().all(|value| *value == all[0]) {
        let count = all.len() as f64;
        return Ok(ChainSummary { r_hat: 1.0, ess_bulk: count, ess_tail: count });
    }
    let ranked = rank_normalised(&halves);
    let middle = quantile(&all, 0.5);
    let folded = rank_normalised(&each_draw(&halves, |value| (value - middle).abs()));
    let tail = |q: f64| {
        let level = quantile(&all, q);
        effective_size(&each_draw(&halves, |value| f64::from(u8::from(value <= level))))
    };
    Ok(ChainSummary {
        r_hat: r_hat(&ranked).max(r_hat(&folded)),
        ess_bulk: effective_size(&ranked),
        ess_tail: TAILS.map(tail).into_iter().fold(f64::INFINITY, f64::min),
    })
}

/// The chains with `value` of each draw in its place.
fn each_draw(chains: &[Vec<f64>], value: impl Fn(f64) -> f64) -> Vec<Vec<f64>> {
    chains.iter().map(|chain| chain.iter().map(|draw| value(*draw)).collect()).collect()
}

/// Each chain cut in two halves; an odd draw in the middle is left out.
fn split(chains: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let half = chains[0].len() / 2;
    chains
        .iter()
        .flat_map(|chain| [chain[..half].to_vec(), chain[chain.len() - half..].to_vec()])
        .collect()
}

/// Draws replaced by normal scores of their ranks over all chains (Vehtari et al., Eq. 14); equal
/// draws share their mean rank.
fn rank_normalised(chains: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let length = chains[0].len();
    let all: Vec<f64> = chains.iter().flatten().copied().collect();
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by(|a, b| all[*a].total_cmp(&all[*b]));
    let mut scores = vec![0.0; all.len()];
    let normal = Normal::standard();
    let mut first = 0;
    for tied in order.chunk_by(|a, b| all[*a] == all[*b]) {
        let last = first + tied.len() - 1;
        let rank = 0.5 * (first + last) as f64 + 1.0;
        let score = normal.inverse_cdf((rank - 0.375) / (all.len() as f64 + 0.25));
        for index in tied {
            scores[*index] = score;
        }
        first = last + 1;
    }
    scores.chunks_exact(length).map(<[f64]>::to_vec).collect()
}

/// Variances within chains and of the whole, both with draws counted once (Vehtari et al., Eqs. 1 to
/// 3).
fn variances(chains: &[Vec<f64>]) -> (f64, f64) {
    let n = chains[0].len() as f64;
    let moments: Vec<(f64, f64)> = chains.iter().map(|chain| mean_and_sd(chain)).collect();
    let within = mean(&moments.iter().map(|(_, sd)| sd * sd).collect::<Vec<f64>>());
    let means: Vec<f64> = moments.iter().map(|(mean, _)| *mean).collect();
    let between = mean_and_sd(&means).1.powi(2);
    (within, within * (n - 1.0) / n + between)
}

fn r_hat(chains: &[Vec<f64>]) -> f64 {
    let (within, whole) = variances(chains);
    if within > 0.0 { (whole / within).sqrt() } else { f64::INFINITY }
}

/// Effective sample size by Geyer's initial monotone sequence (Vehtari et al., Eqs. 7 to 13), at most
/// `N log10 N`.
fn effective_size(chains: &[Vec<f64>]) -> f64 {
    let (count, length) = (chains.len() as f64, chains[0].len());
    let total = count * length as f64;
    let (within, whole) = variances(chains);
    if whole <= 0.0 {
        return total;
    }
    let correlation = |lag: usize| -> f64 {
        let covariances: Vec<f64> = chains.iter().map(|chain| autocovariance(chain, lag)).collect();
        1.0 - (within - mean(&covariances)) / whole
    };
    // Sums of neighbouring correlations fall and stay positive in a reversible chain. Of the last pair
    // that is looked at, the even term counts, and once.
    let (mut even, mut odd) = (1.0, correlation(1));
    let mut pairs = vec![even + odd];
    let mut lag = 1;
    while lag + 3 < length && even + odd > 0.0 {
        (even, odd) = (correlation(lag + 1), correlation(lag + 2));
        pairs.push(even + odd);
        lag += 2;
    }
    let mut least = f64::INFINITY;
    let mut sum = even.max(0.0);
    for pair in &pairs[..(lag - 1) / 2] {
        least = least.min(*pair);
        sum += 2.0 * least;
    }
    let time = (sum - 1.0).max(1.0 / total.log10());
    total / time
}

/// Mean product of draws `lag` apart, with the number of all draws as divisor.
fn autocovariance(chain: &[f64], lag: usize) -> f64 {
    let centre = mean(chain);
    let products = chain.iter().zip(&chain[lag..]).map(|(a, b)| (a - centre) * (b - centre));
    products.sum::<f64>() / chain.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four chains of 200 draws: what a linear congruential generator (Knuth's MMIX) gives between
    /// -0.5 and 0.5, carried on with a coefficient; the last chain is moved.
    fn chains(coefficient: f64, shift: f64) -> Vec<Vec<f64>> {
        let mut seed = 7_u64;
        let mut draw = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        (0..4)
            .map(|chain| {
                let mut now = 0.0;
                let moved = if chain == 3 { shift } else { 0.0 };
                (0..200)
                    .map(|_| {
                        now = coefficient * now + draw();
                        now + moved
                    })
                    .collect()
            })
            .collect()
    }

    #[test]
    fn figures_are_those_of_arviz() {
        // arviz 0.21.0: rhat(x), ess(x, method="bulk"), ess(x, method="tail") of the same numbers.
        let cases = [
            (0.0, 0.0, [0.9997480156874784, 750.9332930910759, 743.8674378689037]),
            (0.7, 0.0, [1.0197224640859928, 167.95789968073774, 313.007002327602]),
            (0.7, 1.0, [1.4611820591271767, 8.388377808918237, 66.71898832035012]),
        ];
        for (coefficient, shift, arviz) in cases {
            let found = diagnose(&chains(coefficient, shift)).expect("chains");
            for (ours, theirs) in [found.r_hat, found.ess_bulk, found.ess_tail].iter().zip(arviz) {
                // Both in f64; theirs takes products by a Fourier transform.
                assert!((ours - theirs).abs() < 1e-8 * theirs, "{found:?} {arviz:?}");
            }
        }
    }

    #[test]
    fn chains_that_cannot_be_judged_are_refused() {
        let some = chains(0.5, 0.0);
        assert!(diagnose(&some[..1]).is_err());
        assert!(diagnose(&[vec![1.0; 7], vec![2.0; 7]]).is_err());
        assert!(diagnose(&[vec![1.0; 9], vec![2.0; 8]]).is_err());
        let broken = vec![some[0].clone(), vec![f64::NAN; 200]];
        assert!(diagnose(&broken).is_err());
        let still = diagnose(&[vec![3.0; 10], vec![3.0; 10]]).expect("the same");
        assert_eq!((still.r_hat, still.ess_bulk), (1.0, 20.0));
    }
}
