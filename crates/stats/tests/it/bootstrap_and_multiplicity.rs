//! Bootstrap intervals and multiplicity: published values, coverage by simulation, threads.

use std::num::NonZeroUsize;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stats::{Bootstrap, ReplicateMatrix, StatsError, multiplicity};

/// Mean of borrowed values.
fn mean(values: &[&f64]) -> f64 {
    values.iter().copied().sum::<f64>() / values.len() as f64
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
    let block = NonZeroUsize::new(2).expect("2 > 0");
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a small pool").install(|| {
            plan.people_and_days(&people, block, |days| mean(&days.concat())).expect("valid")
        })
    };
    let alone = run(1);
    assert_eq!(alone, run(4));
    let other = Bootstrap { seed: 4, ..plan };
    let reseeded = other.people_and_days(&people, block, |days| mean(&days.concat()));
    assert_ne!(alone.percentile, reseeded.expect("valid").percentile);
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
    let block = NonZeroUsize::new(2).expect("2 > 0");
    let (mut two_level, mut naive) = (0, 0);
    for cohort in 0..300 {
        let mut rng = ChaCha8Rng::seed_from_u64(9000 + cohort);
        let people: Vec<Vec<f64>> = (0..20)
            .map(|_| {
                let person = normal(&mut rng);
                (0..10).map(|_| person + normal(&mut rng)).collect()
            })
            .collect();
        let plan = Bootstrap { replicates: 400, level: 0.9, seed: cohort };
        let proper = plan.people_and_days(&people, block, |days| mean(&days.concat()));
        two_level += u16::from(proper.expect("valid").percentile.contains(0.0));
        let wrong = plan.people(&people.concat(), mean).expect("valid");
        naive += u16::from(wrong.percentile.contains(0.0));
    }
    let [two_level, naive] = [two_level, naive].map(|hits| f64::from(hits) / 300.0);
    // 90 % asked: binomial SD 1.7 %; 20 people cost about 2 %, resampling days adds variance
    // (0.1 of 1.1) and gives about 2 % back.
    assert!((0.84..0.96).contains(&two_level), "two-level coverage {two_level}");
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
fn holm_and_benjamini_hochberg_agree_with_p_adjust() {
    // The fifteen p-values of Benjamini and Hochberg (1995), section 4 (thrombolysis trials).
    // Adjusted by statsmodels 0.15.0, multipletests(p, method='holm' and 'fdr_bh'), which agrees
    // with R's p.adjust(p, "holm") and p.adjust(p, "BH") by definition.
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
    let bh = [
        0.0015,
        0.003,
        0.0095,
        0.035625,
        0.0603,
        0.06385714285714286,
        0.06385714285714286,
        0.0645,
        0.0765,
        0.486,
        0.5811818181818182,
        0.714875,
        0.7532307692307693,
        0.8132142857142857,
        1.0,
    ];
    check_adjusted(multiplicity::benjamini_hochberg(&p), &bh);
    // The paper's own count: four rejections by the false discovery rate at .05, three by
    // Bonferroni and Holm.
    assert_eq!(bh.iter().filter(|p| **p <= 0.05).count(), 4);

    let unsorted = [0.04, 0.001, 0.5, 0.03, 0.03];
    check_adjusted(multiplicity::holm(&unsorted), &[0.12, 0.005, 0.5, 0.12, 0.12]);
    check_adjusted(multiplicity::benjamini_hochberg(&unsorted), &[0.05, 0.005, 0.5, 0.05, 0.05]);
    assert!(multiplicity::holm(&[]).is_ok_and(|p| p.is_empty()));
    for bad in [f64::NAN, -0.1, 1.1] {
        assert!(multiplicity::holm(&[0.1, bad]).is_err());
        assert!(multiplicity::benjamini_hochberg(&[0.1, bad]).is_err());
    }
}

#[test]
fn step_down_max_t_by_hand() {
    // Two statistics, four replicates; deviations +-1 and +-2 with these sample SDs.
    let rows = vec![vec![4.0, 1.0], vec![2.0, 3.0], vec![4.0, -1.0], vec![2.0, 1.0]];
    let matrix = ReplicateMatrix::new(vec![3.0, 1.0], rows, vec![]).expect("valid");
    let family = multiplicity::max_t(&matrix, 0.6).expect("both vary");
    let se = [(4.0_f64 / 3.0).sqrt(), (8.0_f64 / 3.0).sqrt()];
    // |t| = 3/1.155 = 2.598 and 1/1.633 = 0.612. Maxima over both: 0.866, 1.225, 1.225, 0.866:
    // none reaches 2.598, so p = 1/5; of the weaker alone (0, 1.225, 1.225, 0) two reach 0.612.
    for (j, p) in [0.2, 0.6].into_iter().enumerate() {
        let row = family.rows[j];
        assert!((row.standard_error - se[j]).abs() < 1e-15);
        assert_eq!(row.p_adjusted, p);
    }
    // Level 0.6 of 4 + 1: the third smallest maximum.
    assert!((family.critical - 2.0 / se[1]).abs() < 1e-15);
    assert!((family.rows[0].interval.upper - (3.0 + family.critical * se[0])).abs() < 1e-15);
    let constant = ReplicateMatrix::new(vec![1.0], vec![vec![2.0], vec![2.0]], vec![]);
    let constant = multiplicity::max_t(&constant.expect("valid"), 0.9);
    assert!(matches!(constant, Err(StatsError::ConstantReplicates { column: 0 })));
}

#[test]
fn simultaneous_intervals_cover_together() {
    // 300 cohorts each of 12 and 40 people, eight correlated cells, two of which are not zero.
    for people in [12_u8, 40] {
        joint_coverage(usize::from(people));
    }
}

/// Joint coverage and family-wise error at level 0.9 over 300 simulated cohorts.
fn joint_coverage(n: usize) {
    let truth = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, -2.0];
    let (mut covered, mut false_alarms, mut found) = (0_u16, 0_u16, 0_u16);
    for cohort in 0..300 {
        let mut rng = ChaCha8Rng::seed_from_u64(500 + cohort);
        let people: Vec<[f64; 8]> = (0..n)
            .map(|_| {
                let shared = normal(&mut rng);
                truth.map(|t| t + 0.6 * shared + 0.8 * normal(&mut rng))
            })
            .collect();
        let plan = Bootstrap { replicates: 500, level: 0.9, seed: cohort };
        let matrix = plan.people_matrix(&people, |drawn| {
            (0..8).map(|j| drawn.iter().map(|p| p[j]).sum::<f64>() / n as f64).collect()
        });
        let family = multiplicity::max_t(&matrix.expect("valid"), plan.level).expect("varies");
        covered +=
            u16::from(family.rows.iter().zip(truth).all(|(row, t)| row.interval.contains(t)));
        false_alarms += u16::from(family.rows[..6].iter().any(|row| row.p_adjusted < 0.1));
        found += u16::from(family.rows[6..].iter().all(|row| row.p_adjusted < 0.1));
    }
    let [covered, false_alarms, found] =
        [covered, false_alarms, found].map(|count| f64::from(count) / 300.0);
    // 90 % asked; binomial SD 1.7 %, three of them either way.
    assert!((0.848..0.952).contains(&covered), "{n} people: joint coverage {covered}");
    // At most 10 % asked, and the six null cells alone are judged.
    assert!(false_alarms < 0.152, "{n} people: family-wise error {false_alarms}");
    // Effects of 2 SD have t of about 7 in 12 people.
    assert!(found > 0.95, "{n} people: power {found}");
}
