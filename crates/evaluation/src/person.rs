//! One person's held-out windows under every method.

use cohort::{Person, Window, split_by_time};
use contract::run_errors::RunError;
use nn_statespace::PopulationModel;
use physiology::MgPerDl;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use stats::Outcomes;
use twins::{PersonWindows, SteadyStates, measured, window_starts_with};

use crate::error::EvaluationError;
use crate::forecast::{ForecastError, forecast_errors};
use crate::method::Method;
use crate::models::{Model, PersonModels};
use crate::readings::{Runs, within};
use crate::scenario::Scenario;
use crate::settings::EvaluationSettings;
use crate::spread::drawn_course;

/// One person's figures.
#[derive(Debug, Clone)]
pub struct PersonEvaluation {
    /// The person's identifier.
    pub person_id: String,
    /// Test windows.
    pub windows: usize,
    /// Outcomes of the sensor readings, averaged over windows.
    pub actual: Outcomes,
    /// The same over the training windows.
    pub training: Outcomes,
    /// Figures of each method.
    pub methods: Vec<MethodResult>,
    /// The same over windows that begin with an event; scenarios without windows are absent.
    pub scenarios: Vec<ScenarioEvaluation>,
    /// Forecast errors of every forecaster and horizon.
    pub forecast: Vec<ForecastError>,
}

/// Figures over the windows of one scenario.
#[derive(Debug, Clone)]
pub struct ScenarioEvaluation {
    /// What the windows begin with.
    pub scenario: Scenario,
    /// Windows.
    pub windows: usize,
    /// Outcomes of the sensor readings, averaged over windows.
    pub actual: Outcomes,
    /// Figures of each method.
    pub methods: Vec<MethodResult>,
}

/// What one method made of a person's windows.
#[derive(Debug, Clone, Copy)]
pub struct MethodResult {
    /// The method.
    pub method: Method,
    /// Outcomes of the simulated readings, averaged over windows.
    pub outcomes: Outcomes,
    /// Root mean squared error over all windows and steps after the start, mg/dL.
    pub rmse: f64,
    /// Windows whose start is no steady state although one was asked for.
    pub not_at_rest: usize,
}

impl PersonEvaluation {
    /// The figures of a method.
    #[must_use]
    pub fn of(&self, method: Method) -> Option<&MethodResult> {
        self.methods.iter().find(|found| found.method == method)
    }

    /// The windows of a scenario.
    #[must_use]
    pub fn in_scenario(&self, scenario: Scenario) -> Option<&ScenarioEvaluation> {
        self.scenarios.iter().find(|found| found.scenario == scenario)
    }
}

/// Courses drawn around a run.
const COURSES: usize = 24;
/// Separates the seed of these courses from that of the bootstrap.
const COURSES_SEED: u64 = 0x636f_7572_7365_7300;

pub(crate) fn evaluate_person(
    index: usize,
    person: &Person,
    cut: &PersonWindows,
    models: &PersonModels,
    steady: &SteadyStates<'_, PopulationModel>,
    settings: &EvaluationSettings,
) -> Result<PersonEvaluation, EvaluationError> {
    // Streams by person.
    let mut rng = ChaCha8Rng::seed_from_u64(settings.bootstrap.seed ^ COURSES_SEED);
    rng.set_stream(index as u64);
    // Measured outcomes over some windows, and what every method makes of them.
    let judge = |windows: &[Window]| -> Result<(Outcomes, Vec<MethodResult>), EvaluationError> {
        let glucose = windows.iter().map(|window| measured(person, window));
        let glucose: Vec<Vec<f64>> = glucose.collect::<Result<_, _>>()?;
        // Steady states are kept as they are first found; a network with gains on doses finds the
        // same but for rounding. Those of the plain network are found first, whatever the methods.
        let starts: Vec<usize> = windows.iter().map(|window| window.start).collect();
        window_starts_with(steady, person, &cut.inputs, &starts, cut.start, cut.mean_basal)?;
        let mut methods = Vec::with_capacity(models.all().len());
        for (method, model) in models.all() {
            let (runs, not_at_rest) = model.runs(steady, (person, cut), &within(windows))?;
            let drawn = match model {
                Model::Spread(_, error) => Some(courses(error, &runs[0], rng.clone())),
                _ => None,
            };
            let courses = drawn.as_ref().unwrap_or(&runs);
            methods.push(summary(*method, &runs, courses, &glucose, not_at_rest)?);
        }
        Ok((average(glucose)?, methods))
    };
    let (actual, methods) = judge(&cut.test)?;
    let training_days = settings.protocol.training_days_of(&person.record);
    let test = split_by_time(&person.record, training_days).test;
    let mut scenarios = Vec::new();
    for scenario in Scenario::ALL {
        let rule = &settings.protocol.test;
        let windows = scenario.windows(index, person, &cut.inputs, test.clone(), rule)?;
        if !windows.is_empty() {
            let (actual, methods) = judge(&windows)?;
            let windows = windows.len();
            scenarios.push(ScenarioEvaluation { scenario, windows, actual, methods });
        }
    }
    let training = cut.train.iter().map(|window| measured(person, window));
    Ok(PersonEvaluation {
        person_id: person.id.clone(),
        windows: cut.test.len(),
        actual,
        training: average(training.collect::<Result<Vec<_>, _>>()?)?,
        methods,
        scenarios,
        forecast: forecast_errors(index, person, cut, models, steady, settings)?,
    })
}

/// Outcomes of windows' readings after the first, where every run starts, averaged over windows.
fn average(windows: Vec<Vec<f64>>) -> Result<Outcomes, EvaluationError> {
    let after = windows.into_iter().map(|readings| readings.into_iter().skip(1).map(MgPerDl));
    let outcomes: Vec<Outcomes> = after.map(Outcomes::of).collect::<Result<_, _>>()?;
    Ok(Outcomes::average(&outcomes)?)
}

/// Courses around each run: as many as make their own chance small beside a person's.
fn courses(error: &RunError, runs: &Runs, mut rng: ChaCha8Rng) -> Vec<Runs> {
    (0..COURSES)
        .map(|_| runs.iter().map(|run| drawn_course(error, run, &mut rng)).collect())
        .collect()
}

/// A method's outcomes, averaged over courses and windows, and the error of the mean of its runs.
fn summary(
    method: Method,
    runs: &[Runs],
    courses: &[Runs],
    measured: &[Vec<f64>],
    not_at_rest: usize,
) -> Result<MethodResult, EvaluationError> {
    let mut outcomes = Vec::with_capacity(measured.len() * courses.len());
    let (mut squares, mut samples) = (0.0, 0);
    for (window, measured) in measured.iter().enumerate() {
        for course in courses {
            outcomes.push(Outcomes::of(course[window][1..].iter().copied())?);
        }
        for (step, measured) in measured.iter().enumerate().skip(1) {
            let sum: f64 = runs.iter().map(|run| run[window][step].0).sum();
            squares += (sum / runs.len() as f64 - measured).powi(2);
            samples += 1;
        }
    }
    Ok(MethodResult {
        method,
        outcomes: Outcomes::average(&outcomes)?,
        rmse: (squares / f64::from(samples)).sqrt(),
        not_at_rest,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_share_their_mean_course_and_average_their_outcomes() {
        let draw = |value: f64| vec![vec![MgPerDl(100.0), MgPerDl(value), MgPerDl(value)]];
        let measured = [vec![100.0, 150.0, 150.0]];
        let draws = [draw(60.0), draw(200.0)];
        let found = summary(Method::Posterior, &draws, &draws, &measured, 0).expect("finite");
        // The mean course is 130, in range; of the draws one is below, one above.
        assert!((found.rmse - 20.0).abs() < 1e-12);
        assert_eq!(found.outcomes.get(stats::Outcome::Tir), 0.0);
        assert_eq!(found.outcomes.get(stats::Outcome::Tbr), 50.0);
    }
}
