//! What a record says about the factors, and how certain that is when days, not steps, are independent.
//!
//! Steps of a day share what the plant does not know: a miscounted meal, an afternoon of work, a sensor that
//! reads low. A curvature that takes steps for independent promises more than the record holds. Leaving out one
//! day after the other shows what it holds (the jackknife; Tukey, Ann Math Stat 1958;29:614).

use std::ops::Range;

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::{FACTORS, Factor, Factors, PersonalFactors, Setting, Square};
use crate::error::GapError;
use crate::filter::scored::Whitening;
use crate::filter::whitening::huber_weight;

/// Longest move of a log factor in one step of the search.
const LONGEST_MOVE: f64 = 0.3;
/// Days of independent steps that a person's own days are drawn towards: squares of a few days scatter.
const PRIOR_DAYS: f64 = 4.0;

/// What one day says: curvature and gradient of its loss.
#[derive(Debug, Clone, Default)]
pub(super) struct DayInformation {
    /// Its index in the record.
    pub(super) index: usize,
    /// By Gauss and Newton, steps taken for independent.
    pub(super) curvature: Square,
    pub(super) gradient: Factors,
}

/// What a record says at one set of factors, without the prior.
pub(super) struct Information {
    /// Days with a scored step.
    pub(super) days: Vec<DayInformation>,
    pub(super) curvature: Square,
    pub(super) gradient: Factors,
}

impl DayInformation {
    /// Adds `sign` times what the steps of a range say: `z` are normalised innovations, `signatures` their derivatives.
    pub(super) fn add(
        &mut self,
        whitening: &Whitening,
        z: &[Option<f64>],
        signatures: &[Factors],
        steps: Range<usize>,
        sign: f64,
    ) {
        let Whitening { autoregression, scale } = *whitening;
        for step in steps {
            // What is whitened has both of the entries before it.
            let Some(w) = autoregression.whitened_at(z, step) else { continue };
            let (now, before) = (&signatures[step], &signatures[step - autoregression.spacing]);
            let earlier = &signatures[step - 2 * autoregression.spacing];
            let signature: Factors =
                std::array::from_fn(|k| autoregression.left(now[k], before[k], earlier[k]));
            let weight = sign * huber_weight(w, scale) * scale.powi(-2);
            for row in 0..FACTORS {
                let weighted = weight * signature[row];
                self.gradient[row] += weighted * w;
                for (entry, value) in self.curvature[row].iter_mut().zip(&signature) {
                    *entry += weighted * value;
                }
            }
        }
    }
}

impl Information {
    /// Days without a scored step are left out.
    pub(super) fn of(days: impl IntoIterator<Item = DayInformation>) -> Self {
        let days: Vec<DayInformation> = days
            .into_iter()
            .filter(|day| (0..FACTORS).any(|k| day.curvature[k][k] > 0.0))
            .collect();
        let sum = |of: &dyn Fn(&DayInformation) -> f64| days.iter().map(of).sum::<f64>();
        let curvature = square(|row, column| sum(&|day| day.curvature[row][column]));
        let gradient = std::array::from_fn(|k| sum(&|day| day.gradient[k]));
        Self { days, curvature, gradient }
    }

    /// The same with a change of what all days together say.
    pub(super) fn changed(&self, by: &DayInformation) -> Self {
        let gradient = std::array::from_fn(|k| self.gradient[k] + by.gradient[k]);
        let curvature =
            square(|row, column| self.curvature[row][column] + by.curvature[row][column]);
        Self { days: Vec::new(), curvature, gradient }
    }

    /// The step of the search from `factors`: the solution of the normal equations of the data's loss divided by
    /// `dependence`, and the prior.
    pub(super) fn step(
        &self,
        dependence: f64,
        factors: &PersonalFactors,
        setting: &Setting<'_>,
    ) -> Result<Factors, GapError> {
        let bound = setting.rule.bound;
        let prior = |k: usize| factors.0[k] * Factor::ALL[k].prior_sd().powi(-2);
        let gradient: Factors = std::array::from_fn(|k| self.gradient[k] / dependence + prior(k));
        let curvature = with_prior(&self.curvature, dependence);
        // A factor at its bound that the gradient pushes outwards stays there.
        let held: [bool; FACTORS] = std::array::from_fn(|k| {
            factors.0[k].abs() >= bound && -gradient[k] * factors.0[k] > 0.0
        });
        let matrix = Mat::from_fn(FACTORS, FACTORS, |row, column| {
            let apart = row != column && (held[row] || held[column]);
            if apart { 0.0 } else { curvature[row][column] }
        });
        let right = Mat::from_fn(FACTORS, 1, |row, _| if held[row] { 0.0 } else { -gradient[row] });
        let solution = matrix.llt(Side::Lower).map_err(|_| setting.singular())?.solve(&right);
        let longest = (0..FACTORS).map(|k| solution[(k, 0)].abs()).fold(LONGEST_MOVE, f64::max);
        // No further than the bound, so that what leads beyond it does not count as a way to go.
        let step: Factors = std::array::from_fn(|k| {
            let step = solution[(k, 0)] * LONGEST_MOVE / longest;
            (factors.0[k] + step).clamp(-bound, bound) - factors.0[k]
        });
        if step.iter().any(|v| !v.is_finite()) { Err(setting.singular()) } else { Ok(step) }
    }

    /// Length of a step, posterior standard deviations: no factor moves by more of its own.
    pub(super) fn length(&self, dependence: f64, step: &Factors) -> f64 {
        dot(&times(&with_prior(&self.curvature, dependence), step), step).sqrt()
    }

    /// How many times the variance of the gradient is what independent steps would make it, at least 1.
    ///
    /// With C the posterior covariance of independent steps, H the curvature and J the sum of the days' squares
    /// about their mean, tr(C J) / tr(C H): a mean over the directions of which the record says more than
    /// the prior. `None` where the curvature is not positive definite.
    pub(super) fn dependence(&self) -> Option<f64> {
        let n = self.days.len() as f64;
        if n < 2.0 {
            return Some(1.0);
        }
        let covariance = inverse(&with_prior(&self.curvature, 1.0))?;
        let squares: f64 = self
            .days
            .iter()
            .map(|day| {
                let apart: Factors =
                    std::array::from_fn(|k| day.gradient[k] - self.gradient[k] / n);
                dot(&apart, &times(&covariance, &apart))
            })
            .sum();
        let expected: f64 = (0..FACTORS).map(|k| dot(&covariance[k], &self.curvature[k])).sum();
        let ratio = n / (n - 1.0) * squares / expected;
        Some(f64::max(((n - 1.0) * ratio + PRIOR_DAYS) / (n - 1.0 + PRIOR_DAYS), 1.0))
    }

    /// Covariance of the error of the factors at which the posterior is highest: what other days would have changed,
    /// what the prior leaves open, and `unlogged`.
    ///
    /// `observed` is the curvature of each day's loss. Where a meal is missing from a log it differs from that of Gauss
    /// and Newton, because errors are large there and Huber's weights flatten the loss. With their sum,
    /// A is the posterior's curvature and P the prior's precision. The first part is the jackknife's, with one
    /// step of Newton for each day left out; it is drawn towards A^-1 H A^-1 / dependence, which it would be if all
    /// directions depended alike. The second is A^-1 P A^-1. No factor is less certain than by the
    /// prior. `None` where a curvature is not positive definite.
    pub(super) fn covariance(
        &self,
        observed: &[Square],
        dependence: f64,
        unlogged: &Square,
    ) -> Option<Square> {
        let sum = |row: usize, column: usize| observed.iter().map(|day| day[row][column]).sum();
        let total = with_prior(&square(sum), dependence);
        let whole = inverse(&total)?;
        let n = self.days.len() as f64;
        let moves: Vec<Factors> = self
            .days
            .iter()
            .zip(observed)
            .map(|(day, own)| {
                let left = square(|row, column| total[row][column] - own[row][column] / dependence);
                Some(times(&inverse(&left)?, &day.gradient.map(|value| value / dependence)))
            })
            .collect::<Option<_>>()?;
        let mean: Factors =
            std::array::from_fn(|k| moves.iter().map(|m| m[k]).sum::<f64>() / n.max(1.0));
        let own = (n - 1.0).max(0.0);
        let jackknife = |row: usize, column: usize| {
            let product = |m: &Factors| (m[row] - mean[row]) * (m[column] - mean[column]);
            own / n.max(1.0) * moves.iter().map(product).sum::<f64>()
        };
        let alike =
            sandwich(&whole, &self.curvature.map(|row| row.map(|value| value / dependence)));
        let open = sandwich(&whole, &with_prior(&[[0.0; FACTORS]; FACTORS], 1.0));
        within_prior(&square(|row, column| {
            let sampled = own * jackknife(row, column) + PRIOR_DAYS * alike[row][column];
            sampled / (own + PRIOR_DAYS) + open[row][column] + unlogged[row][column]
        }))
    }
}

/// A covariance in which no factor is less certain than by the prior; correlations stay. `None` where it is not finite.
///
/// A direction as a whole is not cut: what two factors share would be taken from the one that is certain too.
fn within_prior(covariance: &Square) -> Option<Square> {
    let share: Factors =
        std::array::from_fn(|k| f64::min(Factor::ALL[k].prior_sd() / covariance[k][k].sqrt(), 1.0));
    let within = square(|row, column| covariance[row][column] * (share[row] * share[column]));
    within.iter().flatten().all(|value| value.is_finite()).then_some(within)
}

pub(super) fn square(of: impl Fn(usize, usize) -> f64) -> Square {
    std::array::from_fn(|row| std::array::from_fn(|column| of(row, column)))
}

fn dot(a: &Factors, b: &Factors) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn times(matrix: &Square, vector: &Factors) -> Factors {
    std::array::from_fn(|row| dot(&matrix[row], vector))
}

/// `outer` symmetric.
fn sandwich(outer: &Square, inner: &Square) -> Square {
    let half = square(|row, column| dot(&inner[row], &outer[column]));
    square(|row, column| (0..FACTORS).map(|k| outer[row][k] * half[k][column]).sum())
}

/// A curvature of the data over `dependence`, and the prior's precision.
fn with_prior(data: &Square, dependence: f64) -> Square {
    square(|row, column| {
        let prior = if row == column { Factor::ALL[row].prior_sd().powi(-2) } else { 0.0 };
        data[row][column] / dependence + prior
    })
}

fn inverse(of: &Square) -> Option<Square> {
    let matrix = Mat::from_fn(FACTORS, FACTORS, |row, column| of[row][column]);
    let inverse = matrix.llt(Side::Lower).ok()?.solve(&Mat::<f64>::identity(FACTORS, FACTORS));
    Some(square(|row, column| inverse[(row, column)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Days whose gradients have `factor` times their curvature as covariance: plus and minus along one factor after
    /// the other.
    fn information(days: usize, factor: f64) -> Information {
        let size = (factor * 400.0 * FACTORS as f64 / days as f64).sqrt();
        Information::of((0..days).map(|day| {
            let mut gradient = [0.0; FACTORS];
            gradient[(day / 2) % FACTORS] = if day % 2 == 0 { size } else { -size };
            let own = 400.0 / days as f64;
            let curvature = square(|row, column| if row == column { own } else { 0.0 });
            DayInformation { index: day, curvature, gradient }
        }))
    }

    /// With the curvature of Gauss and Newton and a complete log.
    fn covariance(information: &Information, dependence: f64) -> Square {
        let own: Vec<Square> = information.days.iter().map(|day| day.curvature).collect();
        information.covariance(&own, dependence, &Square::default()).expect("positive definite")
    }

    #[test]
    fn days_that_scatter_more_count_less() {
        for (factor, expected) in [(0.2, 1.0), (1.0, 1.0), (9.0, 8.9)] {
            let found = information(240, factor);
            let dependence = found.dependence().expect("positive definite");
            // n / (n - 1) of 240 days, and four days of 1 among them.
            assert!((dependence / expected - 1.0).abs() < 0.01, "{factor}: {dependence}");
            let sd = covariance(&found, dependence)[0][0].sqrt();
            let curvature = 400.0 / expected + Factor::Action.prior_sd().powi(-2);
            let ratio = sd * curvature.sqrt();
            // Days that agree too well tell more than they should; the rest is n / (n - 1) and the four days.
            assert!(if factor < 1.0 { ratio < 1.0 } else { (ratio - 1.0).abs() < 0.03 }, "{ratio}");
        }
    }

    #[test]
    fn no_record_makes_a_person_less_certain_than_the_prior() {
        let found = information(12, 1e4);
        // Days that contradict each other, and are taken for independent steps all the same.
        let covariance = covariance(&found, 1.0);
        for (k, factor) in Factor::ALL.into_iter().enumerate() {
            assert!(covariance[k][k].sqrt() <= factor.prior_sd() * (1.0 + 1e-12), "{factor:?}");
        }
    }

    #[test]
    fn a_record_that_says_nothing_leaves_the_prior() {
        let empty = Information::of([DayInformation::default()]);
        let covariance = covariance(&empty, 1.0);
        assert_eq!(empty.dependence(), Some(1.0));
        for (k, factor) in Factor::ALL.into_iter().enumerate() {
            assert!((covariance[k][k].sqrt() / factor.prior_sd() - 1.0).abs() < 1e-12); // rounding
        }
    }

    /// A factor that no record knows does not take certainty from one with which it is shared, or give any.
    #[test]
    fn a_factor_at_its_prior_leaves_the_others_as_they_are() {
        let mut wide = Square::default();
        for (k, factor) in Factor::ALL.into_iter().enumerate() {
            wide[k][k] = (0.5 * factor.prior_sd()).powi(2);
        }
        let (a, b) = (Factor::TMaxG as usize, Factor::TMaxI as usize);
        wide[b][b] *= 16.0;
        wide[a][b] = 0.8 * (wide[a][a] * wide[b][b]).sqrt();
        wide[b][a] = wide[a][b];
        let within = within_prior(&wide).expect("finite");
        assert_eq!(within[a][a], wide[a][a]);
        assert!((within[b][b].sqrt() / Factor::TMaxI.prior_sd() - 1.0).abs() < 1e-12); // rounding
        let correlation = within[a][b] / (within[a][a] * within[b][b]).sqrt();
        assert!((correlation - 0.8).abs() < 1e-12, "{correlation}"); // rounding
    }
}
