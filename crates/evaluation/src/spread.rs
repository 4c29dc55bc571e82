//! How far a person's glucose strays from a twin's free run.
//!
//! A twin answers with one course, the best guess. Glucose itself is one of many courses around it,
//! and times in ranges are of courses, not of best guesses: those of a best guess show too much time
//! in range. The paper meets this with penalties that pull the best guess towards the extremes; here
//! the courses themselves are drawn, in two steps. The error of a run is a factor, one at the start, whose
//! logarithm is an autoregression from half hour to half hour. What is drawn so goes through a map of the
//! person's own that takes the quantiles of drawn glucose to those of measured glucose (quantile mapping, as
//! forecasts of weather are set right): errors do not know of counter-regulation, of food against lows, or of
//! a best guess that is at its extremes too often. Both are learned on days that did not train the twin.

use std::collections::BTreeMap;

use cohort::Person;
use contract::run_errors::{QuantileMap, RunError, RunErrors};
use nn_statespace::PopulationModel;
use physiology::{MgPerDl, STEPS_PER_HOUR};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use stats::quantile;
use twins::{PersonWindows, Protocol, SteadyStates, Twin, measured};

use crate::error::EvaluationError;
use crate::readings::{runs, sensor_reading, within};

/// Fewest windows on held-out days from which a person's own errors are told: a day of hourly starts.
const LEAST_RUNS: usize = 24;

/// A window's readings and a free run through it, mg/dL, the start first in both.
pub type HeldOutRun = (Vec<f64>, Vec<f64>);

/// A twin's runs through the windows that were held out of its training.
///
/// `protocol` is the one with which the twin was trained, with
/// [`held_out`](Protocol::held_out); none where these days hold no window.
///
/// # Errors
/// Those of windows, starts and simulation.
pub fn held_out_runs(
    index: usize,
    person: &Person,
    twin: &Twin,
    steady: &SteadyStates<'_, PopulationModel>,
    protocol: &Protocol,
) -> Result<Vec<HeldOutRun>, EvaluationError> {
    let cut = PersonWindows::new(index, person, protocol)?;
    let parts = within(&cut.held_out);
    let (runs, _) = runs(twin, &steady.of(&twin.population), (person, &cut), &parts)?;
    let pairs = cut.held_out.iter().zip(runs);
    pairs
        .map(|(window, run)| {
            Ok((measured(person, window)?, run.into_iter().map(|g| g.0).collect()))
        })
        .collect()
}

/// Steps between errors that are drawn; between them lies a straight line.
const SPACING: usize = STEPS_PER_HOUR / 2;
/// The share of an error that is left after half an hour is kept below this.
const MOST_LEFT: f64 = 0.98;
/// Steps from a window's start over which the map sets in; quantiles are those after it.
const SETTING_IN: usize = STEPS_PER_HOUR;
/// Quantiles of a map.
const LEVELS: usize = 250;
/// Courses drawn around each run to learn a map.
const COURSES_OF_MAP: usize = 4;

/// The errors of each of `people` by their own runs; somebody with too few gets the errors of all.
/// `None` where no run is longer than an hour.
pub fn run_errors_by_person<'a>(
    people: impl IntoIterator<Item = &'a str>,
    runs: &BTreeMap<&str, Vec<HeldOutRun>>,
    rng: &mut ChaCha8Rng,
) -> Option<RunErrors> {
    let usual = run_error(runs.values().flatten(), rng)?;
    let mut of = |id: &str| {
        let own = runs.get(id).filter(|runs| runs.len() >= LEAST_RUNS);
        own.and_then(|runs| run_error(runs, rng)).unwrap_or_else(|| usual.clone())
    };
    Some(RunErrors(people.into_iter().map(|id| (id.to_owned(), of(id))).collect()))
}

/// Fits the errors of some runs, which should be of days that did not train the twin. Both courses
/// of a pair are of one length and start with the same glucose, mg/dL: measured, then simulated.
/// `None` where no run is longer than an hour.
#[must_use]
pub fn run_error<'a>(
    runs: impl IntoIterator<Item = &'a HeldOutRun>,
    rng: &mut ChaCha8Rng,
) -> Option<RunError> {
    let runs: Vec<&HeldOutRun> =
        runs.into_iter().filter(|(measured, _)| measured.len() > SETTING_IN).collect();
    let (mut xx, mut xy) = (0.0, 0.0);
    let mut pairs = Vec::new();
    for (measured, simulated) in &runs {
        let nodes = measured.iter().zip(simulated).step_by(SPACING);
        let errors: Vec<f64> =
            nodes.map(|(m, s)| (sensor_reading(*m) / sensor_reading(*s)).ln()).collect();
        pairs.extend(errors.windows(2).map(|pair| (pair[0], pair[1])));
    }
    if pairs.is_empty() {
        return None;
    }
    for (before, now) in &pairs {
        xx += before * before;
        xy += before * now;
    }
    let left = if xx > 0.0 { (xy / xx).clamp(0.0, MOST_LEFT) } else { 0.0 };
    let squares: f64 = pairs.iter().map(|(before, now)| (now - left * before).powi(2)).sum();
    let added = (squares / pairs.len() as f64).sqrt();
    let mut fit = RunError { left, added, map: QuantileMap::default() };
    let (mut drawn, mut observed) = (Vec::new(), Vec::new());
    for (measured, simulated) in runs {
        observed.extend(measured[SETTING_IN..].iter().map(|glucose| sensor_reading(*glucose)));
        let run: Vec<MgPerDl> = simulated.iter().map(|glucose| MgPerDl(*glucose)).collect();
        for _ in 0..COURSES_OF_MAP {
            drawn.extend(
                drawn_course(&fit, &run, rng)[SETTING_IN..].iter().map(|glucose| glucose.0),
            );
        }
    }
    fit.map = map_between(drawn, observed);
    Some(fit)
}

/// One course around a run: what a sensor could have read.
#[must_use]
pub fn drawn_course(of: &RunError, run: &[MgPerDl], rng: &mut ChaCha8Rng) -> Vec<MgPerDl> {
    let (mut error, mut variance) = (0.0, 0.0);
    let mut nodes = vec![(0.0, 0.0)];
    while (nodes.len() - 1) * SPACING < run.len() {
        let drawn: f64 = rng.sample(StandardNormal);
        error = of.left * error + of.added * drawn;
        variance = of.left.powi(2) * variance + of.added.powi(2);
        nodes.push((error, variance));
    }
    run.iter()
        .enumerate()
        .map(|(step, glucose)| {
            let (node, share) = (step / SPACING, (step % SPACING) as f64 / SPACING as f64);
            let between = |a: f64, b: f64| a + share * (b - a);
            let (before, after) = (nodes[node], nodes[(node + 1).min(nodes.len() - 1)]);
            let error = between(before.0, after.0);
            // The mean of a lognormal factor is taken out.
            let shift = 0.5 * between(before.1, after.1);
            let drawn = sensor_reading(sensor_reading(glucose.0) * (error - shift).exp());
            let share = (step as f64 / SETTING_IN as f64).min(1.0);
            MgPerDl(sensor_reading(drawn + share * moved_by(&of.map, drawn)))
        })
        .collect()
}

/// The map from the distribution of some values to that of others, neither of them empty.
fn map_between(mut from: Vec<f64>, mut to: Vec<f64>) -> QuantileMap {
    from.sort_by(f64::total_cmp);
    to.sort_by(f64::total_cmp);
    let mut knots: Vec<(f64, f64)> = Vec::with_capacity(LEVELS);
    let mut same = 0.0;
    for level in 0..LEVELS {
        let level = (level as f64 + 0.5) / LEVELS as f64;
        let (from, to) = (quantile(&from, level), quantile(&to, level));
        match knots.last_mut() {
            // Where many values are one, as at the ends of a sensor's range, they go to the mean.
            Some((last, mean)) if from <= *last => {
                same += 1.0;
                *mean += (to - *mean) / same;
            }
            _ => {
                same = 1.0;
                knots.push((from, to));
            }
        }
    }
    QuantileMap { knots }
}

/// By how much the map moves a value; beyond its knots by as much as at the nearest.
fn moved_by(map: &QuantileMap, value: f64) -> f64 {
    let after = map.knots.partition_point(|(from, _)| *from < value);
    let shift = |knot: &(f64, f64)| knot.1 - knot.0;
    match (after.checked_sub(1).and_then(|k| map.knots.get(k)), map.knots.get(after)) {
        (None, None) => 0.0,
        (Some(knot), None) | (None, Some(knot)) => shift(knot),
        (Some(low), Some(high)) => {
            let share = (value - low.0) / (high.0 - low.0);
            shift(low) + share * (shift(high) - shift(low))
        }
    }
}

#[cfg(test)]
mod tests {
    use rand_chacha::rand_core::SeedableRng;

    use super::*;

    fn below(courses: &[Vec<f64>], level: f64) -> f64 {
        let all: Vec<f64> = courses.iter().flat_map(|c| c[SETTING_IN..].iter().copied()).collect();
        all.iter().filter(|glucose| **glucose < level).count() as f64 / all.len() as f64
    }

    #[test]
    fn drawn_courses_have_the_error_that_they_were_drawn_with_and_the_runs_mean() {
        let truth = RunError { left: 0.8, added: 0.15, map: QuantileMap::default() };
        let run = vec![MgPerDl(150.0); 61];
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut draws = |error: &RunError| -> Vec<Vec<f64>> {
            (0..800)
                .map(|_| drawn_course(error, &run, &mut rng).into_iter().map(|g| g.0).collect())
                .collect()
        };
        let drawn = draws(&truth);
        let flat: Vec<f64> = run.iter().map(|g| g.0).collect();
        let pairs: Vec<HeldOutRun> =
            drawn.iter().map(|course| (course.clone(), flat.clone())).collect();
        let mut other = ChaCha8Rng::seed_from_u64(4);
        let found = run_error(&pairs, &mut other).expect("runs");
        // 8,000 half hours; the mean that is taken out shows as a small drift.
        assert!((found.left - 0.8).abs() < 0.03, "{found:?}");
        assert!((found.added - 0.15).abs() < 0.01, "{found:?}");
        let mean = drawn.iter().map(|course| course[60]).sum::<f64>() / 800.0;
        // A standard deviation of 37 over 800 courses, and a sensor that ends at 400.
        assert!((mean - 150.0).abs() < 4.0, "{mean}");
        assert!(drawn.iter().all(|course| (course[0] - 150.0).abs() < 1e-9));
        // What is drawn with the right errors needs no map: shares below some levels stay.
        let again = draws(&found);
        for level in [110.0, 150.0, 200.0] {
            let (one, other) = (below(&drawn, level), below(&again, level));
            assert!((one - other).abs() < 0.02, "{level}: {one} {other}");
        }
        let short = (vec![100.0; 5], vec![100.0; 5]);
        assert_eq!(run_error(&[short], &mut other), None);
    }

    #[test]
    fn the_map_takes_drawn_glucose_to_what_is_measured_as_often() {
        // Nobody falls below 65: errors alone would draw such courses.
        let truth = RunError { left: 0.9, added: 0.2, map: QuantileMap::default() };
        let run = vec![MgPerDl(110.0); 61];
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let measured: Vec<Vec<f64>> = (0..400)
            .map(|_| {
                drawn_course(&truth, &run, &mut rng).into_iter().map(|g| g.0.max(65.0)).collect()
            })
            .collect();
        let flat = vec![110.0; 61];
        let pairs: Vec<HeldOutRun> =
            measured.iter().map(|course| (course.clone(), flat.clone())).collect();
        let found = run_error(&pairs, &mut rng).expect("runs");
        let bare = RunError { map: QuantileMap::default(), ..found.clone() };
        let mut draws = |error: &RunError| -> Vec<Vec<f64>> {
            (0..400)
                .map(|_| drawn_course(error, &run, &mut rng).into_iter().map(|g| g.0).collect())
                .collect()
        };
        let (mapped, unmapped) = (draws(&found), draws(&bare));
        assert!(below(&unmapped, 60.0) > 0.03, "{}", below(&unmapped, 60.0));
        assert!(below(&mapped, 60.0) < 0.005, "{}", below(&mapped, 60.0));
        let (observed, mapped) = (below(&measured, 110.0), below(&mapped, 110.0));
        assert!((observed - mapped).abs() < 0.03, "{observed} {mapped}");
    }

    #[test]
    fn a_map_rises_and_ties_go_to_their_mean() {
        let map = map_between(vec![40.0, 40.0, 40.0, 100.0], vec![50.0, 60.0, 70.0, 120.0]);
        assert!(map.knots.windows(2).all(|k| k[0].0 < k[1].0 && k[0].1 <= k[1].1), "{map:?}");
        assert!((moved_by(&map, 40.0) - 20.0).abs() < 1.0, "{}", moved_by(&map, 40.0));
        assert!((moved_by(&map, 30.0) - moved_by(&map, 40.0)).abs() < 1e-12);
        assert!((moved_by(&map, 400.0) - 20.0).abs() < 1.0, "{}", moved_by(&map, 400.0));
    }
}
