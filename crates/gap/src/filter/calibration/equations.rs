//! The linear equations of one step of the search.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::information::{Information, times, with_prior};
use super::{FACTORS, Factor, Factors, LONGEST_MOVE, PersonalFactors, Setting, Square};
use crate::error::GapError;

/// Curvature (6, 6) and gradient (6) of the loss at one set of factors, the prior's included.
pub(super) struct NormalEquations {
    curvature: Square,
    gradient: Factors,
}

impl NormalEquations {
    /// Of the data's loss divided by `dependence`, and the prior.
    pub(super) fn of(
        information: &Information,
        dependence: f64,
        factors: &PersonalFactors,
    ) -> Self {
        let prior = |k: usize| factors.0[k] * Factor::ALL[k].prior_sd().powi(-2);
        let gradient = std::array::from_fn(|k| information.gradient[k] / dependence + prior(k));
        Self { curvature: with_prior(&information.curvature, dependence), gradient }
    }

    /// The step that solves the equations.
    pub(super) fn step(
        &self,
        factors: &PersonalFactors,
        setting: &Setting<'_>,
    ) -> Result<Factors, GapError> {
        let bound = setting.rule.bound;
        // A factor at its bound that the gradient pushes outwards stays there.
        let held: [bool; FACTORS] = std::array::from_fn(|k| {
            factors.0[k].abs() >= bound && -self.gradient[k] * factors.0[k] > 0.0
        });
        let matrix = Mat::from_fn(FACTORS, FACTORS, |row, column| {
            let apart = row != column && (held[row] || held[column]);
            if apart { 0.0 } else { self.curvature[row][column] }
        });
        let right =
            Mat::from_fn(FACTORS, 1, |row, _| if held[row] { 0.0 } else { -self.gradient[row] });
        let solution = matrix.llt(Side::Lower).map_err(|_| setting.singular())?.solve(&right);
        let longest = (0..FACTORS).map(|k| solution[(k, 0)].abs()).fold(LONGEST_MOVE, f64::max);
        // No further than the bound, so that what leads beyond it does not count as a way to go.
        let step: Factors = std::array::from_fn(|k| {
            let step = solution[(k, 0)] * LONGEST_MOVE / longest;
            (factors.0[k] + step).clamp(-bound, bound) - factors.0[k]
        });
        if step.iter().any(|v| !v.is_finite()) { Err(setting.singular()) } else { Ok(step) }
    }

    /// Length of a move, posterior standard deviations: no factor moves by more of its own.
    pub(super) fn length(&self, step: &Factors) -> f64 {
        times(&self.curvature, step).iter().zip(step).map(|(a, b)| a * b).sum::<f64>().sqrt()
    }
}
