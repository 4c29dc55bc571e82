//! Amplitudes between people: a normal hierarchy of amplitudes that are not negative.

/// A person's information about an amplitude: the log likelihood is score * theta - information *
/// theta^2 / 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Information {
    /// Curvature.
    pub(super) information: f64,
    /// Slope at zero.
    pub(super) score: f64,
}

/// Mean and spread of an amplitude between people.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hierarchy {
    /// Mean; 0 where the data speak against the effect.
    pub(super) mean: f64,
    /// Spread between people.
    pub(super) spread: f64,
    /// Standard error of the mean.
    pub(super) error: f64,
}

/// Spread between people over the mean, and the least spread.
const RELATIVE_SPREAD: f64 = 0.5;
const LEAST_SPREAD: f64 = 0.1;
/// Standard deviation of the prior of the mean.
const PRIOR: f64 = 1.0;
/// Iterations of mean and spread.
const ITERATIONS: usize = 8;

impl Hierarchy {
    /// Estimates mean and spread from every person's information.
    pub(super) fn of(people: &[Information]) -> Self {
        let prior = PRIOR.powi(-2);
        let (information, score) = people
            .iter()
            .fold((0.0, 0.0), |(a, b), person| (a + person.information, b + person.score));
        let mut mean = (score / (information + prior)).max(0.0);
        let mut error = (information + prior).sqrt().recip();
        for _ in 0..ITERATIONS {
            let spread = (RELATIVE_SPREAD * mean).hypot(LEAST_SPREAD);
            let (mut weights, mut sum) = (prior, 0.0);
            for person in people {
                let weight = (spread * spread + person.information.recip()).recip();
                weights += weight;
                sum += weight * person.score / person.information;
            }
            mean = (sum / weights).max(0.0);
            error = weights.sqrt().recip();
        }
        Self { mean, spread: (RELATIVE_SPREAD * mean).hypot(LEAST_SPREAD), error }
    }

    /// A person's amplitude given the hierarchy, and its standard deviation.
    pub(super) fn personal(&self, person: Information) -> (f64, f64) {
        let precision = self.spread.powi(-2);
        let total = person.information + precision;
        (((person.score + self.mean * precision) / total).max(0.0), total.sqrt().recip())
    }

    /// Log evidence of the effect in one person over its absence, nats.
    pub(super) fn evidence(&self, person: Information) -> f64 {
        let precision = self.spread.powi(-2);
        let (a, b) = (person.information + precision, person.score + self.mean * precision);
        0.5 * (b * b / a - self.mean * self.mean * precision)
            - 0.5 * (a * self.spread * self.spread).ln()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_share_a_mean_and_an_effect_of_the_wrong_sign_is_none() {
        let alike = vec![Information { information: 100.0, score: 100.0 }; 5];
        let found = Hierarchy::of(&alike);
        // 500 of information, a spread of 0.5 and a prior of 1 about 0: 5 x 1/(0.26 + 0.01) = 18.5.
        assert!((found.mean - 18.5 / 19.5).abs() < 0.01, "{found:?}");
        assert!(found.evidence(alike[0]) > 40.0); // score^2 / (2 information) is 50
        let against = vec![Information { information: 100.0, score: -100.0 }; 5];
        assert_eq!(Hierarchy::of(&against).mean, 0.0);
    }
}
