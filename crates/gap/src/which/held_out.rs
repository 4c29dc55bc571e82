//! Held-out evidence for driven effects.
//!
//! The days of each person are cut into contiguous folds. On the others background and amplitude are
//! estimated; the fold then tells by how much the effect raises its likelihood. Variants of a shape are
//! weighed by their evidence on the training days of all people.

use std::sync::OnceLock;

use effects::EffectId;
use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};
use rayon::prelude::*;

use super::amplitude::{Hierarchy, Information};
use super::folds::{FOLDS, fold};
use super::statistics::Sums;
use super::{Score, Test, index_of_largest};
use crate::background::Allowed;
use crate::log_sum::{log_sum, softmax};

/// Rounds in which variants and hierarchy are brought together.
const ROUNDS: usize = 4;
/// How much the other people's evidence for a variant counts.
const SHARED: f64 = 0.5;

/// One person's A and b, random factors integrated out.
pub(super) struct FoldSums {
    /// Number of days.
    days: usize,
    /// Sums over the days of each fold.
    pub(super) tests: Vec<Sums>,
    /// What most effects are tested beside.
    usual: Vec<Allowed>,
    /// The days of all folds but each, and those of all, with the factor of the information about what is usually
    /// allowed for; computed at the first use.
    training: Vec<OnceLock<(Sums, Llt<f64>)>>,
}

/// The factor of the information about some directions, their prior included.
fn factored(sums: &Sums, allowed: &[Allowed]) -> Llt<f64> {
    // The factorisation reads the lower triangle alone.
    let system = Mat::from_fn(allowed.len(), allowed.len(), |row, column| {
        let prior = if row == column { allowed[row].sd.powi(-2) } else { 0.0 };
        prior + sums.a[(allowed[row].column, allowed[column].column)]
    });
    system.llt(Side::Lower).expect("a Gram matrix plus the precision of a proper prior")
}

impl FoldSums {
    /// `usual` are the directions that most effects' tests allow for.
    pub(super) fn new(days: usize, tests: Vec<Sums>, usual: Vec<Allowed>) -> Self {
        let training = (0..=tests.len()).map(|_| OnceLock::new()).collect();
        Self { days, tests, usual, training }
    }

    /// Whether a fold has days, and there are others to train on.
    fn is_tested(&self, index: usize) -> bool {
        let test = fold(self.days, index);
        !test.is_empty() && self.days > test.len()
    }

    /// The days of every fold but one.
    fn training(&self, without: Option<usize>) -> &(Sums, Llt<f64>) {
        self.training[without.unwrap_or(self.tests.len())].get_or_init(|| {
            let sums = Sums::over(&self.tests, without);
            let usual = factored(&sums, &self.usual);
            (sums, usual)
        })
    }
}

/// What one person brings to the test of an effect: days, what is allowed for, columns of its variants.
pub(super) struct Trial<'a> {
    /// Days.
    pub(super) folds: &'a FoldSums,
    /// What is allowed for.
    pub(super) allowed: Vec<Allowed>,
    /// Columns of the variants.
    pub(super) variants: Vec<usize>,
}

/// The background of one person fitted to some days.
struct TrainedFit {
    /// Allowed directions without the effect.
    background: Vec<f64>,
    /// For each variant: its information, and by how much the background answers to the effect.
    variants: Vec<(Information, Vec<f64>)>,
    /// Information that the variants share, background profiled out: (variants, variants).
    shared: Mat<f64>,
}

impl Trial<'_> {
    /// The background on every fold but one; `None` where the fold is not tested, or the record cannot show the effect.
    fn fitted(&self, without: Option<usize>) -> Option<TrainedFit> {
        if self.variants.is_empty() || without.is_some_and(|fold| !self.folds.is_tested(fold)) {
            return None;
        }
        let n = self.allowed.len();
        let (sums, usual) = self.folds.training(without);
        let Sums { a, b } = sums;
        let right = Mat::from_fn(n, 1 + self.variants.len(), |i, k| {
            let allowed = &self.allowed[i];
            match k.checked_sub(1) {
                None => b[allowed.column] + allowed.mean * allowed.sd.powi(-2),
                Some(variant) => a[(allowed.column, self.variants[variant])],
            }
        });
        let own = (self.allowed != self.folds.usual).then(|| factored(sums, &self.allowed));
        let solved = own.as_ref().unwrap_or(usual).solve(&right);
        let background: Vec<f64> = (0..n).map(|i| solved[(i, 0)]).collect();
        let shared = Mat::from_fn(self.variants.len(), self.variants.len(), |v, w| {
            let taken: f64 = (0..n).map(|i| right[(i, v + 1)] * solved[(i, w + 1)]).sum();
            a[(self.variants[v], self.variants[w])] - taken
        });
        let variants = (0..self.variants.len())
            .map(|v| {
                let answer: Vec<f64> = (0..n).map(|i| solved[(i, v + 1)]).collect();
                let mut information = a[(self.variants[v], self.variants[v])];
                let mut score = b[self.variants[v]];
                for i in 0..n {
                    information -= right[(i, v + 1)] * answer[i];
                    score -= right[(i, v + 1)] * background[i];
                }
                (Information { information: information.max(1e-9), score }, answer)
            })
            .collect();
        Some(TrainedFit { background, variants, shared })
    }

    /// Log likelihood of a fold with these amplitudes of variants over that of the background alone.
    fn gain(&self, fitted: &TrainedFit, acting: &[(usize, f64)], test: usize) -> f64 {
        let Sums { a, b } = &self.folds.tests[test];
        // The change of the amplitudes from one explanation to the other, and the state it starts from.
        let taken = |i: usize| -> f64 {
            acting.iter().map(|(v, theta)| theta * fitted.variants[*v].1[i]).sum()
        };
        let background = self.allowed.iter().enumerate().map(|(i, own)| (own.column, -taken(i)));
        let effect = acting.iter().map(|(v, theta)| (self.variants[*v], *theta));
        let change: Vec<(usize, f64)> = background.chain(effect).collect();
        let mut gain = 0.0;
        for (column, by) in &change {
            let mut slope = b[*column];
            for (allowed, value) in self.allowed.iter().zip(&fitted.background) {
                slope -= a[(*column, allowed.column)] * value;
            }
            for (other, value) in &change {
                slope -= 0.5 * a[(*column, *other)] * value;
            }
            gain += by * slope;
        }
        gain
    }
}

/// A shape of all people that is a sum of the variants, each with an amplitude that is not negative.
struct Blend {
    /// Amplitude of each variant in the sum.
    parts: Vec<f64>,
    /// How strongly people show it.
    hierarchy: Hierarchy,
    /// Log of its odds against a single variant.
    odds: f64,
}

/// Standard deviation of the amplitude of a part.
const PART: f64 = 1.0;
/// Nats that a part beyond the first must bring on the days that it was fitted to.
const PART_COSTS: f64 = 1.0;
/// Sweeps over the parts.
const SWEEPS: usize = 60;

impl Blend {
    /// The shape that all people together show most, where their variants are the same and there are several.
    fn of(fits: &[Option<TrainedFit>], one_variant: &Hierarchy) -> Option<Self> {
        let known: Vec<&TrainedFit> = fits.iter().flatten().collect();
        let count = known.first()?.variants.len();
        if count < 2 || known.iter().any(|fit| fit.variants.len() != count) {
            return None;
        }
        let information = Mat::from_fn(count, count, |v, w| {
            let prior = if v == w { PART.powi(-2) } else { 0.0 };
            prior + known.iter().map(|fit| fit.shared[(v, w)]).sum::<f64>()
        });
        let score: Vec<f64> =
            (0..count).map(|v| known.iter().map(|fit| fit.variants[v].0.score).sum()).collect();
        // Coordinate ascent of a concave function over amplitudes that are not negative.
        let mut parts = vec![0.0_f64; count];
        for _ in 0..SWEEPS {
            for v in 0..count {
                let others: f64 =
                    (0..count).filter(|w| *w != v).map(|w| information[(v, w)] * parts[w]).sum();
                parts[v] = ((score[v] - others) / information[(v, v)]).max(0.0);
            }
        }
        let acting = parts.iter().filter(|part| **part > 0.0).count();
        if acting < 2 {
            return None;
        }
        let of_sum: Vec<Information> =
            known.iter().map(|fit| Self::information(&parts, fit)).collect();
        let hierarchy = Hierarchy::of(&of_sum);
        let evidence: f64 = of_sum.iter().map(|info| hierarchy.evidence(*info)).sum();
        let best = |fit: &&TrainedFit| {
            fit.variants
                .iter()
                .map(|(info, _)| one_variant.evidence(*info))
                .fold(f64::MIN, f64::max)
        };
        let odds =
            evidence - known.iter().map(best).sum::<f64>() - PART_COSTS * (acting - 1) as f64;
        (hierarchy.mean > 0.0).then_some(Self { parts, hierarchy, odds })
    }

    /// What a person's days say about the amplitude of a sum.
    fn information(parts: &[f64], fit: &TrainedFit) -> Information {
        let (mut information, mut score) = (0.0, 0.0);
        for (v, x) in parts.iter().enumerate() {
            score += x * fit.variants[v].0.score;
            for (w, y) in parts.iter().enumerate() {
                information += x * y * fit.shared[(v, w)];
            }
        }
        Information { information: information.max(1e-9), score }
    }
}

/// Each person's weights of the variants, and the hierarchy that goes with them.
fn weigh(fits: &[Option<TrainedFit>]) -> (Vec<Vec<f64>>, Hierarchy) {
    let weights_by = |evidence: &dyn Fn(&Information) -> f64| {
        let of_person = |fit: &Option<TrainedFit>| -> Vec<f64> {
            let variants = fit.as_ref().map_or(&[][..], |f| &f.variants);
            variants.iter().map(|(info, _)| evidence(info)).collect()
        };
        weights_of(&fits.iter().map(of_person).collect::<Vec<_>>())
    };
    // Variants may be each other's opposite: equal weights would cancel them.
    let rise = |info: &Information| info.score.max(0.0).powi(2) / (info.information + 1.0);
    let mut weights = weights_by(&|info| 0.5 * rise(info));
    let mut hierarchy = Hierarchy { mean: 0.0, spread: 0.0, error: 0.0 };
    for _ in 0..ROUNDS {
        let mixed: Vec<Information> = fits
            .iter()
            .zip(&weights)
            .filter_map(|(fit, weights)| {
                let fit = fit.as_ref()?;
                let mut sum = Information { information: 0.0, score: 0.0 };
                for ((info, _), weight) in fit.variants.iter().zip(weights) {
                    sum.information += weight * info.information;
                    sum.score += weight * info.score;
                }
                Some(sum)
            })
            .collect();
        hierarchy = Hierarchy::of(&mixed);
        if hierarchy.mean <= 0.0 {
            break;
        }
        weights = weights_by(&|info| hierarchy.evidence(*info));
    }
    (weights, hierarchy)
}

/// Each person's weights of the variants from the evidence for them, that of the others counted in part where
/// everybody has the same variants.
fn weights_of(evidence: &[Vec<f64>]) -> Vec<Vec<f64>> {
    // The number of variants where everybody has as many, otherwise none.
    let mut counts = evidence.iter().map(Vec::len).filter(|n| *n > 0);
    let count = counts.next().filter(|own| counts.all(|other| other == *own)).unwrap_or(0);
    let of_variant = |v: usize| evidence.iter().filter_map(|own| own.get(v)).sum();
    let everyones: Vec<f64> = (0..count).map(of_variant).collect();
    evidence
        .iter()
        .map(|own| {
            let logs: Vec<f64> = own
                .iter()
                .enumerate()
                .map(|(v, own)| own + SHARED * everyones.get(v).map_or(0.0, |all| all - own))
                .collect();
            softmax(&logs)
        })
        .collect()
}

/// Tests an effect. A person without variants of it (a channel is missing) gains nothing.
pub(super) fn held_out(effect: EffectId, trials: &[Trial<'_>]) -> Score {
    let gains: Vec<Vec<f64>> = (0..FOLDS)
        .into_par_iter()
        .map(|f| {
            let fits: Vec<_> = trials.iter().map(|trial| trial.fitted(Some(f))).collect();
            let (weights, hierarchy) = weigh(&fits);
            let blend = Blend::of(&fits, &hierarchy);
            trials
                .iter()
                .zip(&fits)
                .zip(&weights)
                .map(|((trial, fit), weights)| {
                    let Some(fit) = fit.as_ref().filter(|_| hierarchy.mean > 0.0) else {
                        return 0.0;
                    };
                    let unblended = mixture(trial, fit, weights, &hierarchy, f);
                    match &blend {
                        None => unblended,
                        Some(blend) => either(unblended, blended(trial, fit, blend, f), blend.odds),
                    }
                })
                .collect()
        })
        .collect();
    let fits: Vec<_> = trials.par_iter().map(|trial| trial.fitted(None)).collect();
    let (weights, hierarchy) = weigh(&fits);
    let variants: Vec<usize> = weights.iter().map(|w| index_of_largest(w)).collect();
    let personal = fits
        .iter()
        .zip(&variants)
        .map(|(fit, variant)| match fit {
            Some(fit) => hierarchy.personal(fit.variants[*variant].0),
            None => (hierarchy.mean, hierarchy.spread),
        })
        .collect();
    let gains = (0..trials.len()).map(|person| gains.iter().map(|g| g[person]).sum()).collect();
    let amplitude = (hierarchy.mean, hierarchy.error);
    Score { amplitude, personal, variants, ..Score::of(effect, Test::Driven, gains) }
}

/// Log likelihood ratio of a fold under a sum of variants.
fn blended(trial: &Trial<'_>, fit: &TrainedFit, blend: &Blend, test: usize) -> f64 {
    let (theta, _) = blend.hierarchy.personal(Blend::information(&blend.parts, fit));
    let parts = blend.parts.iter().enumerate().filter(|(_, part)| **part > 0.0);
    trial.gain(fit, &parts.map(|(v, part)| (v, theta * part)).collect::<Vec<_>>(), test)
}

/// Log of the mean of two likelihood ratios, the second weighed by its odds.
fn either(first: f64, second: f64, odds: f64) -> f64 {
    let share = (1.0 + (-odds).exp()).recip();
    let logs = [(1.0 - share).ln() + first, share.ln() + second];
    let both = log_sum(&logs);
    if both == f64::NEG_INFINITY { first } else { both }
}

/// Log of the mean likelihood ratio of the variants over the days of a fold.
fn mixture(
    trial: &Trial<'_>,
    fit: &TrainedFit,
    weights: &[f64],
    hierarchy: &Hierarchy,
    test: usize,
) -> f64 {
    let logs: Vec<f64> = weights
        .iter()
        .enumerate()
        .filter(|(_, weight)| **weight > 1e-3)
        .map(|(variant, weight)| {
            let (theta, _) = hierarchy.personal(fit.variants[variant].0);
            weight.ln() + trial.gain(fit, &[(variant, theta)], test)
        })
        .collect();
    log_sum(&logs)
}

/// Allowed directions fitted to the days of all folds, and the factor L of their information with the prior: the
/// rows of its lower triangle.
pub(super) fn fitted_to_all(folds: &[Sums], allowed: &[Allowed]) -> (Vec<f64>, Vec<Vec<f64>>) {
    let sums = Sums::over(folds, None);
    let n = allowed.len();
    let right = Mat::from_fn(n, 1, |i, _| {
        sums.b[allowed[i].column] + allowed[i].mean * allowed[i].sd.powi(-2)
    });
    let factor = factored(&sums, allowed);
    let solved = factor.solve(&right);
    let rows = (0..n).map(|i| (0..=i).map(|j| factor.L()[(i, j)]).collect()).collect();
    ((0..n).map(|i| solved[(i, 0)]).collect(), rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A and b of `days` days in 3 columns: two directions of the background and an effect of amplitude 0.8.
    fn folds(days: usize) -> FoldSums {
        let truth = [0.3, -0.2, 0.8];
        let tests = (0..FOLDS)
            .map(|index| {
                let (mut a, mut b) = (Mat::<f64>::zeros(3, 3), vec![0.0; 3]);
                for day in fold(days, index) {
                    for step in 0..40 {
                        let t = (40 * day + step) as f64;
                        let row = [1.0, (0.3 * t).sin(), (0.11 * t).cos().max(0.0)];
                        let noise = 0.05 * (1.7 * t * t).sin();
                        let y: f64 = row.iter().zip(truth).map(|(x, v)| x * v).sum::<f64>() + noise;
                        for (i, x) in row.iter().enumerate() {
                            b[i] += x * y;
                            for (j, z) in row.iter().enumerate() {
                                a[(i, j)] += x * z;
                            }
                        }
                    }
                }
                Sums { a, b }
            })
            .collect();
        FoldSums::new(days, tests, allowed(2))
    }

    fn allowed(columns: usize) -> Vec<Allowed> {
        (0..columns).map(|column| Allowed { column, mean: 0.0, sd: 1.0 }).collect()
    }

    fn trial(folds: &FoldSums) -> Trial<'_> {
        Trial { folds, allowed: allowed(2), variants: vec![2] }
    }

    #[test]
    fn a_fold_without_a_day_is_not_tested() {
        let (one, three) = (folds(1), folds(3));
        assert!((0..FOLDS).all(|index| !one.is_tested(index)));
        assert_eq!((0..FOLDS).filter(|index| three.is_tested(*index)).count(), 3);
    }

    #[test]
    fn the_gain_of_a_fold_is_the_difference_of_its_log_likelihoods() {
        let folds = folds(14);
        let trial = trial(&folds);
        for test in 0..FOLDS {
            let fitted = trial.fitted(Some(test)).expect("tested");
            let Sums { a, b } = &folds.tests[test];
            let likelihood = |x: [f64; 3]| -> f64 {
                let linear: f64 = (0..3).map(|i| b[i] * x[i]).sum();
                let square: f64 = (0..3)
                    .flat_map(|i| (0..3).map(move |j| (i, j)))
                    .map(|(i, j)| x[i] * a[(i, j)] * x[j])
                    .sum();
                linear - 0.5 * square
            };
            let without = [fitted.background[0], fitted.background[1], 0.0];
            let (information, answer) = &fitted.variants[0];
            let theta = information.score / information.information;
            // An amplitude of 0.8 behind noise of 0.05 and priors of 1.
            assert!((theta - 0.8).abs() < 0.02, "{theta}");
            let with = [without[0] - theta * answer[0], without[1] - theta * answer[1], theta];
            let expected = likelihood(with) - likelihood(without);
            let found = trial.gain(&fitted, &[(0, theta)], test);
            assert!((found - expected).abs() < 1e-9 * expected.abs(), "{found} {expected}"); // rounding
        }
    }

    #[test]
    fn an_effect_of_either_sign_is_found() {
        let mut both = folds(14);
        // A fourth column that is the opposite of the third.
        for sums in &mut both.tests {
            let a = &sums.a;
            let at = |k: usize| if k == 3 { (2, -1.0) } else { (k, 1.0) };
            let wider = Mat::from_fn(4, 4, |i, j| {
                let ((i, s), (j, t)) = (at(i), at(j));
                s * t * a[(i, j)]
            });
            sums.b.push(-sums.b[2]);
            sums.a = wider;
        }
        let trial = Trial { variants: vec![2, 3], ..trial(&both) };
        assert!(held_out(EffectId::DAWN, &[trial]).gain() > 10.0);
    }

    #[test]
    fn a_shape_between_two_variants_is_found_as_their_sum() {
        // Two pulses a day, of which either variant knows one.
        let (days, truth) = (14, [0.9, 0.6]);
        let tests = (0..FOLDS)
            .map(|index| {
                let (mut a, mut b) = (Mat::<f64>::zeros(3, 3), vec![0.0; 3]);
                for step in fold(days, index).flat_map(|day| 40 * day..40 * (day + 1)) {
                    let hour = step % 40;
                    let pulse = |from: usize| f64::from(u8::from((from..from + 8).contains(&hour)));
                    let row = [1.0, pulse(4), pulse(16)];
                    let noise = 0.9 * (1.7 * (step * step) as f64).sin();
                    let y = truth[0] * row[1] + truth[1] * row[2] + noise;
                    for (i, x) in row.iter().enumerate() {
                        b[i] += x * y;
                        for (j, z) in row.iter().enumerate() {
                            a[(i, j)] += x * z;
                        }
                    }
                }
                Sums { a, b }
            })
            .collect();
        let folds = FoldSums::new(days, tests, allowed(1));
        let of = |variants: &[usize]| {
            let variants = variants.to_vec();
            let trial = Trial { folds: &folds, allowed: allowed(1), variants };
            held_out(EffectId::DAWN, &[trial]).gain()
        };
        let (first, second, both) = (of(&[1]), of(&[2]), of(&[1, 2]));
        assert!(both > first.max(second) + 5.0, "{first} {second} {both}");
    }

    #[test]
    fn what_is_left_out_does_not_train() {
        let (all, mut other) = (folds(14), folds(14));
        other.tests[2] = Sums { a: Mat::zeros(3, 3), b: vec![1e6; 3] };
        let background =
            |folds: &FoldSums, without| trial(folds).fitted(without).expect("tested").background;
        assert_eq!(background(&all, Some(2)), background(&other, Some(2)));
        assert_ne!(background(&all, Some(3)), background(&other, Some(3)));
    }

    #[test]
    fn an_effect_is_found_in_those_who_have_it_and_nobody_gains_without_a_record() {
        let folds = folds(14);
        let without = Trial { variants: Vec::new(), ..trial(&folds) };
        let found = held_out(EffectId::DAWN, &[trial(&folds), trial(&folds), without]);
        assert!(found.gains[0] > 10.0, "{:?}", found.gains);
        assert_eq!(found.gains[2], 0.0);
        assert_eq!(found.gains[0], found.gains[1]);
        assert!((found.amplitude.0 - 0.8).abs() < 0.2, "{:?}", found.amplitude);
    }
}
