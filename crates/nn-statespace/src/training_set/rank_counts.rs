//! The robust scaler of more rows than one would sort, by counting.
//!
//! Numbers of single precision can be numbered in their order from 0 to 2^32 - 1. A first pass over
//! the rows counts, for each signal, the upper 16 bits of those numbers; this tells in which of the
//! 65,536 bins each order statistic lies that the median and the quartiles are interpolated from. A
//! second pass counts the lower 16 bits within those bins, and so finds it exactly. Counts add up
//! whatever the order of the rows: the result does not depend on how they are shared out.

use physiology::Compartment;
use rayon::iter::ParallelIterator;
use rayon::slice::ParallelSlice;

use super::compact_run::CompactRun;
use crate::error::ModelError;
use crate::scaler::{CentreAndScale, Scaler};
use crate::signal::Signal;

/// Values of 16 bits.
const BINS: usize = 1 << 16;
/// What a robust scaler asks for: quartiles and median.
const SHARES: [f64; 3] = [0.25, 0.5, 0.75];

/// Place of a number among all numbers of single precision, in the order of [`f32::total_cmp`].
fn ordinal(value: f32) -> u32 {
    let bits = value.to_bits();
    if bits >> 31 == 0 { bits | (1 << 31) } else { !bits }
}

/// The number at a place; the inverse of [`ordinal`].
fn number(ordinal: u32) -> f32 {
    f32::from_bits(if ordinal >> 31 == 1 { ordinal & !(1 << 31) } else { !ordinal })
}

/// The first pass over the training rows.
#[derive(Debug, Clone)]
pub struct CoarseCounts {
    /// A count for each bin of each signal, by [`Signal::row`].
    counts: Vec<Vec<u64>>,
}

impl Default for CoarseCounts {
    fn default() -> Self {
        Self::new()
    }
}

impl CoarseCounts {
    /// No rows yet. Takes 6 MB.
    #[must_use]
    pub fn new() -> Self {
        Self { counts: Signal::all().map(|_| vec![0; BINS]).collect() }
    }

    /// Counts the rows of a run.
    pub fn add(&mut self, run: &CompactRun) {
        for (signal, counts) in Signal::all().zip(&mut self.counts) {
            run.values(signal).for_each(|value| counts[(ordinal(value) >> 16) as usize] += 1);
        }
    }

    /// Adds what another thread has counted.
    pub fn merge(&mut self, other: &Self) {
        for (counts, others) in self.counts.iter_mut().zip(&other.counts) {
            add_up(counts, others);
        }
    }

    /// What the second pass has to look for.
    ///
    /// # Errors
    /// [`ModelError::NoRows`] if nothing was counted.
    pub fn narrow(&self) -> Result<FineCounts, ModelError> {
        let sought = |(signal, counts): (Signal, &Vec<u64>)| {
            Sought::new(counts).ok_or(ModelError::NoRows(signal))
        };
        let each = Signal::all().zip(&self.counts);
        Ok(FineCounts { sought: each.map(sought).collect::<Result<_, _>>()? })
    }
}

/// The second pass over the same rows.
#[derive(Debug, Clone)]
pub struct FineCounts {
    sought: Vec<Sought>,
}

impl FineCounts {
    /// Counts the rows of a run, which must be one of the first pass.
    pub fn add(&mut self, run: &CompactRun) {
        for (signal, sought) in Signal::all().zip(&mut self.sought) {
            run.values(signal).for_each(|value| sought.count(value));
        }
    }

    /// Adds what another thread has counted.
    ///
    /// # Panics
    /// If the two were not made by the same [`CoarseCounts::narrow`].
    pub fn merge(&mut self, other: &Self) {
        for (sought, others) in self.sought.iter_mut().zip(&other.sought) {
            assert_eq!(sought.rows, others.rows, "counts of another first pass");
            for (bin, other) in sought.bins.iter_mut().zip(&others.bins) {
                add_up(&mut bin.counts, &other.counts);
            }
        }
    }

    /// The scaler: what [`Scaler::fit`] gives for the same rows.
    ///
    /// # Errors
    /// [`ModelError::NoRows`] with a signal for which the two passes saw different rows.
    pub fn scaler(&self) -> Result<Scaler, ModelError> {
        Scaler::try_from_fn(|signal| {
            // The latent compartment is not scaled.
            if signal == Signal::State(Compartment::C1) {
                return Ok(CentreAndScale { centre: 0.0, scale: 1.0 });
            }
            let sought = &self.sought[signal.row()];
            let quantile = |share| sought.quantile(share).ok_or(ModelError::NoRows(signal));
            let range = quantile(SHARES[2])? - quantile(SHARES[0])?;
            let scale = if range > 0.0 { range } else { 1.0 };
            Ok(CentreAndScale { centre: quantile(SHARES[1])?, scale })
        })
    }
}

impl Scaler {
    /// Fits the scaler to training runs in memory: what [`Scaler::fit`] gives for them, without a
    /// copy of a column and on all threads.
    ///
    /// # Errors
    /// [`ModelError::NoRows`] without rows.
    pub fn fit_compact(runs: &[CompactRun]) -> Result<Self, ModelError> {
        let coarse = counted(runs, &CoarseCounts::new(), CoarseCounts::add, CoarseCounts::merge);
        counted(runs, &coarse.narrow()?, FineCounts::add, FineCounts::merge).scaler()
    }
}

/// Counts the runs on all threads, each from `nothing` on.
fn counted<C: Clone + Send + Sync>(
    runs: &[CompactRun],
    nothing: &C,
    add: fn(&mut C, &CompactRun),
    merge: fn(&mut C, &C),
) -> C {
    let share = runs.len().div_ceil(rayon::current_num_threads()).max(1);
    let each = runs.par_chunks(share).map(|runs| {
        let mut own = nothing.clone();
        runs.iter().for_each(|run| add(&mut own, run));
        own
    });
    let both = |mut all: C, own: C| {
        merge(&mut all, &own);
        all
    };
    each.reduce(|| nothing.clone(), both)
}

/// The bins of a signal in which order statistics lie.
#[derive(Debug, Clone)]
struct Sought {
    rows: u64,
    /// Ascending.
    bins: Vec<Bin>,
}

#[derive(Debug, Clone)]
struct Bin {
    /// Upper 16 bits of the numbers in it.
    upper: u32,
    /// Rows in lower bins.
    below: u64,
    /// Rows in this bin.
    rows: u64,
    /// By lower 16 bits.
    counts: Vec<u64>,
}

impl Sought {
    /// `None` without rows.
    fn new(counts: &[u64]) -> Option<Self> {
        let rows: u64 = counts.iter().sum();
        let last = rows.checked_sub(1)?;
        let ranks: Vec<u64> =
            SHARES.into_iter().flat_map(|share| neighbours(share, last).0).collect();
        let (mut bins, mut below) = (Vec::new(), 0);
        for (upper, &rows) in (0..).zip(counts) {
            if ranks.iter().any(|rank| (below..below + rows).contains(rank)) {
                bins.push(Bin { upper, below, rows, counts: vec![0; BINS] });
            }
            below += rows;
        }
        Some(Self { rows, bins })
    }

    fn count(&mut self, value: f32) {
        let ordinal = ordinal(value);
        if let Some(bin) = self.bins.iter_mut().find(|bin| bin.upper == ordinal >> 16) {
            bin.counts[(ordinal & 0xFFFF) as usize] += 1;
        }
    }

    /// Interpolated linearly between order statistics; `None` if the passes do not fit together.
    fn quantile(&self, share: f64) -> Option<f64> {
        let ([below, above], weight) = neighbours(share, self.rows.checked_sub(1)?);
        let (below, above) = (self.at_rank(below)?, self.at_rank(above)?);
        Some(below + weight * (above - below))
    }

    /// The value with so many rows before it in ascending order.
    fn at_rank(&self, rank: u64) -> Option<f64> {
        let bin = self.bins.iter().find(|bin| (bin.below..bin.below + bin.rows).contains(&rank))?;
        if bin.counts.iter().sum::<u64>() != bin.rows {
            return None;
        }
        let mut before = bin.below;
        let lower = bin.counts.iter().position(|count| {
            before += count;
            rank < before
        })?;
        Some(f64::from(number((bin.upper << 16) | lower as u32)))
    }
}

/// The ranks between which a quantile lies, and how far it is from the first to the second.
fn neighbours(share: f64, last: u64) -> ([u64; 2], f64) {
    let position = share * last as f64;
    let below = position.floor();
    ([below as u64, (below as u64 + 1).min(last)], position - below)
}

fn add_up(counts: &mut [u64], others: &[u64]) {
    for (count, other) in counts.iter_mut().zip(others) {
        *count += other;
    }
}

#[cfg(test)]
mod tests {
    use super::super::compact_run::tests::example;
    use super::*;
    use crate::training::Run;

    #[test]
    fn numbers_are_numbered_in_their_order() {
        let ascending = [
            f32::NEG_INFINITY,
            f32::MIN,
            -1.0,
            -f32::MIN_POSITIVE,
            -0.0,
            0.0,
            1e-45,
            1.0,
            1.000_000_1,
            f32::MAX,
        ];
        assert!(ascending.is_sorted_by(|a, b| ordinal(*a) < ordinal(*b)));
        for value in ascending {
            assert_eq!(number(ordinal(value)).to_bits(), value.to_bits());
        }
    }

    /// The counted scaler, with the runs shared out among `hands`.
    fn counted(runs: &[CompactRun], hands: usize) -> Result<Scaler, ModelError> {
        let mut coarse = CoarseCounts::new();
        for hand in 0..hands {
            let mut own = CoarseCounts::new();
            runs.iter().skip(hand).step_by(hands).for_each(|run| own.add(run));
            coarse.merge(&own);
        }
        let nothing = coarse.narrow()?;
        let mut fine = nothing.clone();
        for hand in (0..hands).rev() {
            let mut own = nothing.clone();
            runs.iter().skip(hand).step_by(hands).for_each(|run| own.add(run));
            fine.merge(&own);
        }
        fine.scaler()
    }

    #[test]
    fn counting_gives_what_sorting_gives() {
        // Numbers of rows with every remainder by four, so that quartiles fall on and between rows.
        for steps in [1, 2, 3, 40, 41, 42, 43] {
            let given: Vec<_> = (0..5).map(|seed| example(seed, steps + seed as usize)).collect();
            let runs: Vec<Run<'_>> =
                given.iter().map(|(states, inputs)| Run { states, inputs }).collect();
            let sorted = Scaler::fit(&runs).expect("finite");
            let compact: Vec<CompactRun> =
                runs.iter().map(|run| CompactRun::new(*run).expect("finite")).collect();
            for hands in [1, 3] {
                assert_eq!(counted(&compact, hands).expect("rows"), sorted, "{steps}, {hands}");
            }
            assert_eq!(Scaler::fit_compact(&compact).expect("rows"), sorted, "{steps}");
        }
    }

    #[test]
    fn without_rows_there_is_no_scaler() {
        assert!(matches!(CoarseCounts::new().narrow(), Err(ModelError::NoRows(_))));
        assert!(matches!(Scaler::fit_compact(&[]), Err(ModelError::NoRows(_))));
    }

    #[test]
    fn a_second_pass_over_other_rows_is_noticed() {
        let (states, inputs) = example(1, 50);
        let run = CompactRun::new(Run { states: &states, inputs: &inputs }).expect("finite");
        let mut coarse = CoarseCounts::new();
        coarse.add(&run);
        let mut fine = coarse.narrow().expect("rows");
        assert!(fine.scaler().is_err(), "no second pass at all");
        fine.add(&run);
        assert!(fine.scaler().is_ok());
        fine.add(&run);
        assert!(fine.scaler().is_err(), "the run was counted twice");
    }
}
