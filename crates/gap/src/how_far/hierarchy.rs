//! Amplitudes of a cohort: normal between people, their mean and spread estimated with them.
//!
//! Empirical Bayes by expectation and maximisation (Dempster, Laird & Rubin, J R Stat Soc B 1977;39:1): given mean and spread,
//! each person's amplitudes have a normal posterior; given the posteriors, mean and spread are
//! re-estimated. The mean is generalised least squares, so that only the spread needs the iteration.

use effects::Prior;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// What a person's training days say about the amplitudes, calibration profiled out.
#[derive(Debug, Clone)]
pub(super) struct AmplitudeEvidence {
    /// Information, `(effects, effects)`.
    pub(super) information: Mat<f64>,
    /// Information times the estimate, one entry an effect.
    pub(super) weighted: Vec<f64>,
}

/// Amplitudes of the cohort.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CohortAmplitudes {
    /// Mean over people, one entry an effect.
    pub(super) mean: Vec<f64>,
    /// Standard deviation between people.
    pub(super) sd: Vec<f64>,
    /// Variance of the mean that comes from people's data.
    pub(super) within: Vec<f64>,
    /// Variance of the mean that comes from who was observed.
    pub(super) between: Vec<f64>,
    /// Each person's amplitudes, never negative.
    pub(super) people: Vec<Vec<f64>>,
}

/// Rounds of the iteration; the spread has a proper prior, so that it converges in a few dozen.
const ROUNDS: usize = 60;
/// People that the prior of the spread counts for.
const PRIOR_PEOPLE: f64 = 2.0;
/// Amplitude below which the prior of the spread no longer shrinks with the mean.
const LEAST_MEAN: f64 = 0.25;
/// Prior standard deviation of the mean, in medians of the published amplitude: wide.
const PRIOR_MEAN_SD: f64 = 4.0;
/// Information below which a person says nothing about an effect.
const NO_INFORMATION: f64 = 1e-9;

/// Mean, spread and everyone's amplitudes.
///
/// `priors` are those of the effects' cards. The spread's prior is an inverse gamma that counts for two
/// people whose amplitudes differ as the card says.
pub(super) fn empirical_bayes(
    evidence: &[AmplitudeEvidence],
    priors: &[Prior],
) -> CohortAmplitudes {
    let effects = priors.len();
    let mut mean: Vec<f64> = priors.iter().map(|prior| prior.median).collect();
    let mut variance: Vec<f64> =
        priors.iter().map(|prior| (prior.log_sd * prior.median).powi(2)).collect();
    let informed = |effect: usize| {
        evidence.iter().filter(move |own| own.information[(effect, effect)] > NO_INFORMATION)
    };
    let mut covariance = Mat::<f64>::zeros(effects, effects);
    for _ in 0..ROUNDS {
        // Generalised least squares: (sum M) mean = sum M x with M = (1/J + T)^-1.
        let mut precision = Mat::<f64>::from_fn(effects, effects, |row, column| {
            if row == column { (PRIOR_MEAN_SD * priors[row].median).powi(-2) } else { 0.0 }
        });
        let mut right = Mat::<f64>::zeros(effects, 1);
        for person in evidence {
            let inner = person.posterior_covariance(&variance);
            for row in 0..effects {
                let mut value = 0.0;
                for column in 0..effects {
                    let cross = inner[(row, column)] / (variance[row] * variance[column]);
                    precision[(row, column)] -= cross;
                    value += inner[(row, column)] / variance[row] * person.weighted[column];
                }
                precision[(row, row)] += 1.0 / variance[row];
                right[(row, 0)] += value;
            }
        }
        covariance = inverse(&precision);
        for (effect, (prior, mean)) in priors.iter().zip(&mut mean).enumerate() {
            let value: f64 = (0..effects).map(|k| covariance[(effect, k)] * right[(k, 0)]).sum();
            *mean = value.clamp(0.0, prior.largest);
        }
        for (effect, prior) in priors.iter().enumerate() {
            let mut squares = 0.0;
            for person in informed(effect) {
                let inner = person.posterior_covariance(&variance);
                let posterior = person.posterior_mean(&inner, &mean, &variance);
                squares += (posterior[effect] - mean[effect]).powi(2) + inner[(effect, effect)];
            }
            let people = informed(effect).count() as f64;
            let usual = prior.log_sd * mean[effect].max(LEAST_MEAN);
            variance[effect] = (squares + PRIOR_PEOPLE * usual * usual) / (people + PRIOR_PEOPLE);
        }
    }
    let count = |effect: usize| informed(effect).count().max(1) as f64;
    let between: Vec<f64> = (0..effects).map(|k| variance[k] / count(k)).collect();
    CohortAmplitudes {
        sd: variance.iter().map(|v| v.sqrt()).collect(),
        within: (0..effects).map(|k| (covariance[(k, k)] - between[k]).max(0.0)).collect(),
        between,
        people: evidence.iter().map(|own| own.amplitudes(&mean, &variance, priors)).collect(),
        mean,
    }
}

impl AmplitudeEvidence {
    /// Covariance of the person's amplitudes given the spread between people.
    fn posterior_covariance(&self, variance: &[f64]) -> Mat<f64> {
        let effects = variance.len();
        inverse(&Mat::from_fn(effects, effects, |row, column| {
            let prior = if row == column { 1.0 / variance[row] } else { 0.0 };
            self.information[(row, column)] + prior
        }))
    }

    fn posterior_mean(&self, covariance: &Mat<f64>, mean: &[f64], variance: &[f64]) -> Vec<f64> {
        let effects = mean.len();
        let right = |k: usize| self.weighted[k] + mean[k] / variance[k];
        let of = |row: usize| (0..effects).map(|k| covariance[(row, k)] * right(k)).sum();
        (0..effects).map(of).collect()
    }

    /// The most probable amplitudes of the person that are not negative: those that would be are held at zero, the
    /// most negative first, and the others are found given that.
    fn amplitudes(&self, mean: &[f64], variance: &[f64], priors: &[Prior]) -> Vec<f64> {
        let (mut mean, mut variance) = (mean.to_vec(), variance.to_vec());
        loop {
            let covariance = self.posterior_covariance(&variance);
            let found = self.posterior_mean(&covariance, &mean, &variance);
            let worst = (0..found.len())
                .filter(|k| found[*k] < 0.0 && mean[*k] != HELD.0)
                .min_by(|a, b| found[*a].total_cmp(&found[*b]));
            let Some(effect) = worst else {
                return found.iter().zip(priors).map(|(v, p)| v.clamp(0.0, p.largest)).collect();
            };
            (mean[effect], variance[effect]) = HELD;
        }
    }
}

/// Mean and variance that hold an amplitude at zero.
const HELD: (f64, f64) = (-1e-12, 1e-12);

/// Inverse of a positive definite matrix; of its diagonal where rounding has made it indefinite.
fn inverse(matrix: &Mat<f64>) -> Mat<f64> {
    let n = matrix.nrows();
    match matrix.llt(Side::Lower) {
        Ok(factor) => factor.solve(&Mat::<f64>::identity(n, n)),
        Err(_) => Mat::from_fn(n, n, |row, column| {
            let diagonal = matrix[(row, row)].max(NO_INFORMATION);
            if row == column { 1.0 / diagonal } else { 0.0 }
        }),
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    const PRIOR: Prior = Prior { median: 1.0, log_sd: 0.5, largest: 4.0 };

    fn single(estimate: f64, sd: f64) -> AmplitudeEvidence {
        let information = sd.powi(-2);
        AmplitudeEvidence {
            information: Mat::from_fn(1, 1, |_, _| information),
            weighted: vec![information * estimate],
        }
    }

    #[test]
    fn mean_and_spread_of_many_people_are_recovered() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let people: Vec<AmplitudeEvidence> = (0..200)
            .map(|_| {
                let truth = 1.2 + 0.3 * normal();
                single(truth + 0.4 * normal(), 0.4)
            })
            .collect();
        let found = empirical_bayes(&people, &[PRIOR]);
        // The mean's standard error is 0.5 / sqrt(200) = 0.035; that of the spread about 0.04.
        assert!((found.mean[0] - 1.2).abs() < 0.12, "{:?}", found.mean);
        assert!((found.sd[0] - 0.3).abs() < 0.12, "{:?}", found.sd);
        let error = (found.within[0] + found.between[0]).sqrt();
        assert!((error - 0.035).abs() < 0.01, "standard error {error}");
    }

    #[test]
    fn a_person_without_evidence_is_like_the_others_and_none_is_negative() {
        let mut people: Vec<AmplitudeEvidence> = (0..9).map(|_| single(0.8, 0.05)).collect();
        people.push(single(0.0, 1e6));
        people.push(single(-3.0, 0.1));
        let found = empirical_bayes(&people, &[PRIOR]);
        assert!((found.people[9][0] - found.mean[0]).abs() < 1e-3, "{found:?}");
        assert_eq!(found.people[10][0], 0.0);
    }

    #[test]
    fn an_amplitude_held_at_zero_leaves_its_share_to_the_other() {
        // Two effects that act alike: together 1, apart +2 and -1.
        let information = Mat::from_fn(2, 2, |r, c| if r == c { 100.0 } else { 95.0 });
        let weighted = vec![100.0 * 2.0 - 95.0, 95.0 * 2.0 - 100.0];
        let person = AmplitudeEvidence { information, weighted };
        let found = person.amplitudes(&[0.5, 0.5], &[100.0, 100.0], &[PRIOR, PRIOR]);
        assert!(found[1].abs() < 1e-9, "{found:?}");
        // Alone the first is 105 / 100, with a prior that is worth a ten-thousandth of the data.
        assert!((found[0] - 1.05).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn without_an_effect_the_mean_is_near_zero() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let people: Vec<AmplitudeEvidence> = (0..50)
            .map(|_| {
                single(
                    0.2 * <StandardNormal as Distribution<f64>>::sample(&StandardNormal, &mut rng),
                    0.2,
                )
            })
            .collect();
        let found = empirical_bayes(&people, &[PRIOR]);
        // Five standard errors of 0.22 / sqrt(50).
        assert!(found.mean[0] < 0.16, "{:?}", found.mean);
    }
}
