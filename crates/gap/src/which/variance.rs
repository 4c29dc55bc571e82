//! Random differences between days and between blocks: estimated, then integrated out.
//!
//! Insulin action, the gut and the sensor differ from day to day in everybody. A driver that is a property
//! of days (a short night, an old set) has as many observations as there are days, not steps. The
//! random factors of [`RANDOM`] are normal with mean zero, one a day and one a block, acting through the
//! same signatures as the constant ones. Their spreads are estimated over the cohort by marginal
//! likelihood; their exact integral replaces A and b of a day by A - C'M^-1 C and b - C'M^-1 c.

use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};
use rayon::prelude::*;

use super::held_out::{FOLDS, Folds, fold};
use super::statistics::{Day, Person, RANDOM};

/// Number of random factors.
const COUNT: usize = RANDOM.len();
/// Spreads that are tried; a spread of the flux is in units of 0.016 mmol/kg/min, nominal production.
pub(super) const GRID: [f64; 9] = [0.0, 0.02, 0.04, 0.07, 0.1, 0.15, 0.2, 0.3, 0.45];
/// Sweeps over the spreads.
const SWEEPS: usize = 2;

/// Spreads of the random factors, log or relative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spreads {
    /// From day to day.
    pub(super) day: [f64; COUNT],
    /// From block to block within a day.
    pub(super) block: [f64; COUNT],
}

/// One of the spreads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scale {
    Day,
    Block,
}

impl Spreads {
    fn get_mut(&mut self, scale: Scale, factor: usize) -> &mut f64 {
        match scale {
            Scale::Day => &mut self.day[factor],
            Scale::Block => &mut self.block[factor],
        }
    }
}

/// Random factors of a day that are not held at zero: block and factor, `None` for the whole day.
fn active(spreads: &Spreads, blocks: usize) -> Vec<(Option<usize>, usize, f64)> {
    let within = (0..blocks).flat_map(|block| {
        (0..COUNT).map(move |factor| (Some(block), factor, spreads.block[factor]))
    });
    let whole = (0..COUNT).map(|factor| (None, factor, spreads.day[factor]));
    within.chain(whole).filter(|(_, _, spread)| *spread > 0.0).collect()
}

/// I + D Z'WZ D, factored; D holds the spreads.
fn factored(
    day: &Day,
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
fn crossed(day: &Day, active: &[(Option<usize>, usize, f64)]) -> (Mat<f64>, Mat<f64>) {
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
pub(super) fn marginal(person: &Person, spreads: &Spreads) -> Folds {
    let count = person.days.len();
    let tests = (0..FOLDS)
        .map(|place| {
            let mut sums = person.folds[place].clone();
            for day in &person.days[fold(count, place)] {
                let active = active(spreads, day.za.len());
                if active.is_empty() {
                    continue;
                }
                let factor = factored(day, &person.random, &active);
                let (c, z) = crossed(day, &active);
                let solved = factor.solve(&c);
                sums.a -= c.transpose() * &solved;
                let taken = solved.transpose() * &z;
                for (k, b) in sums.b.iter_mut().enumerate() {
                    *b -= taken[(k, 0)];
                }
            }
            sums
        })
        .collect();
    Folds { days: count, tests }
}

/// What is left of a person's random scores once the constant directions `fixed` are allowed for: one list
/// of scores per block and day.
fn adjusted(person: &Person, fixed: &[f64]) -> Vec<Vec<Vec<f64>>> {
    let adjust = |za: &Mat<f64>, zb: &[f64]| {
        zb.iter()
            .enumerate()
            .map(|(row, b)| {
                b - fixed.iter().enumerate().map(|(k, x)| za[(row, k)] * x).sum::<f64>()
            })
            .collect()
    };
    person
        .days
        .iter()
        .map(|day| day.za.iter().zip(&day.zb).map(|(za, zb)| adjust(za, zb)).collect())
        .collect()
}

/// Log likelihood of the spreads given constant directions, nats, up to a constant.
fn likelihood(person: &Person, scores: &[Vec<Vec<f64>>], spreads: &Spreads) -> f64 {
    let mut total = 0.0;
    for (day, scores) in person.days.iter().zip(scores) {
        let active = active(spreads, day.za.len());
        if active.is_empty() {
            continue;
        }
        let factor = factored(day, &person.random, &active);
        let z = Mat::from_fn(active.len(), 1, |i, _| match active[i] {
            (Some(k), factor, s) => s * scores[k][factor],
            (None, factor, s) => s * scores.iter().map(|block| block[factor]).sum::<f64>(),
        });
        let solved = factor.solve(&z);
        let explained: f64 = (0..active.len()).map(|i| z[(i, 0)] * solved[(i, 0)]).sum();
        let l = factor.L();
        let determinant: f64 = (0..active.len()).map(|i| l[(i, i)].ln()).sum();
        total += 0.5 * explained - determinant;
    }
    total
}

/// Spreads that are found in people in whom nothing is missing, in the order of [`RANDOM`]: insulin action by 12 %
/// between days and 10 % within them, the gut by 12 %; the rest is what a plant of another structure
/// makes of a body.
const USUAL: Spreads = Spreads {
    day: [0.2, 0.07, 0.2, 0.02, 0.07, 0.04, 0.15],
    block: [0.04, 0.0, 0.07, 0.0, 0.0, 0.04, 0.0],
};

/// Evidence for one spread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SpreadEvidence {
    /// Log likelihood of the best spread over that of none, nats.
    pub(super) gain: f64,
    /// Log likelihood of the best spread over that of the usual one, nats; 0 if it is no larger.
    pub(super) beyond_usual: f64,
    /// The best spread.
    pub(super) spread: f64,
}

/// The cohort's spreads, and the evidence for each: by scale and factor.
pub(super) struct Estimated {
    /// The best spreads together.
    pub(super) spreads: Spreads,
    /// From day to day.
    pub(super) day: [SpreadEvidence; COUNT],
    /// From block to block.
    pub(super) block: [SpreadEvidence; COUNT],
}

/// Estimates the spreads by climbing one at a time over [`GRID`]. `fixed` holds each person's constant
/// directions, one number a column.
pub(super) fn estimate(people: &[&Person], fixed: &[Vec<f64>], start: Spreads) -> Estimated {
    let scores: Vec<_> =
        people.par_iter().zip(fixed).map(|(person, fixed)| adjusted(person, fixed)).collect();
    let of = |spreads: &Spreads| -> f64 {
        let each: Vec<f64> = people
            .par_iter()
            .zip(&scores)
            .map(|(person, scores)| likelihood(person, scores, spreads))
            .collect();
        each.iter().sum()
    };
    let mut spreads = start;
    let mut best = of(&spreads);
    for sweep in 0..SWEEPS {
        for scale in [Scale::Day, Scale::Block] {
            for factor in 0..COUNT {
                let here = *spreads.get_mut(scale, factor);
                let at = GRID.iter().position(|g| *g >= here).unwrap_or(0);
                for (place, value) in GRID.into_iter().enumerate() {
                    if value == here || sweep > 0 && place.abs_diff(at) > 1 {
                        continue;
                    }
                    let mut tried = spreads;
                    *tried.get_mut(scale, factor) = value;
                    let found = of(&tried);
                    if found > best {
                        (best, spreads) = (found, tried);
                    }
                }
            }
        }
    }
    let evidence = |scale: Scale| {
        std::array::from_fn(|factor| {
            let mut without = spreads;
            let spread = *without.get_mut(scale, factor);
            *without.get_mut(scale, factor) = 0.0;
            let gain = if spread > 0.0 { best - of(&without) } else { 0.0 };
            let mut usual = USUAL;
            let usually = *usual.get_mut(scale, factor);
            *without.get_mut(scale, factor) = usually;
            let beyond_usual = if spread > usually { best - of(&without) } else { 0.0 };
            SpreadEvidence { gain, beyond_usual, spread }
        })
    };
    Estimated { spreads, day: evidence(Scale::Day), block: evidence(Scale::Block) }
}
