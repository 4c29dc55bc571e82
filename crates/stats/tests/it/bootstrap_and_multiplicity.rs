//! Bootstrap intervals and multiplicity: published values, coverage by simulation, threads.

use std::num::NonZeroUsize;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stats::{Bootstrap, Estimate, StatsError, multiplicity};

/// Mean of borrowed values.
fn mean(values: &[&f64]) -> f64 {
    values.iter().copied().sum::<f64>() / values.len() as f64
}

/// The mean with its interval over people and pairs of days.
fn two_level(plan: &Bootstrap, people: &[Vec<f64>]) -> Estimate {
    let block = NonZeroUsize::new(2).expect("2 > 0");
    let matrix = plan.people_and_days_matrix(people, block, |days| vec![mean(&days.concat())]);
    matrix.and_then(|matrix| matrix.estimate(0, plan.level)).expect("valid")
}

/// A standard normal draw (Box and Muller).
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

#[test]
fn intervals_agree_with_scipy() {
    let x = [0.3, 0.5, 0.9, 1.1, 1.4, 1.9, 2.2, 2.8, 3.9, 4.4, 6.1, 9.7, 12.5, 0.7, 1.6];
    let plan = Bootstrap { replicates: 40_000, level: 0.95, seed: 5 };
    let estimate = plan.people(&x, mean).expect("valid");
    let bca = estimate.bca.expect("replicates on both sides");
    // scipy 1.17.1: stats.bootstrap((x,), np.mean, n_resamples=400000, method=...). Monte Carlo
    // error of a 2.5 % quantile at 40,000 replicates is about 0.01 below and 0.03 above (density
    // 0.08 and 0.035 there); the standard error is also known exactly, SD(n) / sqrt(n).
    for (name, ours, scipy, tolerance) in [
        ("percentile lower", estimate.percentile.lower, 1.76667, 0.04),
        ("percentile upper", estimate.percentile.upper, 5.24, 0.09),
        ("bca lower", bca.lower, 1.99333, 0.04),
        ("bca upper", bca.upper, 5.71333, 0.12),
        ("standard error", estimate.standard_error, 0.892221530371947, 0.015),
    ] {
        assert!((ours - scipy).abs() < tolerance, "{name}: {ours} against {scipy}");
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let people: Vec<Vec<f64>> =
        (0..9).map(|p| (0..10).map(|d| f64::from(p * 7 % 5 + d % 3)).collect()).collect();
    let plan = Bootstrap { replicates: 500, level: 0.9, seed: 3 };
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a small pool").install(|| two_level(&plan, &people))
    };
    let alone = run(1);
    assert_eq!(alone, run(4));
    let reseeded = two_level(&Bootstrap { seed: 4, ..plan }, &people);
    assert_ne!(alone.percentile, reseeded.percentile);
}

#[test]
fn person_intervals_cover() {
    // 600 cohorts of 30 people with skewed figures (exponential, mean 1), 95 % asked. Normal
    // theory gives about 92.5 % to percentiles and 93 % to BCa at this skewness and size; the
    // binomial SD of 600 draws is 1.1 %, so the bounds are 3 SD below and above.
    let (mut percentile, mut bca) = (0, 0);
    for cohort in 0..600 {
        let mut rng = ChaCha8Rng::seed_from_u64(1000 + cohort);
        let people: Vec<f64> = (0..30).map(|_| -(1.0 - rng.random::<f64>()).ln()).collect();
        let plan = Bootstrap { replicates: 1000, level: 0.95, seed: cohort };
        let estimate = plan.people(&people, mean).expect("valid");
        percentile += usize::from(estimate.percentile.contains(1.0));
        bca += usize::from(estimate.bca.is_some_and(|interval| interval.contains(1.0)));
    }
    let [percentile, bca] = [percentile, bca].map(|hits| f64::from(hits as u16) / 600.0);
    assert!((0.89..0.97).contains(&percentile), "percentile coverage {percentile}");
    assert!((0.895..0.975).contains(&bca), "BCa coverage {bca}");
}

#[test]
fn resampling_days_as_if_independent_would_not_cover() {
    // 20 people of 10 days; people differ (SD 1), days add noise (SD 1). The two-level interval
    // covers; one that ignores the person does not, which is why the person is the unit.
    let (mut proper, mut naive) = (0, 0);
    for cohort in 0..300 {
        let mut rng = ChaCha8Rng::seed_from_u64(9000 + cohort);
        let people: Vec<Vec<f64>> = (0..20)
            .map(|_| {
                let person = normal(&mut rng);
                (0..10).map(|_| person + normal(&mut rng)).collect()
            })
            .collect();
        let plan = Bootstrap { replicates: 400, level: 0.9, seed: cohort };
        proper += u16::from(two_level(&plan, &people).percentile.contains(0.0));
        let wrong = plan.people(&people.concat(), mean).expect("valid");
        naive += u16::from(wrong.percentile.contains(0.0));
    }
    let [proper, naive] = [proper, naive].map(|hits| f64::from(hits) / 300.0);
    // 90 % asked: binomial SD 1.7 %; 20 people cost about 2 %, resampling days adds variance
    // (0.1 of 1.1) and gives about 2 % back.
    assert!((0.84..0.96).contains(&proper), "two-level coverage {proper}");
    assert!(naive < 0.65, "naive coverage {naive}");
}

#[test]
fn undefined_statistics_are_named() {
    let plan = Bootstrap { replicates: 200, level: 0.9, seed: 1 };
    let log = plan.people(&[1.0, 2.0, -1.0], |people| mean(people).ln());
    assert!(matches!(log, Err(StatsError::UndefinedReplicate { column: 0, .. })), "{log:?}");
    let one = plan.people(&[1.0], mean);
    assert!(matches!(one, Err(StatsError::TooFew { what: "people", .. })));
    let level = Bootstrap { level: 1.0, ..plan }.people(&[1.0, 2.0], mean);
    assert!(matches!(level, Err(StatsError::OutOfDomain { name: "level", .. })));
}

/// Compares adjusted p-values with those of R or statsmodels.
fn check_adjusted(ours: Result<Vec<f64>, StatsError>, reference: &[f64]) {
    let ours = ours.expect("p-values");
    assert_eq!(ours.len(), reference.len());
    for (ours, reference) in ours.iter().zip(reference) {
        // Products of two doubles.
        assert!((ours - reference).abs() < 1e-15, "{ours} against {reference}");
    }
}

#[test]
fn holm_agrees_with_p_adjust() {
    // The fifteen p-values of Benjamini and Hochberg (1995), section 4 (thrombolysis trials).
    // Adjusted by statsmodels 0.15.0, multipletests(p, method='holm'), which agrees with R's
    // p.adjust(p, "holm") by definition.
    let p = [
        0.0001, 0.0004, 0.0019, 0.0095, 0.0201, 0.0278, 0.0298, 0.0344, 0.0459, 0.3240, 0.4262,
        0.5719, 0.6528, 0.7590, 1.0,
    ];
    check_adjusted(
        multiplicity::holm(&p),
        &[
            0.0015, 0.0056, 0.0247, 0.114, 0.2211, 0.278, 0.278, 0.278, 0.3213, 1.0, 1.0, 1.0, 1.0,
            1.0, 1.0,
        ],
    );
    let unsorted = [0.04, 0.001, 0.5, 0.03, 0.03];
    check_adjusted(multiplicity::holm(&unsorted), &[0.12, 0.005, 0.5, 0.12, 0.12]);
    assert!(multiplicity::holm(&[]).is_ok_and(|p| p.is_empty()));
    for bad in [f64::NAN, -0.1, 1.1] {
        assert!(multiplicity::holm(&[0.1, bad]).is_err());
    }
}
