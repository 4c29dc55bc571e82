//! The member without hidden units: a logistic regression of each thing on few statistics.
//!
//! It reads less than a network and errs in other worlds. Minus the log likelihood with a ridge is convex; blocks of one
//! thing's weights take Newton steps in turn.

use candle_core::{DType, Device, Tensor};
use faer::linalg::solvers::Solve as _;
use faer::{Mat, Side};
use rayon::prelude::*;

use crate::error::PosteriorError;
use crate::joint::{Joint, is_pair};

/// Rounds over all blocks, at most, and the gain of the log likelihood in a round that ends them, nats.
const MOST_ROUNDS: usize = 30;
const LEAST_GAIN: f64 = 0.05;
/// Log odds of everything at the start: things are rare.
const START: f64 = -3.0;
/// Least curvature by a bias and by the number for pairs, which have no penalty: a table without such worlds has none.
const LEAST_CURVATURE: f64 = 0.01;
/// Halvings of a step before a block is left as it is.
const HALVINGS: i32 = 8;

/// Logistic regressions of the effects and of the kinds outside the library, coupled by the number for pairs.
#[derive(Debug, Clone)]
pub(crate) struct Regression {
    /// Weights in the order of [`Self::shapes`]; 0 where a regression does not read a statistic.
    pub(crate) weights: Vec<Tensor>,
}

impl Regression {
    /// Shapes of the weights, by name.
    pub(crate) fn shapes(statistics: usize, odds: usize) -> [(&'static str, Vec<usize>); 3] {
        [("weight", vec![statistics, odds]), ("bias", vec![odds]), ("pair", vec![1])]
    }

    /// Log odds of what was read: (cohorts, statistics).
    pub(crate) fn odds(&self, read: &Tensor) -> Result<Tensor, PosteriorError> {
        Ok(read.matmul(&self.weights[0])?.broadcast_add(&self.weights[1])?)
    }

    /// The number for pairs.
    pub(crate) fn pair(&self) -> &Tensor {
        &self.weights[2]
    }

    /// Fits the regressions. `read` is (rows, statistics), `missing` (rows, things), and `columns` are the statistics of
    /// each thing, of which the first `effects` can act in pairs.
    pub(crate) fn fitted(
        read: &[f32],
        missing: &[Vec<bool>],
        columns: &[Vec<usize>],
        effects: usize,
        ridge: f64,
    ) -> Result<Self, PosteriorError> {
        let (rows, things) = (missing.len(), columns.len());
        let width = read.len() / rows.max(1);
        let of_thing = |columns: &Vec<usize>| {
            Mat::from_fn(rows, columns.len() + 1, |row, k| match columns.get(k) {
                Some(column) => f64::from(read[row * width + column]),
                None => 1.0,
            })
        };
        let read: Vec<Mat<f64>> = columns.iter().map(of_thing).collect();
        let mut fit = Fit {
            missing,
            effects,
            ridge,
            weights: columns.iter().map(|c| vec![0.0; c.len()]).collect(),
            biases: vec![START; things],
            pair: 0.0,
            odds: vec![vec![START; things]; rows],
        };
        let mut loss = fit.loss();
        for _ in 0..MOST_ROUNDS {
            let before = loss;
            for (thing, read) in read.iter().enumerate() {
                loss = fit.step_of(thing, read, loss);
            }
            loss = fit.step_of_pair(loss);
            if before - loss < LEAST_GAIN {
                break;
            }
        }
        let mut weight = vec![0.0_f32; width * things];
        for (thing, (columns, own)) in columns.iter().zip(&fit.weights).enumerate() {
            for (column, value) in columns.iter().zip(own) {
                weight[column * things + thing] = *value as f32;
            }
        }
        let of = |values: &[f64]| Tensor::new(values, &Device::Cpu)?.to_dtype(DType::F32);
        let weight = Tensor::from_vec(weight, (width, things), &Device::Cpu)?;
        Ok(Self { weights: vec![weight, of(&fit.biases)?, of(&[fit.pair])?] })
    }
}

struct Fit<'a> {
    missing: &'a [Vec<bool>],
    effects: usize,
    ridge: f64,
    weights: Vec<Vec<f64>>,
    biases: Vec<f64>,
    pair: f64,
    /// By row and thing.
    odds: Vec<Vec<f64>>,
}

impl Fit<'_> {
    /// Minus the log likelihood, and the penalties.
    fn loss(&self) -> f64 {
        let of_row = |(odds, missing): (&Vec<f64>, &Vec<bool>)| -> f64 {
            let own: f64 = odds.iter().zip(missing).filter(|(_, is)| **is).map(|(a, _)| a).sum();
            let extra = if is_pair(missing) { self.pair } else { 0.0 };
            Joint::of(odds, self.effects, self.pair).nothing.ln() + own + extra
        };
        let likelihood: Vec<f64> = self.odds.par_iter().zip(self.missing).map(of_row).collect();
        let squares: f64 = self.weights.iter().flatten().map(|w| w * w).sum();
        0.5 * self.ridge * squares - likelihood.iter().sum::<f64>()
    }

    /// A Newton step of one thing's weights and bias; the loss after it.
    fn step_of(&mut self, thing: usize, read: &Mat<f64>, loss: f64) -> f64 {
        let probabilities: Vec<f64> = self
            .odds
            .par_iter()
            .map(|odds| Joint::of(odds, self.effects, self.pair).each[thing])
            .collect();
        let count = read.ncols();
        let last = count - 1;
        let apart = Mat::from_fn(read.nrows(), 1, |row, _| {
            probabilities[row] - f64::from(u8::from(self.missing[row][thing]))
        });
        let weighted = Mat::from_fn(read.nrows(), count, |row, k| {
            let p = probabilities[row];
            p * (1.0 - p) * read[(row, k)]
        });
        let mut curvature = read.transpose() * &weighted;
        let mut slope = read.transpose() * &apart;
        for k in 0..last {
            curvature[(k, k)] += self.ridge;
            slope[(k, 0)] += self.ridge * self.weights[thing][k];
        }
        curvature[(last, last)] += LEAST_CURVATURE;
        let Ok(root) = curvature.llt(Side::Lower) else { return loss };
        let step = root.solve(&slope);
        let moved = read * &step;
        let (weights, bias) = (self.weights[thing].clone(), self.biases[thing]);
        let before: Vec<f64> = self.odds.iter().map(|odds| odds[thing]).collect();
        self.shortened(loss, |fit, length| {
            for (k, weight) in fit.weights[thing].iter_mut().enumerate() {
                *weight = weights[k] - length * step[(k, 0)];
            }
            fit.biases[thing] = bias - length * step[(last, 0)];
            for (row, odds) in fit.odds.iter_mut().enumerate() {
                odds[thing] = before[row] - length * moved[(row, 0)];
            }
        })
    }

    /// A Newton step of the number for pairs; the loss after it.
    fn step_of_pair(&mut self, loss: f64) -> f64 {
        let (mut slope, mut curvature) = (0.0, LEAST_CURVATURE);
        for (odds, missing) in self.odds.iter().zip(self.missing) {
            let joint = Joint::of(odds, self.effects, self.pair);
            slope += joint.slopes(missing).1;
            curvature += joint.two * (1.0 - joint.two);
        }
        let before = self.pair;
        self.shortened(loss, |fit, length| fit.pair = before - length * slope / curvature)
    }

    /// Takes a step that goes to a share of its length, halved until the loss is not larger, or does not take it; the loss
    /// after it.
    fn shortened(&mut self, loss: f64, go: impl Fn(&mut Self, f64)) -> f64 {
        for halving in 0..HALVINGS {
            go(self, 0.5_f64.powi(halving));
            let after = self.loss();
            if after <= loss {
                return after;
            }
        }
        go(self, 0.0);
        loss
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    /// What is found stands where the slopes of the penalised likelihood are 0.
    #[test]
    fn a_fit_stands_where_no_slope_is_left() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let (rows, ridge) = (400, 5.0);
        let mut read = Vec::new();
        let mut missing = Vec::new();
        for row in 0..rows {
            let acts = [row % 3 == 0, row % 5 == 0];
            missing.push(vec![acts[0], acts[1], row % 7 == 1 && !acts[0] && !acts[1]]);
            let mut noise = || rng.random_range(-1.5f32..1.5);
            read.extend([
                f32::from(u8::from(acts[0])) + noise(),
                f32::from(u8::from(acts[1])) + noise(),
            ]);
        }
        let columns = vec![vec![0], vec![0, 1], vec![]];
        let fit = Regression::fitted(&read, &missing, &columns, 2, ridge).expect("a fit");
        let weight = fit.weights[0].to_vec2::<f32>().expect("weights");
        assert_eq!(weight[1][0], 0.0);
        assert!(weight[0][0] > 0.5 && weight[1][1] > 0.5, "{weight:?}");
        let table = Tensor::from_slice(&read, (rows, 2), &Device::Cpu).expect("a tensor");
        let odds = fit.odds(&table).expect("odds").to_vec2::<f32>().expect("numbers");
        let pair = fit.pair().to_vec1::<f32>().expect("a number");
        let mut slope = f64::from(weight[0][0]) * ridge;
        for ((row, own), missing) in odds.iter().enumerate().zip(&missing) {
            let own: Vec<f64> = own.iter().map(|a| f64::from(*a)).collect();
            let joint = Joint::of(&own, 2, f64::from(pair[0]));
            slope += joint.slopes(missing).0[0] * f64::from(read[2 * row]);
        }
        // Of some 100 nats; rounds end at a gain of 0.05.
        assert!(slope.abs() < 1.0, "{slope}");
    }
}
