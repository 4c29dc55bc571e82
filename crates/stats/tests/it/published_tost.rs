//! TOST against published output and independent software.

use proptest::prelude::*;
use stats::{Outcome, StatsError, Tost, tost};

/// Compares t's, p and interval with reference values.
fn check(test: &Tost, t: (f64, f64), p: f64, interval: (f64, f64), tolerance: f64) {
    for (name, ours, reference) in [
        ("t_lower", test.t_lower, t.0),
        ("t_upper", test.t_upper, t.1),
        ("p", test.p, p),
        ("lower", test.interval.lower, interval.0),
        ("upper", test.interval.upper, interval.1),
    ] {
        assert!((ours - reference).abs() <= tolerance, "{name}: {ours} against {reference}");
    }
}

/// Measured and simulated time in range of ten people.
const ACTUAL: [f64; 10] = [72.1, 65.3, 80.4, 58.9, 90.2, 77.7, 69.5, 84.1, 61.0, 74.6];
const SIMULATED: [f64; 10] = [74.0, 63.1, 83.2, 60.5, 88.4, 80.9, 70.1, 86.0, 58.8, 77.2];

#[test]
fn agrees_with_statsmodels() {
    // statsmodels 0.15.0: ttost_paired(simulated, actual, -m, m) for m = 5, 2, 1; interval from
    // scipy 1.17.1: ttest_rel(simulated, actual).confidence_interval(0.9).
    let interval = (-0.3949008808942672, 2.074900880894271);
    for (margin, p, t_lower, t_upper) in [
        (5.0, 8.183739210050064e-05, 8.669019264898404, -6.175191805133106),
        (2.0, 0.059592325997688676, 4.2157559438889525, -1.7219284841236522),
        (1.0, 0.4087908358811365, 2.731334836885801, -0.23750737712050127),
    ] {
        let test = tost::paired(&ACTUAL, &SIMULATED, margin, 0.05).expect("ten pairs");
        // 1e-9: the t quantile is found by iteration in both programs.
        check(&test, (t_lower, t_upper), p, interval, 1e-9);
        assert_eq!(test.equivalent, p < 0.05);
    }
}

#[test]
fn agrees_with_students_sleep_data() {
    // Cushny and Peebles (1905) as analysed by Student (1908), R's `sleep`; R's manual page of
    // `t.test` prints the paired 95 % interval -2.4598858 -0.7001142 and mean difference -1.58.
    let first = [0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0];
    let second = [1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4];
    let test = tost::paired(&second, &first, 0.5, 0.025).expect("ten pairs");
    assert!((test.difference + 1.58).abs() < 1e-12, "{}", test.difference);
    // Seven digits are printed.
    assert!((test.interval.lower + 2.4598858).abs() < 1e-7);
    assert!((test.interval.upper + 0.7001142).abs() < 1e-7);
    // scipy 1.17.1: stats.t.sf(t_lower, 9), with t = (mean +- 0.5) / (sd / sqrt(10)).
    assert!((test.t_lower + 2.7766442392737973).abs() < 1e-9);
    assert!((test.t_upper + 5.347611127490276).abs() < 1e-9);
    assert!((test.p - 0.9892407566216127).abs() < 1e-9);
}

#[test]
fn agrees_with_printed_toster_output() {
    // R package TOSTER, TOSTone.raw on 768 differences with SD 7.586978 and bounds +-1.5, as
    // printed in a public analysis (BitcoinValidation): t(767) = 2.40 and -8.56, p = .00834,
    // 90 % interval [-1.294, -0.392], whose centre gives the mean difference, -0.843.
    let test = tost::from_summary(768, -0.843, 7.586978, 1.5, 0.05).expect("valid");
    // Tolerances are half a unit of the printed digits, and for p the slope of the tail
    // (0.022 per unit of t) times the rounding of the mean (0.0005 / 0.274).
    assert!((test.t_lower - 2.40).abs() < 0.005, "{}", test.t_lower);
    assert!((test.t_upper + 8.56).abs() < 0.005, "{}", test.t_upper);
    assert!((test.p - 0.00834).abs() < 5e-5, "{}", test.p);
    assert!((test.interval.lower + 1.294).abs() < 0.0011);
    assert!((test.interval.upper + 0.392).abs() < 0.0011);
    assert!(test.equivalent);
}

#[test]
fn tails_do_not_round_to_zero_early() {
    // scipy 1.17.1: stats.t.sf(30, 393) = 5.632001286403911e-104. Here t = 30 at both margins:
    // difference 0, margin 30 sd / sqrt(394).
    let sd = 394.0_f64.sqrt() / 30.0;
    let test = tost::from_summary(394, 0.0, sd, 1.0, 0.05).expect("valid");
    // Relative 1e-8: log-gamma of both programs at the 340th power of e.
    assert!((test.p / 5.632001286403911e-104 - 1.0).abs() < 1e-8, "{}", test.p);
}

#[test]
fn the_papers_sleep_tbr_p_value_is_impossible() {
    // The paper, scenario sleep, all inputs: TBR 2.6 real against 3.7 simulated, margin 1 point,
    // printed p = .001. The observed difference, 1.1, lies outside the margin, so the test
    // against the upper margin has t > 0 and p > .5 whatever the SD and the number of people.
    for n in [2, 10, 394, 100_000] {
        for sd in [1e-9, 0.1, 1.0, 8.3, 100.0] {
            let test = tost::from_summary(n, 3.7 - 2.6, sd, Outcome::Tbr.margin(), 0.05);
            let test = test.expect("valid");
            assert!(test.p > 0.5 && !test.equivalent, "n {n}, sd {sd}: p = {}", test.p);
        }
    }
    // Even at the ends of what rounds to the printed means, 2.65 and 3.65, the difference is
    // exactly the margin, and p cannot fall below .5 (less the rounding of 3.65 - 2.65).
    let most_favourable = tost::from_summary(394, 3.65 - 2.65, 8.0, 1.0, 0.05).expect("valid");
    assert!(most_favourable.p > 0.5 - 1e-12, "{}", most_favourable.p);
}

#[test]
fn differences_that_do_not_vary_are_at_the_limit() {
    let actual = [1.0, 2.0, 3.0];
    let shifted = |by: f64| actual.map(|a| a + by);
    for (shift, p, equivalent) in [(0.5, 0.0, true), (-0.5, 0.0, true), (2.0, 1.0, false)] {
        let test = tost::paired(&actual, &shifted(shift), 1.0, 0.05).expect("three pairs");
        assert_eq!((test.p, test.equivalent, test.sd), (p, equivalent, 0.0), "{shift}");
        assert_eq!((test.interval.lower, test.interval.upper), (shift, shift));
    }
    let on_it = tost::paired(&actual, &shifted(1.0), 1.0, 0.05).expect("three pairs");
    // The centre of the t distribution, to the accuracy of the incomplete beta function.
    assert!((on_it.p - 0.5).abs() < 1e-12 && !on_it.equivalent);
}

#[test]
fn bad_input_is_named() {
    let too_few = tost::paired(&[1.0], &[1.0], 1.0, 0.05);
    assert!(matches!(too_few, Err(StatsError::TooFew { n: 1, needed: 2, .. })));
    let unpaired = tost::paired(&[1.0, 2.0], &[1.0], 1.0, 0.05);
    assert!(matches!(unpaired, Err(StatsError::Unpaired { left: 2, right: 1 })));
    let nan = tost::paired(&[1.0, f64::NAN], &[1.0, 2.0], 1.0, 0.05);
    assert!(matches!(nan, Err(StatsError::NonFinite { what: "actual", index: 1, .. })));
    for (sd, margin, alpha) in
        [(-1.0, 1.0, 0.05), (1.0, 0.0, 0.05), (1.0, f64::NAN, 0.05), (1.0, 1.0, 0.5)]
    {
        let result = tost::from_summary(5, 0.0, sd, margin, alpha);
        assert!(matches!(result, Err(StatsError::OutOfDomain { .. })), "{result:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Equivalence at alpha and the (1 - 2 alpha) interval inside the margin are the same thing.
    #[test]
    fn test_and_interval_agree(
        n in 2_usize..500,
        difference in -3.0_f64..3.0,
        sd in 0.01_f64..10.0,
        margin in 0.1_f64..3.0,
        alpha in 0.01_f64..0.2,
    ) {
        let test = tost::from_summary(n, difference, sd, margin, alpha).expect("valid");
        let inside = -margin < test.interval.lower && test.interval.upper < margin;
        // Within rounding of the border both answers are right.
        prop_assume!((test.p - alpha).abs() > 1e-9);
        prop_assert_eq!(test.equivalent, inside);
        prop_assert_eq!(difference.abs() >= margin, test.p >= 0.5 - 1e-12);
    }
}
