//! The first search: near the best posterior of the first days.

use physiology::STEPS_PER_DAY;

use super::equations::NormalEquations;
use super::{FACTORS, Factor, PersonalFactors, SHORTEST_SHARE, Scored, Setting, Whitening, moved};
use crate::error::GapError;
use crate::whitening::{huber_loss, huber_weight};

/// Spacing of the differences of the first search in log factors. Wide enough to average over the kinks of
/// uptake, renal clearance and production, across which gains jump; the curvature over it is allowed for.
const SPACING: f64 = 0.02;
/// Starting values tried for insulin action, and for how slow insulin and how fast and small meals are:
/// bodies with slow insulin and quick meals are told from their opposite by a distant optimum only.
const ACTION_STARTS: [f64; 5] = [-0.6, -0.3, 0.0, 0.3, 0.6];
const SPEED_STARTS: [f64; 2] = [0.0, 0.5];
/// Scored readings of the first search: three days.
const FIRST_READINGS: usize = 3 * STEPS_PER_DAY;
/// The step, in posterior standard deviations, and the iteration at which it ends.
const FIRST_TOLERANCE: f64 = 1.0;
const FIRST_ITERATIONS: usize = 10;

/// Factors near the best posterior of the first days, by Fisher's scoring.
pub(super) fn near_posterior(setting: &Setting<'_>) -> Result<PersonalFactors, GapError> {
    let end = setting.steps_of(FIRST_READINGS);
    let mut factors = best_start(setting, end)?;
    let mut innovations = setting.innovations(&factors, end)?;
    for _ in 0..FIRST_ITERATIONS {
        let whitening = Whitening::fitted(&innovations);
        let scored = whitening.of(&innovations);
        let equations = NormalEquations::of_posterior(setting, &whitening, &scored, &factors)?;
        let step = equations.step(&factors, setting)?;
        if equations.length(&step) < FIRST_TOLERANCE {
            break;
        }
        let before = whitening.loss(&scored, &factors);
        let mut share = 1.0;
        let better = loop {
            let trial = moved(&factors, &step.map(|value| share * value), setting.bound);
            innovations = setting.innovations(&trial, end)?;
            if whitening.loss(&whitening.of(&innovations), &trial) < before {
                break Some(trial);
            }
            share *= 0.5;
            if share < SHORTEST_SHARE {
                break None;
            }
        };
        let Some(better) = better else { break };
        factors = better;
    }
    Ok(factors)
}

/// The start with the best posterior over the steps before `end`.
fn best_start(setting: &Setting<'_>, end: usize) -> Result<PersonalFactors, GapError> {
    let mut best = (f64::INFINITY, PersonalFactors::default());
    for (action, speed) in ACTION_STARTS.into_iter().flat_map(|a| SPEED_STARTS.map(|s| (a, s))) {
        let mut factors = PersonalFactors::default();
        factors.0[Factor::Action as usize] = action;
        factors.0[Factor::TMaxI as usize] = speed;
        factors.0[Factor::TMaxG as usize] = -speed;
        factors.0[Factor::AG as usize] = -speed;
        let mut loss = factors.prior_loss();
        for i in setting.innovations(&factors, end)?.iter().flatten() {
            loss += huber_loss(i.normalised(), 1.0) + 0.5 * i.variance.ln();
        }
        if loss < best.0 {
            best = (loss, factors);
        }
    }
    Ok(best.1)
}

impl NormalEquations {
    /// Of the posterior, by differences.
    fn of_posterior(
        setting: &Setting<'_>,
        whitening: &Whitening,
        scored: &Scored,
        factors: &PersonalFactors,
    ) -> Result<Self, GapError> {
        let loss = whitening.loss(scored, factors);
        // Towards the prior's mean, so that the difference never leaves the bounds.
        let spacings = factors.0.map(|value| if value > 0.0 { -SPACING } else { SPACING });
        let mut gradient = [0.0; FACTORS];
        let mut slopes = vec![[[0.0; 2]; FACTORS]; scored.len()];
        for (place, spacing) in spacings.into_iter().enumerate() {
            let mut neighbour = *factors;
            neighbour.0[place] += spacing;
            let moved = whitening.of(&setting.innovations(&neighbour, scored.len())?);
            gradient[place] = (whitening.loss(&moved, &neighbour) - loss) / spacing;
            for ((slopes, after), before) in slopes.iter_mut().zip(&moved).zip(scored) {
                if let Some((after, before)) = after.zip(*before) {
                    slopes[place] =
                        [(after.0 - before.0) / spacing, (after.1 - before.1) / spacing];
                }
            }
        }
        let mut curvature = [[0.0; FACTORS]; FACTORS];
        let inverse = whitening.scale.powi(-2);
        for (slopes, scored) in slopes.iter().zip(scored) {
            let Some((w, _)) = scored else { continue };
            let weight = huber_weight(*w, whitening.scale) * inverse;
            for row in 0..FACTORS {
                let [value, variance] = slopes[row];
                let (value, variance) = (weight * value, 0.5 * variance);
                for (entry, other) in curvature[row].iter_mut().zip(slopes) {
                    *entry += value * other[0] + variance * other[1];
                }
            }
        }
        for (place, factor) in Factor::ALL.into_iter().enumerate() {
            curvature[place][place] += factor.prior_sd().powi(-2);
            // The difference is the slope halfway to the neighbour.
            gradient[place] -= 0.5 * spacings[place] * curvature[place][place];
        }
        Ok(Self { curvature, gradient })
    }
}
