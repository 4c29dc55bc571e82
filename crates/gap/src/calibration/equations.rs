//! The linear equations of one step of a search.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::{FACTORS, Factors, LONGEST_MOVE, PersonalFactors, Setting};
use crate::error::GapError;

/// Curvature (6, 6) and gradient (6) of a loss at one set of factors, the prior's included.
pub(super) struct NormalEquations {
    pub(super) curvature: [[f64; FACTORS]; FACTORS],
    pub(super) gradient: Factors,
}

impl NormalEquations {
    /// The step that solves the equations.
    pub(super) fn step(
        &self,
        factors: &PersonalFactors,
        setting: &Setting<'_>,
    ) -> Result<Factors, GapError> {
        let bound = setting.bound;
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
        let singular = || GapError::Singular { person: setting.record.person.clone() };
        let solution = matrix.llt(Side::Lower).map_err(|_| singular())?.solve(&right);
        // No further than the bound, so that what leads beyond it does not count as a way to go.
        let step: Factors = std::array::from_fn(|k| {
            let step = solution[(k, 0)].clamp(-LONGEST_MOVE, LONGEST_MOVE);
            (factors.0[k] + step).clamp(-bound, bound) - factors.0[k]
        });
        if step.iter().any(|v| !v.is_finite()) { Err(singular()) } else { Ok(step) }
    }

    /// Product of two moves, each in posterior standard deviations.
    pub(super) fn product(&self, a: &Factors, b: &Factors) -> f64 {
        let along = |row: &Factors| row.iter().zip(b).map(|(c, b)| c * b).sum::<f64>();
        self.curvature.iter().zip(a).map(|(row, a)| a * along(row)).sum()
    }

    /// Length of a move, posterior standard deviations: no factor moves by more of its own.
    pub(super) fn length(&self, step: &Factors) -> f64 {
        self.product(step, step).sqrt()
    }

    pub(super) fn posterior_sd(&self, setting: &Setting<'_>) -> Result<Factors, GapError> {
        let matrix = Mat::from_fn(FACTORS, FACTORS, |row, column| self.curvature[row][column]);
        let inverse = matrix
            .llt(Side::Lower)
            .map_err(|_| GapError::Singular { person: setting.record.person.clone() })?
            .solve(&Mat::<f64>::identity(FACTORS, FACTORS));
        Ok(std::array::from_fn(|k| inverse[(k, k)].sqrt()))
    }
}
