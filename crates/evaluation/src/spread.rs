//! How far a person's glucose strays from a twin's free run.
//!
//! A twin answers with one course, the best guess. Glucose itself is one of many courses around it,
//! and times in ranges are of courses, not of best guesses: those of a best guess show too much time
//! in range. The paper meets this with penalties that pull the best guess towards the extremes; here
//! the courses themselves are drawn. The error of a run is taken as multiplicative, zero at the
//! start, and as an autoregression from half hour to half hour.

use cohort::Person;
use nn_statespace::PopulationModel;
use physiology::{MgPerDl, STEPS_PER_HOUR};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};
use twins::{
    PersonWindows, Protocol, SteadyStates, Twin, inputs_within, measured, window_starts_with,
};

use crate::error::EvaluationError;
use crate::person::{readings, sensor_reading};

/// The error of a twin's runs over the windows that were held out of its training.
///
/// `protocol` is the one with which the twin was trained, with
/// [`held_out_days`](Protocol::held_out_days); `None` where these days hold no window.
///
/// # Errors
/// Those of windows, starts and simulation.
pub fn run_error(
    index: usize,
    person: &Person,
    twin: &Twin,
    steady: &SteadyStates<'_, PopulationModel>,
    protocol: &Protocol,
) -> Result<Option<RunError>, EvaluationError> {
    let cut = PersonWindows::new(index, person, protocol)?;
    let steps: Vec<usize> = cut.held_out.iter().map(|window| window.start).collect();
    let starts =
        window_starts_with(steady, person, &cut.inputs, &steps, protocol.start, cut.mean_basal)?;
    let mut runs = Vec::with_capacity(steps.len());
    for (window, start) in cut.held_out.iter().zip(starts.states) {
        let run = readings(twin, start, inputs_within(&cut.inputs, window))?;
        runs.push((measured(person, window)?, run.into_iter().map(|g| g.0).collect()));
    }
    Ok(RunError::fit(&runs))
}

/// Steps between errors that are drawn; between them lies a straight line.
const SPACING: usize = STEPS_PER_HOUR / 2;
/// The share of an error that is left after half an hour is kept below this.
const MOST_LEFT: f64 = 0.98;

/// The error of free runs of one person's twin, of the logarithm of glucose.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RunError {
    /// Share of the error that is left after half an hour.
    pub left: f64,
    /// Standard deviation of what half an hour adds.
    pub added: f64,
}

impl RunError {
    /// Fits the errors of some runs, which should be of days that did not train the twin. Both courses
    /// of a pair are of one length, start with the same glucose and hold positive numbers, mg/dL:
    /// measured, then simulated. `None` where no run reaches half an hour.
    #[must_use]
    pub fn fit(runs: &[(Vec<f64>, Vec<f64>)]) -> Option<Self> {
        let errors: Vec<Vec<f64>> = runs
            .iter()
            .map(|(measured, simulated)| {
                let ratios = measured.iter().zip(simulated).step_by(SPACING);
                ratios.map(|(m, s)| (m / s).ln()).collect()
            })
            .collect();
        let pairs: Vec<(f64, f64)> = errors
            .iter()
            .flat_map(|errors| errors.windows(2).map(|pair| (pair[0], pair[1])))
            .collect();
        if pairs.is_empty() {
            return None;
        }
        let (mut xx, mut xy) = (0.0, 0.0);
        for (before, now) in &pairs {
            xx += before * before;
            xy += before * now;
        }
        let left = if xx > 0.0 { (xy / xx).clamp(0.0, MOST_LEFT) } else { 0.0 };
        let squares: f64 = pairs.iter().map(|(before, now)| (now - left * before).powi(2)).sum();
        Some(Self { left, added: (squares / pairs.len() as f64).sqrt() })
    }

    /// One course around a run: what a sensor could have read, with the run's mean.
    #[must_use]
    pub fn draw(&self, run: &[MgPerDl], rng: &mut ChaCha8Rng) -> Vec<MgPerDl> {
        let (mut error, mut variance) = (0.0, 0.0);
        let mut nodes = vec![(0.0, 0.0)];
        while (nodes.len() - 1) * SPACING < run.len() {
            let drawn: f64 = rng.sample(StandardNormal);
            error = self.left * error + self.added * drawn;
            variance = self.left.powi(2) * variance + self.added.powi(2);
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
                sensor_reading(MgPerDl(glucose.0 * (error - shift).exp()))
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use rand_chacha::rand_core::SeedableRng;

    use super::*;

    #[test]
    fn drawn_courses_have_the_error_that_they_were_drawn_with_and_the_runs_mean() {
        let truth = RunError { left: 0.8, added: 0.15 };
        let run = vec![MgPerDl(150.0); 61];
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let drawn: Vec<Vec<f64>> = (0..800)
            .map(|_| truth.draw(&run, &mut rng).into_iter().map(|g| g.0).collect())
            .collect();
        let flat: Vec<f64> = run.iter().map(|g| g.0).collect();
        let pairs: Vec<(Vec<f64>, Vec<f64>)> =
            drawn.iter().map(|course| (course.clone(), flat.clone())).collect();
        let found = RunError::fit(&pairs).expect("runs");
        // 8,000 half hours; the mean that is taken out shows as a small drift.
        assert!((found.left - 0.8).abs() < 0.03, "{found:?}");
        assert!((found.added - 0.15).abs() < 0.01, "{found:?}");
        let mean = drawn.iter().map(|course| course[60]).sum::<f64>() / 800.0;
        // A standard deviation of 37 over 800 courses, and a sensor that ends at 400.
        assert!((mean - 150.0).abs() < 4.0, "{mean}");
        assert!(drawn.iter().all(|course| course[0] == 150.0));
        assert_eq!(RunError::fit(&[(vec![100.0], vec![100.0])]), None);
    }
}
