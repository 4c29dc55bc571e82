//! Moderated variances: what many cells say about the spread between people, lent to each.
//!
//! With three people, the spread between them is known to a factor of three or so, and a test that
//! relied on it alone would find nothing. Cells share their people, and the ratio of the spread
//! between people to what their days alone would give is of one size in most of them. Smyth (2004,
//! "Linear models and empirical Bayes methods for assessing differential expression", sections 4
//! to 6) estimates the distribution of such variances from all of them and shrinks each towards it.

use statrs::function::gamma::digamma;

/// The distribution from which the cells' variance ratios come: scaled inverse chi-squared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct VariancePrior {
    /// Prior degrees of freedom; infinite where the ratios vary no more than chance.
    degrees: f64,
    /// Prior value of the ratio.
    ratio: f64,
}

impl VariancePrior {
    /// Fits to sample variance ratios, each with its degrees of freedom (Smyth 2004, eqs. in
    /// section 6.2: moments of the log ratios). `None` below three ratios.
    pub(crate) fn fitted(ratios: &[(f64, f64)]) -> Option<Self> {
        let usable: Vec<(f64, f64)> =
            ratios.iter().copied().filter(|(r, d)| *r > 0.0 && *d > 0.0).collect();
        if usable.len() < 3 {
            return None;
        }
        let n = usable.len() as f64;
        let centred: Vec<f64> =
            usable.iter().map(|(r, d)| r.ln() - digamma(d / 2.0) + (d / 2.0).ln()).collect();
        let mean = centred.iter().sum::<f64>() / n;
        let spread = centred.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let chance = usable.iter().map(|(_, d)| trigamma(d / 2.0)).sum::<f64>() / n;
        let excess = spread - chance;
        if excess <= 0.0 {
            return Some(Self { degrees: f64::INFINITY, ratio: mean.exp() });
        }
        let degrees = 2.0 * inverse_trigamma(excess);
        let ratio = (mean + digamma(degrees / 2.0) - (degrees / 2.0).ln()).exp();
        Some(Self { degrees, ratio })
    }

    /// The moderated ratio and its degrees of freedom, for a cell with ratio `ratio` on `degrees`
    /// degrees of freedom. `most` bounds the degrees of freedom that the prior may bring.
    ///
    /// The ratio is at least 1: people cannot differ less than their days make them.
    pub(crate) fn moderated(&self, ratio: f64, degrees: f64, most: f64) -> (f64, f64) {
        let prior = self.degrees.min(most);
        let moderated = (prior * self.ratio + degrees * ratio) / (prior + degrees);
        (moderated.max(1.0), prior + degrees)
    }
}

/// The second derivative of ln Gamma, by recurrence to 6 and the asymptotic series; x > 0.
fn trigamma(mut x: f64) -> f64 {
    let mut sum = 0.0;
    while x < 6.0 {
        sum += 1.0 / (x * x);
        x += 1.0;
    }
    let y = 1.0 / (x * x);
    sum + 1.0 / x + y / 2.0 + y / x * (1.0 / 6.0 - y * (1.0 / 30.0 - y * (1.0 / 42.0 - y / 30.0)))
}

/// The x > 0 whose trigamma is `value` > 0, by Newton's method on 1/trigamma (Smyth 2004, appendix).
fn inverse_trigamma(value: f64) -> f64 {
    if value > 1e7 {
        return value.sqrt().recip();
    }
    if value < 1e-6 {
        return value.recip();
    }
    let mut x = 0.5 + value.recip();
    for _ in 0..50 {
        let now = trigamma(x);
        // The derivative of trigamma by a central difference; Newton corrects what it lacks.
        let h = 1e-4 * x;
        let slope = (trigamma(x + h) - trigamma(x - h)) / (2.0 * h);
        let move_by = now * (1.0 - now / value) / slope;
        x += move_by;
        if move_by.abs() < 1e-10 * x {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{ChiSquared, Distribution};

    #[test]
    fn trigamma_has_its_known_values_and_inverse() {
        let pi2 = std::f64::consts::PI.powi(2);
        // Abramowitz and Stegun 6.4.
        for (x, expected) in [(1.0, pi2 / 6.0), (0.5, pi2 / 2.0), (2.0, pi2 / 6.0 - 1.0)] {
            // The series is cut at x^-9: 1e-8 at 6.
            assert!((trigamma(x) - expected).abs() < 1e-7, "{x}");
        }
        for x in [0.1, 0.7, 3.0, 40.0, 1e4] {
            assert!((inverse_trigamma(trigamma(x)) / x - 1.0).abs() < 1e-6, "{x}");
        }
    }

    #[test]
    fn the_prior_is_recovered_from_many_ratios() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let (degrees, prior) = (4.0, 8.0);
        let draw = |d: f64, rng: &mut ChaCha8Rng| -> f64 {
            ChiSquared::new(d).expect("positive").sample(rng) / d
        };
        let varied: Vec<(f64, f64)> = (0..20_000)
            .map(|_| {
                let truth = 2.0 / draw(prior, &mut rng);
                (truth * draw(degrees, &mut rng), degrees)
            })
            .collect();
        let fit = VariancePrior::fitted(&varied).expect("many");
        // Monte Carlo: about 2 % on the ratio, 5 % on its degrees of freedom.
        assert!((fit.ratio / 2.0 - 1.0).abs() < 0.05, "{fit:?}");
        assert!((fit.degrees / prior - 1.0).abs() < 0.15, "{fit:?}");
        let same: Vec<(f64, f64)> =
            (0..20_000).map(|_| (draw(degrees, &mut rng), degrees)).collect();
        let fit = VariancePrior::fitted(&same).expect("many");
        assert!(fit.degrees > 100.0 && (fit.ratio - 1.0).abs() < 0.05, "{fit:?}");
    }

    #[test]
    fn a_moderated_ratio_lies_between_prior_and_sample_and_is_at_least_one() {
        let prior = VariancePrior { degrees: 6.0, ratio: 2.0 };
        assert_eq!(prior.moderated(5.0, 2.0, 100.0), (2.75, 8.0));
        assert_eq!(prior.moderated(5.0, 2.0, 2.0), (3.5, 4.0));
        assert_eq!(VariancePrior { degrees: 6.0, ratio: 0.2 }.moderated(0.1, 2.0, 9.0), (1.0, 8.0));
        assert_eq!(VariancePrior::fitted(&[(1.0, 2.0)]), None);
    }
}
