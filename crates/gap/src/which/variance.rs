//! Random differences between days and between blocks: estimated, then integrated out.
//!
//! Insulin action, the gut and the sensor differ from day to day in everybody. A driver that is a property
//! of days (a short night, an old set) has as many observations as there are days, not steps. The
//! random factors of [`RANDOM`] are normal with mean zero, one a day and one a block, acting through the
//! same signatures as the constant ones. Their spreads are estimated over the cohort by marginal
//! likelihood; their exact integral replaces A and b of a day by A - C'M^-1 C and b - C'M^-1 c.

use std::collections::BTreeMap;

use faer::linalg::solvers::Llt;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par, Side};
use rayon::prelude::*;

use super::folds::{FOLDS, fold};
use super::statistics::{DayStatistics, RANDOM, Sums, TestStatistics, add_gram, mirror};

/// Number of random factors.
const COUNT: usize = RANDOM.len();
/// Spreads that are tried; a spread of the flux is in units of 0.016 mmol/kg/min, nominal production.
const GRID: [f64; 9] = [0.0, 0.02, 0.04, 0.07, 0.1, 0.15, 0.2, 0.3, 0.45];
/// Names of the scales of days and of blocks within them.
pub(super) const SCALES: [&str; 2] = ["day", "block"];
/// Sweeps over the spreads.
const SWEEPS: usize = 2;

/// Spreads of the random factors, log or relative; or a number for each of them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Spreads {
    /// From day to day.
    pub(super) day: [f64; COUNT],
    /// From block to block within a day.
    pub(super) block: [f64; COUNT],
}

impl Spreads {
    /// Every spread under the name of its port and its scale.
    pub(super) fn by_name(&self) -> BTreeMap<String, f64> {
        let of_scale = |(scale, spreads): (&'static str, [f64; COUNT])| {
            let both = RANDOM.into_iter().zip(spreads);
            both.map(move |(random, s)| (format!("{}/{scale}", random.port.name()), s))
        };
        SCALES.into_iter().zip([self.day, self.block]).flat_map(of_scale).collect()
    }

    /// One of them: those from day to day come first.
    fn get_mut(&mut self, index: usize) -> &mut f64 {
        match index.checked_sub(COUNT) {
            None => &mut self.day[index],
            Some(factor) => &mut self.block[factor],
        }
    }
}

/// Random factors of a day that are not held at zero: block and factor, `None` for the whole day.
pub(super) fn active(spreads: &Spreads, blocks: usize) -> Vec<(Option<usize>, usize, f64)> {
    let within = (0..blocks).flat_map(|block| {
        (0..COUNT).map(move |factor| (Some(block), factor, spreads.block[factor]))
    });
    let whole = (0..COUNT).map(|factor| (None, factor, spreads.day[factor]));
    within.chain(whole).filter(|(_, _, spread)| *spread > 0.0).collect()
}

/// I + D Z'WZ D, factored; D holds the spreads.
pub(super) fn factored(
    day: &DayStatistics,
    random: &[usize; COUNT],
    active: &[(Option<usize>, usize, f64)],
) -> Llt<f64> {
    let gram = |block: usize, a: usize, b: usize| day.za[block][(a, random[b])];
    let entry = |i: usize, j: usize| {
        let ((block_i, a, s), (block_j, b, t)) = (active[i], active[j]);
        let product = match (block_i, block_j) {
            (Some(k), Some(l)) if k != l => 0.0,
            (Some(k), _) | (None, Some(k)) => gram(k, a, b),
            (None, None) => (0..day.za.len()).map(|k| gram(k, a, b)).sum(),
        };
        s * t * product + f64::from(u8::from(i == j))
    };
    let m = Mat::from_fn(active.len(), active.len(), entry);
    m.llt(Side::Lower).expect("the identity plus a product of a matrix with itself")
}

/// D Z'WX (active, columns) and D times the scores of the random factors.
pub(super) fn crossed(
    day: &DayStatistics,
    active: &[(Option<usize>, usize, f64)],
) -> (Mat<f64>, Mat<f64>) {
    let columns = day.za.first().map_or(0, Mat::ncols);
    let blocks = 0..day.za.len();
    let c = Mat::from_fn(active.len(), columns, |i, column| match active[i] {
        (Some(k), factor, s) => s * day.za[k][(factor, column)],
        (None, factor, s) => s * blocks.clone().map(|k| day.za[k][(factor, column)]).sum::<f64>(),
    });
    let z = Mat::from_fn(active.len(), 1, |i, _| match active[i] {
        (Some(k), factor, s) => s * day.zb[k][factor],
        (None, factor, s) => s * blocks.clone().map(|k| day.zb[k][factor]).sum::<f64>(),
    });
    (c, z)
}

/// A person's A and b by fold, with the random factors of every day integrated out.
pub(super) fn marginal(person: &TestStatistics, spreads: &Spreads) -> Vec<Sums> {
    (0..FOLDS)
        .map(|index| {
            let mut sums = person.folds[index].clone();
            for day in &person.days[fold(person.days.len(), index)] {
                let active = active(spreads, day.za.len());
                if active.is_empty() {
                    continue;
                }
                // With M = LL': C'M^-1 C is the Gram of L^-1 C.
                let factor = factored(day, &person.random, &active);
                let (mut c, mut z) = crossed(day, &active);
                solve_lower_triangular_in_place(factor.L(), c.as_mut(), Par::Seq);
                solve_lower_triangular_in_place(factor.L(), z.as_mut(), Par::Seq);
                add_gram(&mut sums.a, c.as_ref(), -1.0);
                let taken = c.transpose() * &z;
                for (k, b) in sums.b.iter_mut().enumerate() {
                    *b -= taken[(k, 0)];
                }
            }
            mirror(&mut sums.a);
            sums
        })
        .collect()
}

/// What a likelihood of the spreads needs of a day: Grams of the random factors' signatures, and what is left
/// of their scores once the constant directions are allowed for; by block, and over the whole day.
struct DayLikelihood {
    grams: Vec<[[f64; COUNT]; COUNT]>,
    scores: Vec<[f64; COUNT]>,
    whole_gram: [[f64; COUNT]; COUNT],
    whole_score: [f64; COUNT],
}

impl DayLikelihood {
    fn of(day: &DayStatistics, random: &[usize; COUNT], fixed: &[f64]) -> Self {
        let gram = |za: &Mat<f64>| -> [[f64; COUNT]; COUNT] {
            std::array::from_fn(|a| std::array::from_fn(|b| za[(a, random[b])]))
        };
        let left = |(za, zb): (&Mat<f64>, &Vec<f64>)| -> [f64; COUNT] {
            std::array::from_fn(|row| {
                zb[row] - fixed.iter().enumerate().map(|(k, x)| za[(row, k)] * x).sum::<f64>()
            })
        };
        let grams: Vec<_> = day.za.iter().map(gram).collect();
        let scores: Vec<_> = day.za.iter().zip(&day.zb).map(left).collect();
        let whole = |a: usize, b: usize| -> f64 { grams.iter().map(|gram| gram[a][b]).sum() };
        let whole_gram = std::array::from_fn(|a| std::array::from_fn(|b| whole(a, b)));
        let whole_score = std::array::from_fn(|row| scores.iter().map(|score| score[row]).sum());
        Self { grams, scores, whole_gram, whole_score }
    }

    /// Log likelihood of the spreads, nats, up to a constant: with M = I + D Z'WZ D = LL' and scores z, half the
    /// square of the inverse of L times Dz, less the logarithms of the diagonal of L.
    fn likelihood(&self, workspace: &mut Workspace) -> f64 {
        let Workspace { active, starts, l, solved, .. } = workspace;
        let n = active.len();
        let mut total = 0.0;
        for (i, (block, a, s)) in active.iter().enumerate() {
            for (j, (other, b, t)) in active[..=i].iter().enumerate() {
                let product = match (block, other) {
                    (Some(k), Some(l)) if k != l => continue,
                    (Some(k), _) | (None, Some(k)) => self.grams[*k][*a][*b],
                    (None, None) => self.whole_gram[*a][*b],
                };
                // The row of a block is 0 outside of it.
                let first = starts[j];
                let (row, above) = (&l[i * n + first..i * n + j], &l[j * n + first..j * n + j]);
                let taken: f64 = row.iter().zip(above).map(|(x, y)| x * y).sum();
                let left = s * t * product - taken;
                // The identity plus a product of a matrix with itself: the diagonal stays above 1.
                l[i * n + j] = if i == j { (1.0 + left).sqrt() } else { left / l[j * n + j] };
            }
            let score = block.map_or(self.whole_score[*a], |k| self.scores[k][*a]);
            let own = starts[i];
            let row = l[i * n + own..i * n + i].iter().zip(&solved[own..]);
            let taken: f64 = row.map(|(x, y)| x * y).sum();
            solved[i] = (s * score - taken) / l[i * n + i];
            total += 0.5 * solved[i] * solved[i] - l[i * n + i].ln();
        }
        total
    }
}

/// Scratch space that the likelihoods of one day after another share as long as they have as many blocks.
struct Workspace {
    blocks: usize,
    active: Vec<(Option<usize>, usize, f64)>,
    /// Where the block of each factor starts; a whole day is answered by all blocks.
    starts: Vec<usize>,
    /// Scratch space for L and for the solution.
    l: Vec<f64>,
    solved: Vec<f64>,
}

impl Workspace {
    fn of(spreads: &Spreads, blocks: usize) -> Self {
        let active = active(spreads, blocks);
        let n = active.len();
        let mut starts = vec![0; n];
        for i in 1..n {
            if let (Some(block), _, _) = active[i] {
                starts[i] = if active[i - 1].0 == Some(block) { starts[i - 1] } else { i };
            }
        }
        // What lies between two blocks is 0 and stays so.
        let (l, solved) = (vec![0.0; n * n], vec![0.0; n]);
        Self { blocks, active, starts, l, solved }
    }
}

/// Spreads that are found where nothing is missing, in the order of [`RANDOM`]: about the largest that were
/// estimated in experiments with worlds of both generators without an effect. They include what a plant of another
/// structure makes of a body. For insulin action they agree with people: the insulin that closed loops gave varied
/// by 20 to 30 % between days (Ruan et al., Diabetes Care 2016;39:830).
const USUAL: Spreads = Spreads {
    day: [0.2, 0.07, 0.2, 0.02, 0.07, 0.04, 0.15],
    block: [0.04, 0.0, 0.07, 0.0, 0.0, 0.04, 0.0],
};

/// The cohort's spreads, and the evidence for each.
#[derive(Default)]
pub(super) struct Estimated {
    /// The best spreads together.
    pub(super) spreads: Spreads,
    /// Log likelihood of each spread over that of the usual one, nats; 0 if it is no larger.
    pub(super) beyond_usual: Spreads,
}

/// Estimates the spreads by climbing one at a time over [`GRID`]. `fixed` holds each person's constant
/// directions, one number a column.
pub(super) fn estimate(
    people: &[&TestStatistics],
    fixed: &[Vec<f64>],
    start: Spreads,
) -> Estimated {
    let left: Vec<Vec<DayLikelihood>> = people
        .par_iter()
        .zip(fixed)
        .map(|(person, fixed)| {
            person.days.iter().map(|day| DayLikelihood::of(day, &person.random, fixed)).collect()
        })
        .collect();
    let of = |spreads: &Spreads| -> f64 {
        let of_person = |days: &Vec<DayLikelihood>| {
            let mut workspace = Workspace::of(spreads, 0);
            let of_day = |day: &DayLikelihood| {
                let blocks = day.grams.len();
                if workspace.blocks != blocks {
                    workspace = Workspace::of(spreads, blocks);
                }
                day.likelihood(&mut workspace)
            };
            days.iter().map(of_day).sum()
        };
        let each: Vec<f64> = left.par_iter().map(of_person).collect();
        each.iter().sum()
    };
    let mut spreads = start;
    let mut best = of(&spreads);
    for sweep in 0..SWEEPS {
        for index in 0..2 * COUNT {
            let here = *spreads.get_mut(index);
            let at = GRID.iter().position(|g| *g >= here).unwrap_or(0);
            for (k, value) in GRID.into_iter().enumerate() {
                if value == here || sweep > 0 && k.abs_diff(at) > 1 {
                    continue;
                }
                let mut tried = spreads;
                *tried.get_mut(index) = value;
                let found = of(&tried);
                if found > best {
                    (best, spreads) = (found, tried);
                }
            }
        }
    }
    let mut beyond_usual = Spreads::default();
    for index in 0..2 * COUNT {
        let (mut without, mut usual) = (spreads, USUAL);
        let usually = *usual.get_mut(index);
        let spread = std::mem::replace(without.get_mut(index), usually);
        if spread > usually {
            *beyond_usual.get_mut(index) = best - of(&without);
        }
    }
    Estimated { spreads, beyond_usual }
}

#[cfg(test)]
mod tests {
    use faer::linalg::solvers::Solve;

    use super::*;

    /// A day of two blocks in as many columns as there are random factors.
    fn day() -> DayStatistics {
        let signature = |step: usize, k: usize| (0.37 * (step * (k + 2)) as f64 + k as f64).sin();
        let block = |block: usize| {
            let steps = 30 * block..30 * (block + 1);
            let residual = |step: usize| (0.9 * step as f64).cos() + 2.0 * signature(step, 3);
            let sum = |f: &dyn Fn(usize) -> f64| steps.clone().map(f).sum::<f64>();
            let za = Mat::from_fn(COUNT, COUNT, |a, b| sum(&|t| signature(t, a) * signature(t, b)));
            let zb: Vec<f64> =
                (0..COUNT).map(|a| sum(&|t| signature(t, a) * residual(t))).collect();
            (za, zb)
        };
        let (za, zb) = (0..2).map(block).unzip();
        DayStatistics { za, zb }
    }

    #[test]
    fn the_likelihood_is_that_of_a_dense_solution() {
        let (day, random) = (day(), std::array::from_fn(|k| k));
        let left = DayLikelihood::of(&day, &random, &[0.0; COUNT]);
        for spreads in [
            USUAL,
            Spreads { day: [0.0, 0.1, 0.0, 0.45, 0.0, 0.0, 0.2], block: [0.3; COUNT] },
            Spreads { day: [0.0; COUNT], block: [0.0; COUNT] },
        ] {
            let active = active(&spreads, day.za.len());
            let expected = if active.is_empty() {
                0.0
            } else {
                let factor = factored(&day, &random, &active);
                let (_, z) = crossed(&day, &active);
                let explained = (z.transpose() * factor.solve(&z))[(0, 0)];
                let logs: f64 = (0..active.len()).map(|i| factor.L()[(i, i)].ln()).sum();
                0.5 * explained - logs
            };
            let found = left.likelihood(&mut Workspace::of(&spreads, left.grams.len()));
            assert!((found - expected).abs() <= 1e-9 * expected.abs(), "{found} {expected}"); // rounding
        }
    }

    #[test]
    fn constant_directions_leave_their_share_of_the_scores() {
        let (day, random) = (day(), std::array::from_fn(|k| k));
        let mut fixed = [0.0; COUNT];
        fixed[3] = 2.0;
        let (with, without) = (
            DayLikelihood::of(&day, &random, &fixed),
            DayLikelihood::of(&day, &random, &[0.0; COUNT]),
        );
        for ((left, all), gram) in
            with.whole_score.iter().zip(without.whole_score).zip(without.whole_gram)
        {
            let expected = all - 2.0 * gram[3];
            assert!((left - expected).abs() < 1e-10); // rounding of sums of 60
        }
        let wide = Spreads { day: [0.0, 0.0, 0.0, 0.45, 0.0, 0.0, 0.0], block: [0.0; COUNT] };
        let of =
            |left: &DayLikelihood| left.likelihood(&mut Workspace::of(&wide, left.grams.len()));
        assert!(of(&without) > of(&with) + 10.0);
    }
}
