//! Intervals over few people.

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};
use stats::Estimate;

use contract::WithInterval;

/// The percentile interval of a bootstrap over `n` people, widened about the estimate.
///
/// Resampling underestimates the standard error by sqrt((n - 1) / n) and knows nothing of Student's t
/// (Hesterberg, Am Stat 2015;69:371): five people need an interval 1.6 times as wide, twenty one of 1.1.
pub(super) fn over_people(estimate: &Estimate, n: usize) -> WithInterval {
    let (tail, people) = (0.5 + 0.5 * estimate.level, n as f64);
    let wider = StudentsT::new(0.0, 1.0, people - 1.0).map_or(1.0, |student| {
        let ratio = student.inverse_cdf(tail) / Normal::standard().inverse_cdf(tail);
        ratio * (people / (people - 1.0)).sqrt()
    });
    let (value, interval) = (estimate.value, estimate.percentile);
    WithInterval {
        value,
        lower: value - wider * (value - interval.lower),
        upper: value + wider * (interval.upper - value),
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};
    use stats::Bootstrap;

    use super::*;

    #[test]
    fn five_and_eight_people_are_covered_at_the_nominal_rate() {
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        for n in [5, 8] {
            let (mut plain, mut widened) = (0, 0);
            let samples = 600;
            for seed in 0..samples {
                let people: Vec<f64> = (0..n).map(|_| StandardNormal.sample(&mut rng)).collect();
                let plan = Bootstrap { replicates: 400, level: 0.95, seed };
                let mean = |drawn: &[&f64]| drawn.iter().copied().sum::<f64>() / n as f64;
                let estimate = plan.people(&people, mean).expect("people");
                plain += usize::from(estimate.percentile.contains(0.0));
                let interval = over_people(&estimate, n);
                widened += usize::from(interval.lower <= 0.0 && interval.upper >= 0.0);
            }
            let share = |count: usize| count as f64 / samples as f64;
            // The binomial standard error is 0.9 points; three of them.
            assert!((share(widened) - 0.95).abs() < 0.027, "{n} people: {}", share(widened));
            assert!(share(plain) < 0.92, "{n} people: {} without", share(plain));
        }
    }
}
