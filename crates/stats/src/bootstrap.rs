//! Bootstrap with the person as the unit of resampling.
//!
//! Samples of one person are not independent, so a resample draws people with replacement and
//! takes each with all of his or her data; the two-level variant then draws blocks of days within
//! every drawn person. Replicate `i` has its own ChaCha stream derived from (seed, `i`), so that
//! the answer does not depend on the number of threads.
//!
//! ```
//! use stats::Bootstrap;
//!
//! let mean_error = [3.1, 4.0, 2.2, 5.9, 3.3, 4.8, 2.9, 3.6];
//! let plan = Bootstrap { replicates: 2000, level: 0.95, seed: 7 };
//! let estimate = plan.people(&mean_error, |people| {
//!     people.iter().copied().sum::<f64>() / people.len() as f64
//! })?;
//! assert!(estimate.percentile.lower < estimate.value);
//! assert!(estimate.value < estimate.percentile.upper);
//! # Ok::<(), stats::StatsError>(())
//! ```

use std::num::NonZeroUsize;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::StatsError;
use crate::error::{at_least, open_unit};

mod replicates;

pub use replicates::ReplicateMatrix;

/// An interval, both ends included, in the unit of the statistic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

impl Interval {
    /// Whether `value` lies in the interval.
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        self.lower <= value && value <= self.upper
    }
}

/// A statistic with its bootstrap intervals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The statistic on the full sample.
    pub value: f64,
    /// SD of the statistic over the replicates.
    pub standard_error: f64,
    /// Percentile interval.
    pub percentile: Interval,
    /// Bias-corrected and accelerated interval (Efron 1987). `None` where it is undefined: all
    /// replicates on one side of the estimate, or no finite value when a person is left out.
    pub bca: Option<Interval>,
    /// Confidence level of both intervals.
    pub level: f64,
    /// Number of replicates.
    pub replicates: usize,
}

/// How to resample. There is no default: each field changes the result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bootstrap {
    /// Number of replicates; 2,000 and more for 95 % intervals.
    pub replicates: usize,
    /// Confidence level, e.g. 0.95.
    pub level: f64,
    /// Seed of all replicates.
    pub seed: u64,
}

impl Bootstrap {
    /// Interval for one statistic of the people.
    ///
    /// `statistic` is given as many people as there are, some repeated, in any order.
    ///
    /// # Errors
    ///
    /// As [`Bootstrap::people_matrix`].
    pub fn people<P, F>(&self, people: &[P], statistic: F) -> Result<Estimate, StatsError>
    where
        P: Sync,
        F: Fn(&[&P]) -> f64 + Sync,
    {
        self.people_matrix(people, |drawn| vec![statistic(drawn)])?.estimate(0, self.level)
    }

    /// Replicates of several statistics at once, drawn jointly.
    ///
    /// # Errors
    ///
    /// [`StatsError::TooFew`] below two people or two replicates, [`StatsError::OutOfDomain`] for
    /// a level outside (0, 1), [`StatsError::UndefinedReplicate`] and
    /// [`StatsError::RaggedReplicate`] for what the statistic returns.
    pub fn people_matrix<P, F>(
        &self,
        people: &[P],
        statistic: F,
    ) -> Result<ReplicateMatrix, StatsError>
    where
        P: Sync,
        F: Fn(&[&P]) -> Vec<f64> + Sync,
    {
        let everyone: Vec<&P> = people.iter().collect();
        self.run(
            people.len(),
            |kept| statistic(&kept.iter().map(|i| everyone[*i]).collect::<Vec<_>>()),
            |rng| {
                let drawn = draw(rng, people.len()).into_iter().map(|i| everyone[i]);
                statistic(&drawn.collect::<Vec<_>>())
            },
        )
    }

    /// Replicates of several statistics at once, resampling people and then blocks of days within each.
    ///
    /// `people` holds every person's days in their order. A drawn person's days are replaced by
    /// blocks of `block_days` consecutive days, each block starting anywhere, until there are as
    /// many days as before (Künsch 1989); a person with fewer days than a block keeps them all.
    /// A person drawn twice gets two independent sets of days.
    ///
    /// # Errors
    ///
    /// As [`Bootstrap::people_matrix`].
    pub fn people_and_days_matrix<D, F>(
        &self,
        people: &[Vec<D>],
        block_days: NonZeroUsize,
        statistic: F,
    ) -> Result<ReplicateMatrix, StatsError>
    where
        D: Sync,
        F: Fn(&[Vec<&D>]) -> Vec<f64> + Sync,
    {
        let whole = |i: &usize| people[*i].iter().collect::<Vec<&D>>();
        self.run(
            people.len(),
            |kept| statistic(&kept.iter().map(whole).collect::<Vec<_>>()),
            |rng| {
                let drawn = draw(rng, people.len()).into_iter();
                let days = drawn.map(|i| blocks(rng, &people[i], block_days));
                statistic(&days.collect::<Vec<_>>())
            },
        )
    }

    /// Full sample, jackknife over people, and replicates in parallel.
    fn run(
        &self,
        people: usize,
        of_people: impl Fn(&[usize]) -> Vec<f64> + Sync,
        of_resample: impl Fn(&mut ChaCha8Rng) -> Vec<f64> + Sync,
    ) -> Result<ReplicateMatrix, StatsError> {
        open_unit("level", self.level)?;
        at_least(2, "people", people)?;
        at_least(2, "replicates", self.replicates)?;
        let all: Vec<usize> = (0..people).collect();
        let estimates = of_people(&all);
        let left_out: Vec<Vec<f64>> = (0..people)
            .into_par_iter()
            .map(|out| {
                let kept: Vec<usize> = all.iter().copied().filter(|i| *i != out).collect();
                of_people(&kept)
            })
            .collect();
        let rows: Vec<Vec<f64>> = (0..self.replicates)
            .into_par_iter()
            .map(|replicate| of_resample(&mut stream(self.seed, replicate)))
            .collect();
        ReplicateMatrix::new(estimates, rows, left_out)
    }
}

/// The generator of one replicate: one ChaCha stream each, whatever thread it runs on.
fn stream(seed: u64, replicate: usize) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(replicate as u64);
    rng
}

/// `n` indices below `n`, with replacement.
fn draw(rng: &mut ChaCha8Rng, n: usize) -> Vec<usize> {
    (0..n).map(|_| rng.random_range(0..n)).collect()
}

/// Moving blocks of consecutive days, cut to the number of days there are.
fn blocks<'a, D>(rng: &mut ChaCha8Rng, days: &'a [D], block: NonZeroUsize) -> Vec<&'a D> {
    let block = block.get().min(days.len());
    let mut drawn: Vec<&D> = Vec::with_capacity(days.len());
    while drawn.len() < days.len() {
        let start = rng.random_range(0..=days.len() - block);
        let wanted = block.min(days.len() - drawn.len());
        drawn.extend(&days[start..start + wanted]);
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_keep_neighbours_together_and_the_number_of_days() {
        let days: Vec<usize> = (0..14).collect();
        let block = NonZeroUsize::new(3).expect("3 > 0");
        for replicate in 0..50 {
            let drawn = blocks(&mut stream(1, replicate), &days, block);
            assert_eq!(drawn.len(), 14);
            for piece in drawn.chunks(3) {
                assert!(piece.windows(2).all(|pair| *pair[1] == pair[0] + 1), "{drawn:?}");
            }
        }
    }

    #[test]
    fn a_block_longer_than_the_record_keeps_it_whole() {
        let block = NonZeroUsize::new(7).expect("7 > 0");
        assert_eq!(blocks(&mut stream(1, 0), &[5, 6, 7], block), [&5, &6, &7]);
        assert!(blocks::<u8>(&mut stream(1, 0), &[], block).is_empty());
    }

    #[test]
    fn every_replicate_draws_something_else() {
        let first = draw(&mut stream(3, 0), 20);
        assert_eq!(first, draw(&mut stream(3, 0), 20));
        assert_ne!(first, draw(&mut stream(3, 1), 20));
        assert_ne!(first, draw(&mut stream(4, 0), 20));
    }
}
