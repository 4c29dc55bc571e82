//! `outcomes.json` and `twins.json`.

use serde::{Deserialize, Serialize};
use stats::{Bootstrap, Outcomes, Summary, compare_outcomes, multiplicity, paired, tost};
use twins::PersonTwin;

use crate::error::EvaluationError;
use crate::evaluate::{Evaluation, EvaluationSettings};
use crate::forecast::{FORECAST_MINUTES, Forecaster};
use crate::method::Method;
use crate::person::{MethodResult, PersonEvaluation};
use crate::scenario::Scenario;

/// `outcomes.json`: the six outcomes of every method, and forecast errors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OutcomesTable {
    /// `outcomes/1`.
    pub schema: String,
    /// Name of the cohort.
    pub cohort: String,
    /// People judged.
    pub people: usize,
    /// Windows judged, over all people.
    pub windows: usize,
    /// Length of a window, min.
    pub window_minutes: u32,
    /// How the intervals were made.
    pub interval: IntervalMethod,
    /// People left out, with the reason.
    pub exclusions: Vec<ExclusionRow>,
    /// The sensor on the training days in place of a method: what a person's own weeks tell of the next. An
    /// outcome that is not equivalent here changes too much from week to week to be asked of a simulator
    /// that was fitted to these days.
    #[serde(default)]
    pub training_days: Vec<OutcomeRow>,
    /// One entry a method, the twin first; twins with other inputs are in `ablation`.
    pub methods: Vec<MethodRows>,
    /// Five-hour error of twins against other methods'.
    pub comparisons: Vec<Comparison>,
    /// Twins that see other personal inputs, over all windows.
    #[serde(default)]
    pub ablation: Vec<MethodRows>,
    /// Windows that begin with an event: twins with all and with other inputs, and the population
    /// model (paper, Table `inputsContributions`).
    #[serde(default)]
    pub scenarios: Vec<ScenarioTable>,
    /// One entry a forecaster and horizon.
    pub forecast: Vec<ForecastRow>,
}

/// How intervals were made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct IntervalMethod {
    /// In words.
    pub method: String,
    /// Confidence level.
    pub level: f64,
    /// Bootstrap samples.
    pub replicates: usize,
}

/// A person who was left out.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExclusionRow {
    /// The person's identifier.
    pub person_id: String,
    /// Why.
    pub reason: String,
}

/// One method against the sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MethodRows {
    /// The key of the method.
    pub name: String,
    /// The name for people.
    pub label: String,
    /// One row an outcome.
    pub rows: Vec<OutcomeRow>,
    /// Root mean squared error over the windows, mg/dL, over people.
    pub rmse_5h: Spread,
    /// Windows whose start is no steady state although one was asked for.
    pub starts_not_at_rest: usize,
}

/// The windows of one scenario.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ScenarioTable {
    /// The key of the scenario.
    pub scenario: String,
    /// The name for people.
    pub label: String,
    /// People with such windows.
    pub people: usize,
    /// Windows, over all people.
    pub windows: usize,
    /// One entry a method; empty below two people.
    pub methods: Vec<MethodRows>,
}

/// Mean and standard deviation over people.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Sample standard deviation.
    pub sd: f64,
}

/// An estimate with its interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WithInterval {
    /// The estimate.
    pub value: f64,
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

/// One outcome of one method, over people.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OutcomeRow {
    /// `tir`, `tar`, `tbr`, `lbgi`, `hbgi` or `mg`.
    pub metric: String,
    /// Its unit; empty where dimensionless.
    pub unit: String,
    /// Equivalence margin in that unit.
    pub margin: f64,
    /// The sensor's.
    pub actual: Spread,
    /// The method's.
    pub simulated: Spread,
    /// Simulated minus actual with its bootstrap interval over people.
    pub difference: WithInterval,
    /// The same with the interval of the two one-sided t-tests.
    pub difference_t: WithInterval,
    /// The larger p of the two one-sided tests.
    pub p: f64,
    /// That p adjusted for six outcomes (Holm).
    pub p_holm: f64,
    /// Whether p is below the level.
    pub equivalent: bool,
    /// The p that the same scatter between people would give without any bias: where it is above the
    /// level, so few people cannot show equivalence.
    pub p_unbiased: f64,
}

/// A figure of the twin against the same figure of another method, compared within people.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// The key of the first method, the twin.
    pub first: String,
    /// The key of the other method.
    pub second: String,
    /// What is compared.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
    /// Mean over people of first minus second; negative where the twin errs less.
    pub difference: WithInterval,
    /// p of the signed-rank test over people.
    pub p: f64,
    /// That p adjusted for all comparisons of the same first method (Holm).
    pub p_holm: f64,
}

/// Error of one forecaster at one horizon.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ForecastRow {
    /// The key of the forecaster.
    pub method: String,
    /// The horizon, min.
    pub minutes: u32,
    /// Root mean squared error, mg/dL, over people.
    pub rmse: Spread,
}

/// `twins.json`: the twin of every person.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TwinsTable {
    /// `twins/1`.
    pub schema: String,
    /// One entry a person, in the order of the cohort.
    pub people: Vec<TwinRow>,
}

/// One person's twin, or why there is none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TwinRow {
    /// The person's identifier.
    pub person_id: String,
    /// Complete training windows.
    pub windows_train: usize,
    /// Complete test windows.
    pub windows_test: usize,
    /// Why there is no twin; null where there is one.
    pub excluded: Option<String>,
    /// Training loss before the first epoch, which is the population model's.
    pub loss_first: Option<f64>,
    /// Training loss of the kept network.
    pub loss_last: Option<f64>,
    /// Epochs behind the kept network; 0 if training did not improve on the population model.
    pub epoch_kept: Option<usize>,
    /// Training steps without a heart rate, read as the training median.
    pub steps_without_heart_rate: Option<usize>,
    /// Training steps without a sleep efficiency, read as awake.
    pub steps_without_sleep: Option<usize>,
    /// Error of the population model on the test windows, mg/dL.
    pub rmse_population: Option<f64>,
    /// Error of the twin on the test windows, mg/dL.
    pub rmse_twin: Option<f64>,
}

impl OutcomesTable {
    /// The table of an evaluation.
    ///
    /// # Errors
    /// [`EvaluationError::TooFewPeople`] below two people, and [`EvaluationError::Stats`].
    pub fn new(
        cohort: &str,
        evaluation: &Evaluation,
        settings: &EvaluationSettings,
    ) -> Result<Self, EvaluationError> {
        let people = &evaluation.people;
        if people.len() < 2 {
            return Err(EvaluationError::TooFewPeople {
                found: people.len(),
                excluded: evaluation.exclusions.len(),
            });
        }
        let all: Vec<&PersonEvaluation> = people.iter().collect();
        let mut judged: Vec<Method> = people[0].methods.iter().map(|found| found.method).collect();
        judged.sort_by_key(|method| method.rank());
        let ablated = |method: &Method| matches!(method, Method::Ablated(_));
        let rows = |methods: Vec<Method>| -> Result<Vec<MethodRows>, EvaluationError> {
            let figures = |method| Figures::overall(&all, method);
            methods.into_iter().map(|method| figures(method).rows(method, settings)).collect()
        };
        let methods = rows(judged.iter().copied().filter(|method| !ablated(method)).collect())?;
        let ablation = rows(judged.iter().copied().filter(ablated).collect())?;
        let mut scenarios = Vec::new();
        for scenario in Scenario::ALL {
            scenarios.push(scenario_table(people, scenario, &judged, settings)?);
        }
        Ok(Self {
            schema: "outcomes/1".to_owned(),
            cohort: cohort.to_owned(),
            people: people.len(),
            windows: people.iter().map(|person| person.windows).sum(),
            window_minutes: evaluation.window_minutes,
            interval: IntervalMethod {
                method: "bootstrap over people, bias-corrected and accelerated (percentile where \
                         that is undefined)"
                    .to_owned(),
                level: settings.bootstrap.level,
                replicates: settings.bootstrap.replicates,
            },
            exclusions: evaluation.exclusions.clone(),
            comparisons: comparisons(&all, &judged, settings)?,
            training_days: outcome_rows(
                &people.iter().map(|person| person.actual).collect::<Vec<_>>(),
                &people.iter().map(|person| person.training).collect::<Vec<_>>(),
                settings,
            )?,
            methods,
            ablation,
            scenarios,
            forecast: forecast_rows(people)?,
        })
    }
}

impl TwinsTable {
    /// The table of built twins; errors on test windows from an evaluation of the same cohort.
    #[must_use]
    pub fn new(twins: &[PersonTwin], evaluation: &Evaluation) -> Self {
        let people = twins.iter().map(|person| {
            let judged = evaluation.people.iter().find(|e| e.person_id == person.person_id);
            let rmse = |method| Some(judged?.of(method)?.rmse);
            let built = person.result.as_ref().ok();
            TwinRow {
                person_id: person.person_id.clone(),
                windows_train: person.windows_train,
                windows_test: person.windows_test,
                excluded: person.result.as_ref().err().map(ToString::to_string),
                loss_first: built.map(|b| b.trained.loss_before),
                loss_last: built.map(|b| b.trained.loss_after),
                epoch_kept: built.map(|b| b.trained.kept),
                steps_without_heart_rate: built.map(|b| b.missing.heart_rate),
                steps_without_sleep: built.map(|b| b.missing.sleep_efficiency),
                rmse_population: rmse(Method::Population),
                rmse_twin: rmse(Method::Twin),
            }
        });
        Self { schema: "twins/1".to_owned(), people: people.collect() }
    }
}

/// One method's figures over people, and the measured outcomes beside them.
struct Figures {
    actual: Vec<Outcomes>,
    found: Vec<MethodResult>,
}

impl Figures {
    fn overall(people: &[&PersonEvaluation], method: Method) -> Self {
        let of = people.iter().filter_map(|person| Some((person.actual, *person.of(method)?)));
        let (actual, found) = of.unzip();
        Self { actual, found }
    }

    fn in_scenario(people: &[PersonEvaluation], scenario: Scenario, method: Method) -> Self {
        let of = people.iter().filter_map(|person| {
            let windows = person.in_scenario(scenario)?;
            let found = windows.methods.iter().find(|found| found.method == method)?;
            Some((windows.actual, *found))
        });
        let (actual, found) = of.unzip();
        Self { actual, found }
    }

    fn rmse(&self) -> Vec<f64> {
        self.found.iter().map(|found| found.rmse).collect()
    }

    fn rows(
        &self,
        method: Method,
        settings: &EvaluationSettings,
    ) -> Result<MethodRows, EvaluationError> {
        let simulated: Vec<Outcomes> = self.found.iter().map(|found| found.outcomes).collect();
        Ok(MethodRows {
            name: method.name().to_owned(),
            label: method.label().to_owned(),
            rows: outcome_rows(&self.actual, &simulated, settings)?,
            rmse_5h: spread(Summary::of(&self.rmse())?),
            starts_not_at_rest: self.found.iter().map(|found| found.not_at_rest).sum(),
        })
    }
}

/// Each outcome of some simulated days beside the measured ones, over people.
fn outcome_rows(
    actual: &[Outcomes],
    simulated: &[Outcomes],
    settings: &EvaluationSettings,
) -> Result<Vec<OutcomeRow>, EvaluationError> {
    let tests = compare_outcomes(actual, simulated, settings.alpha)?;
    let holm = multiplicity::holm(&tests.iter().map(|row| row.p).collect::<Vec<f64>>())?;
    tests
        .iter()
        .zip(holm)
        .map(|(test, p_holm)| {
            let difference = difference(actual, simulated, test.metric, &settings.bootstrap)?;
            Ok(OutcomeRow {
                metric: test.metric.key().to_owned(),
                unit: test.unit.to_owned(),
                margin: test.margin,
                actual: spread(test.actual),
                simulated: spread(test.simulated),
                difference,
                difference_t: WithInterval {
                    value: test.difference.value,
                    lower: test.difference.lower,
                    upper: test.difference.upper,
                },
                p: test.p,
                p_holm,
                equivalent: test.equivalent,
                p_unbiased: unbiased(actual, simulated, test.metric, settings.alpha)?,
            })
        })
        .collect()
}

/// The test's p after the mean difference was taken out.
fn unbiased(
    actual: &[Outcomes],
    simulated: &[Outcomes],
    metric: stats::Outcome,
    alpha: f64,
) -> Result<f64, EvaluationError> {
    let pairs = simulated.iter().zip(actual);
    let differences: Vec<f64> = pairs.map(|(s, a)| s.get(metric) - a.get(metric)).collect();
    let mean = differences.iter().sum::<f64>() / differences.len() as f64;
    let centred: Vec<f64> = differences.iter().map(|difference| difference - mean).collect();
    let none = vec![0.0; centred.len()];
    Ok(tost::paired(&none, &centred, metric.margin(), alpha)?.p)
}

/// Five-hour errors of twins against those of other methods.
fn comparisons(
    people: &[&PersonEvaluation],
    judged: &[Method],
    settings: &EvaluationSettings,
) -> Result<Vec<Comparison>, EvaluationError> {
    let mut rows = Vec::new();
    for first in [Method::Twin, Method::SpreadTwin, Method::ConstrainedTwin] {
        if !judged.contains(&first) {
            continue;
        }
        let twin = Figures::overall(people, first).rmse();
        for second in judged.iter().copied().filter(|second| is_compared(first, *second)) {
            let other = Figures::overall(people, second).rmse();
            let found = paired::compare(&twin, &other, &settings.bootstrap)?;
            rows.push(Comparison {
                first: first.name().to_owned(),
                second: second.name().to_owned(),
                quantity: "RMSE over 5 h".to_owned(),
                unit: "mg/dL".to_owned(),
                difference: with_bootstrap(&found.difference),
                p: found.signed_rank.p,
                p_holm: found.signed_rank.p,
            });
        }
    }
    // One family of tests for each first method, for each has a claim of its own.
    for family in rows.chunk_by_mut(|one, next| one.first == next.first) {
        let p: Vec<f64> = family.iter().map(|row| row.p).collect();
        for (row, p_holm) in family.iter_mut().zip(multiplicity::holm(&p)?) {
            row.p_holm = p_holm;
        }
    }
    Ok(rows)
}

/// The twin is compared with everything, other kinds of twins with what is not a twin.
fn is_compared(first: Method, second: Method) -> bool {
    match first {
        Method::Twin => second != Method::Twin,
        _ => !matches!(
            second,
            Method::Twin | Method::ConstrainedTwin | Method::SpreadTwin | Method::Ablated(_)
        ),
    }
}

/// Twins of every kind and the population model over the windows of a scenario.
fn scenario_table(
    people: &[PersonEvaluation],
    scenario: Scenario,
    judged: &[Method],
    settings: &EvaluationSettings,
) -> Result<ScenarioTable, EvaluationError> {
    let with: Vec<usize> =
        people.iter().filter_map(|p| Some(p.in_scenario(scenario)?.windows)).collect();
    let shown = |method: &&Method| {
        matches!(
            method,
            Method::Twin
                | Method::ConstrainedTwin
                | Method::SpreadTwin
                | Method::Ablated(_)
                | Method::Population
        )
    };
    let mut methods = Vec::new();
    if with.len() >= 2 {
        for method in judged.iter().filter(shown) {
            let figures = Figures::in_scenario(people, scenario, *method);
            methods.push(figures.rows(*method, settings)?);
        }
    }
    Ok(ScenarioTable {
        scenario: scenario.name().to_owned(),
        label: scenario.label().to_owned(),
        people: with.len(),
        windows: with.into_iter().sum(),
        methods,
    })
}

fn difference(
    actual: &[Outcomes],
    simulated: &[Outcomes],
    metric: stats::Outcome,
    bootstrap: &Bootstrap,
) -> Result<WithInterval, EvaluationError> {
    let pairs = simulated.iter().zip(actual);
    let differences: Vec<f64> = pairs.map(|(s, a)| s.get(metric) - a.get(metric)).collect();
    let estimate = bootstrap
        .people(&differences, |drawn| drawn.iter().copied().sum::<f64>() / drawn.len() as f64)?;
    Ok(with_bootstrap(&estimate))
}

fn with_bootstrap(estimate: &stats::Estimate) -> WithInterval {
    let interval = estimate.bca.unwrap_or(estimate.percentile);
    WithInterval { value: estimate.value, lower: interval.lower, upper: interval.upper }
}

/// Of at least two people, whose standard deviation exists.
fn spread(summary: Summary) -> Spread {
    Spread { mean: summary.mean, sd: summary.sd.unwrap_or(0.0) }
}

fn forecast_rows(people: &[PersonEvaluation]) -> Result<Vec<ForecastRow>, EvaluationError> {
    let mut rows = Vec::new();
    for forecaster in Forecaster::ALL {
        for minutes in FORECAST_MINUTES {
            let errors: Vec<f64> = people
                .iter()
                .flat_map(|person| &person.forecast)
                .filter(|e| e.forecaster == forecaster && e.minutes == minutes)
                .map(|e| e.rmse)
                .collect();
            if errors.len() >= 2 {
                rows.push(ForecastRow {
                    method: forecaster.name().to_owned(),
                    minutes,
                    rmse: spread(Summary::of(&errors)?),
                });
            }
        }
    }
    Ok(rows)
}
