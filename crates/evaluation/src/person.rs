//! One person's held-out windows under every method.

use cohort::{Person, Window, split_by_time};
use contract::run_errors::RunError;
use nn_statespace::PopulationModel;
use ode_sim::OdePlant;
use physiology::{MgPerDl, Plant};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use stats::Outcomes;
use twins::{
    PersonWindows, SteadyStates, Twin, inputs_within, measured, window_starts, window_starts_with,
};

use crate::error::EvaluationError;
use crate::forecast::{ForecastError, forecast_errors};
use crate::method::Method;
use crate::models::{Model, PersonModels};
use crate::readings::readings;
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
    let judge = Judge { person, cut, models, steady, settings };
    let (actual, methods) = judge.windows(&cut.test)?;
    let training_days = settings.protocol.training_days_of(&person.record);
    let test = split_by_time(&person.record, training_days).test;
    let mut scenarios = Vec::new();
    for scenario in Scenario::ALL {
        let rule = &settings.protocol.test;
        let windows = scenario.windows(index, person, &cut.inputs, test.clone(), rule)?;
        if !windows.is_empty() {
            let (actual, methods) = judge.windows(&windows)?;
            let windows = windows.len();
            scenarios.push(ScenarioEvaluation { scenario, windows, actual, methods });
        }
    }
    let training: Result<Vec<Outcomes>, EvaluationError> = cut
        .train
        .iter()
        .map(|window| {
            let readings = measured(person, window)?;
            Ok(Outcomes::of(readings[1..].iter().copied().map(MgPerDl))?)
        })
        .collect();
    Ok(PersonEvaluation {
        person_id: person.id.clone(),
        windows: cut.test.len(),
        actual,
        training: Outcomes::average(&training?)?,
        methods,
        scenarios,
        forecast: forecast_errors(index, person, cut, models, steady, settings)?,
    })
}

struct Judge<'a> {
    person: &'a Person,
    cut: &'a PersonWindows,
    models: &'a PersonModels,
    steady: &'a SteadyStates<'a, PopulationModel>,
    settings: &'a EvaluationSettings,
}

impl Judge<'_> {
    /// Measured outcomes over some windows, and what every method makes of them.
    fn windows(
        &self,
        windows: &[Window],
    ) -> Result<(Outcomes, Vec<MethodResult>), EvaluationError> {
        let Self { person, cut, steady, settings, .. } = *self;
        let steps: Vec<usize> = windows.iter().map(|window| window.start).collect();
        let start = settings.protocol.start;
        let network =
            window_starts_with(steady, person, &cut.inputs, &steps, start, cut.mean_basal)?;
        let mut glucose = Vec::with_capacity(windows.len());
        let mut actual = Vec::with_capacity(windows.len());
        for window in windows {
            let readings = measured(person, window)?;
            actual.push(Outcomes::of(readings[1..].iter().copied().map(MgPerDl))?);
            glucose.push(readings);
        }
        let mut methods = Vec::with_capacity(self.models.all().len());
        for (method, model) in self.models.all() {
            let of_network = |runs: Runs| (vec![runs], network.not_at_rest);
            let (runs, not_at_rest) = match model {
                Model::Twin(twin) | Model::Spread(twin, _) => {
                    of_network(self.of_twin(twin, &steps, windows)?)
                }
                Model::Population(population) => {
                    of_network(self.runs(&**population, &network.states, windows)?)
                }
                Model::Ode(plant) => {
                    self.of_plants(std::slice::from_ref(plant), &steps, windows)?
                }
                Model::Draws(plants) => self.of_plants(plants, &steps, windows)?,
            };
            let drawn = match model {
                Model::Spread(_, error) => Some(self.courses(error, &runs[0])),
                _ => None,
            };
            let courses = drawn.as_ref().unwrap_or(&runs);
            methods.push(summary(*method, &runs, courses, &glucose, not_at_rest)?);
        }
        Ok((Outcomes::average(&actual)?, methods))
    }

    /// A twin's runs, from its own starts: it may answer to doses with other gains than the population.
    fn of_twin(
        &self,
        twin: &Twin,
        steps: &[usize],
        windows: &[Window],
    ) -> Result<Runs, EvaluationError> {
        let (cut, start) = (self.cut, self.settings.protocol.start);
        let steady = self.steady.of(&twin.population);
        let own =
            window_starts_with(&steady, self.person, &cut.inputs, steps, start, cut.mean_basal)?;
        self.runs(twin, &own.states, windows)
    }

    /// Courses around each run: as many as make their own chance small beside a person's.
    fn courses(&self, error: &RunError, runs: &Runs) -> Vec<Runs> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.settings.bootstrap.seed ^ COURSES_SEED);
        // Streams by person.
        rng.set_stream(self.cut.test.first().map_or(0, |window| window.person as u64));
        (0..COURSES)
            .map(|_| runs.iter().map(|run| drawn_course(error, run, &mut rng)).collect())
            .collect()
    }

    /// Runs of each plant, and how many starts of the first are not at rest.
    fn of_plants(
        &self,
        plants: &[OdePlant],
        steps: &[usize],
        windows: &[Window],
    ) -> Result<(Vec<Runs>, usize), EvaluationError> {
        let mut not_at_rest = 0;
        let mut all = Vec::with_capacity(plants.len());
        for (index, plant) in plants.iter().enumerate() {
            let Self { person, cut, settings, .. } = *self;
            let start = settings.protocol.start;
            let found = window_starts(plant, person, &cut.inputs, steps, start, cut.mean_basal)?;
            if index == 0 {
                not_at_rest = found.not_at_rest;
            }
            all.push(self.runs(plant, &found.states, windows)?);
        }
        Ok((all, not_at_rest))
    }

    fn runs<P: Plant>(
        &self,
        plant: &P,
        starts: &[P::State],
        windows: &[Window],
    ) -> Result<Runs, EvaluationError> {
        let pairs = windows.iter().zip(starts);
        pairs
            .map(|(window, start)| {
                readings(plant, start.clone(), inputs_within(&self.cut.inputs, window))
            })
            .collect()
    }
}

/// Readings of each window, the start first.
type Runs = Vec<Vec<MgPerDl>>;

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
