//! What knowing a change exactly would gain: the likelihood of the innovations with the change undone over that with it, the plant
//! calibrated to each person on both sides.
//!
//! The record as it is is the changed one with the change undone. The gain says what an oracle would win that knows every
//! change. It is no strict bound: the record that was kept is inexact too, so that another change than the true one may gain more, and what
//! the changed log itself looks like (doses that nobody gives) is not counted. It compares likelihoods of the same
//! readings, so it is stated where the readings are not what is changed.

use cohort::{Cohort, Person};
use ode_sim::OdeParameters;
use rayon::prelude::*;

use crate::filter::augmented::AugmentedModel;
use crate::filter::calibration::calibrate;
use crate::{DiagnosisConfig, Observations};

/// Degrees of freedom of the innovations' distribution: heavy tails, so that no single reading decides.
const FREEDOM: f64 = 4.0;
/// Iterations of its scale, which shrink its error by two thirds each.
const ITERATIONS: usize = 30;

/// The log likelihood of the innovations of each person who can be calibrated.
#[must_use]
pub fn log_likelihoods(cohort: &Cohort) -> Vec<Option<f64>> {
    cohort.people.par_iter().map(log_likelihood).collect()
}

/// The gain over all people, nats; `None` where the readings were changed, or nobody can be compared.
#[must_use]
pub fn gain(before: &Cohort, likelihoods: &[Option<f64>], after: &Cohort) -> Option<f64> {
    if before.people.iter().zip(&after.people).any(|(a, b)| a.record.cgm() != b.record.cgm()) {
        return None;
    }
    let changed = log_likelihoods(after);
    let pairs: Vec<f64> =
        likelihoods.iter().zip(&changed).filter_map(|(a, b)| Some((*a)? - (*b)?)).collect();
    (!pairs.is_empty()).then(|| pairs.iter().sum())
}

fn log_likelihood(person: &Person) -> Option<f64> {
    let config = DiagnosisConfig::working();
    let record = Observations::from_person(person).ok()?;
    let population = AugmentedModel::new(OdeParameters::nominal(), record.weight, config.noise);
    let found = calibrate(&population, &record, &config.calibration).ok()?;
    let mut innovations = Vec::new();
    // The filter divides each innovation by its own standard deviation, which depends on the calibration.
    let mut divided = 0.0;
    for (whitened, innovation) in found.whitened.iter().zip(&found.filtered.innovations) {
        let (Some(whitened), Some(innovation)) = (whitened, innovation) else { continue };
        innovations.push(whitened * found.scale);
        divided += 0.5 * innovation.variance.ln();
    }
    // Nobody whose record holds no insulin or no carbohydrate has innovations that are scored.
    (!innovations.is_empty()).then(|| of_innovations(&innovations) - divided)
}

/// The log likelihood under a t distribution of the scale that fits best.
fn of_innovations(innovations: &[f64]) -> f64 {
    let n = innovations.len() as f64;
    let mut variance = innovations.iter().map(|x| x * x).sum::<f64>() / n.max(1.0);
    for _ in 0..ITERATIONS {
        let weighted = |x: &f64| (FREEDOM + 1.0) * x * x / (FREEDOM + x * x / variance);
        variance = innovations.iter().map(weighted).sum::<f64>() / n.max(1.0);
    }
    let of_one = |x: &f64| (x * x / variance / FREEDOM).ln_1p();
    let tails = innovations.iter().map(of_one).sum::<f64>();
    -0.5 * n * variance.ln() - 0.5 * (FREEDOM + 1.0) * tails
}

/// Largest distance of a log likelihood ratio from its mean, in standard deviations, and steps over it.
const WIDEST: f64 = 8.0;
const STEPS: u32 = 400;

/// The evidence that is expected of what happened `count` times and could have at `places`, where undoing it exactly gains
/// `gain` nats: of a reader who knows how it looks, how often it happens and where it could have, but not where it
/// did. Never more than the gain.
///
/// Each happening gains as much as the others, and what a place says of one is Gaussian: with a gain of g each, the log
/// likelihood ratio has mean g where it happened, -g where it did not, and variance 2 g.
#[must_use]
pub fn without_knowing_where(count: usize, places: usize, gain: f64) -> f64 {
    if count == 0 || count >= places || gain <= 0.0 {
        return gain;
    }
    let share = count as f64 / places as f64;
    let each = gain / count as f64;
    let spread = (2.0 * each).sqrt();
    let of = |log_ratio: f64| (share * log_ratio.exp_m1()).ln_1p();
    let mean = |centre: f64| {
        let mut sums = (0.0, 0.0);
        for step in 0..=STEPS {
            let z = WIDEST * (2.0 * f64::from(step) / f64::from(STEPS) - 1.0);
            let weight = (-0.5 * z * z).exp();
            sums = (sums.0 + weight * of(centre + spread * z), sums.1 + weight);
        }
        sums.0 / sums.1
    };
    let found = places as f64 * (share * mean(each) + (1.0 - share) * mean(-each));
    found.min(gain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn not_knowing_where_costs_little_of_few_large_changes_and_most_of_many_small_ones() {
        // Ten of 20 nats each among 100: what is lost is about what it costs to say which.
        let large = without_knowing_where(10, 100, 200.0);
        let entropy = -(10.0 * 0.1_f64.ln() + 90.0 * 0.9_f64.ln());
        assert!((large - (200.0 - entropy)).abs() < 3.0, "{large}");
        // A hundred of a third of a nat among a thousand.
        let small = without_knowing_where(100, 1000, 33.0);
        assert!((0.0..6.0).contains(&small), "{small}");
        assert_eq!(without_knowing_where(5, 5, 7.0), 7.0);
        assert_eq!(without_knowing_where(5, 50, -7.0), -7.0);
    }

    #[test]
    fn wider_innovations_are_less_likely_and_one_far_off_costs_little() {
        let innovations: Vec<f64> = (0..2000).map(|k| (f64::from(k) * 0.7).sin()).collect();
        let wider: Vec<f64> = innovations.iter().map(|x| 1.1 * x).collect();
        let lost = of_innovations(&innovations) - of_innovations(&wider);
        assert!((lost - 2000.0 * 1.1f64.ln()).abs() < 1e-6, "{lost}");
        let mut off = innovations.clone();
        off[7] = 50.0;
        let lost = of_innovations(&innovations) - of_innovations(&off);
        assert!((10.0..25.0).contains(&lost), "{lost}");
    }
}
