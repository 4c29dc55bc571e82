//! `outcomes.json` and `twins.json`.

use serde::{Deserialize, Serialize};
use stats::{Bootstrap, Outcomes, Summary, compare_outcomes, multiplicity, paired};

use crate::cohort_training::PersonTwin;
use crate::error::TwinError;
use crate::evaluation::forecast::{FORECAST_MINUTES, Forecaster};
use crate::evaluation::person::PersonEvaluation;
use crate::evaluation::{Evaluation, EvaluationSettings, Method};

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
    /// One entry a method, the twin first.
    pub methods: Vec<MethodRows>,
    /// Five-hour error of the other methods against the twin's.
    pub comparisons: Vec<Comparison>,
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
    /// [`TwinError::TooFewPeople`] below two people, and [`TwinError::Stats`].
    pub fn new(
        cohort: &str,
        evaluation: &Evaluation,
        settings: &EvaluationSettings,
    ) -> Result<Self, TwinError> {
        let people = &evaluation.people;
        if people.len() < 2 {
            return Err(TwinError::TooFewPeople {
                found: people.len(),
                excluded: evaluation.exclusions.len(),
            });
        }
        let methods: Result<Vec<MethodRows>, TwinError> =
            Method::ALL.into_iter().map(|method| method_rows(people, method, settings)).collect();
        let twin = rmse_of(people, Method::Twin);
        let comparisons: Result<Vec<Comparison>, TwinError> = [Method::Population, Method::Ode]
            .into_iter()
            .map(|method| {
                let found = paired::compare(&twin, &rmse_of(people, method), &settings.bootstrap)?;
                Ok(Comparison {
                    first: Method::Twin.name().to_owned(),
                    second: method.name().to_owned(),
                    quantity: "RMSE over 5 h".to_owned(),
                    unit: "mg/dL".to_owned(),
                    difference: with_bootstrap(&found.difference),
                    p: found.signed_rank.p,
                })
            })
            .collect();
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
            methods: methods?,
            comparisons: comparisons?,
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
            let rmse = |method| judged.map(|judged| judged.of(method).rmse);
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

fn rmse_of(people: &[PersonEvaluation], method: Method) -> Vec<f64> {
    people.iter().map(|person| person.of(method).rmse).collect()
}

fn method_rows(
    people: &[PersonEvaluation],
    method: Method,
    settings: &EvaluationSettings,
) -> Result<MethodRows, TwinError> {
    let actual: Vec<Outcomes> = people.iter().map(|person| person.actual).collect();
    let simulated: Vec<Outcomes> = people.iter().map(|person| person.of(method).outcomes).collect();
    let tests = compare_outcomes(&actual, &simulated, settings.alpha)?;
    let holm = multiplicity::holm(&tests.iter().map(|row| row.p).collect::<Vec<f64>>())?;
    let rows: Result<Vec<OutcomeRow>, TwinError> = tests
        .iter()
        .zip(holm)
        .map(|(test, p_holm)| {
            let difference = difference(&actual, &simulated, test.metric, &settings.bootstrap)?;
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
            })
        })
        .collect();
    Ok(MethodRows {
        name: method.name().to_owned(),
        label: method.label().to_owned(),
        rows: rows?,
        rmse_5h: spread(Summary::of(&rmse_of(people, method))?),
        starts_not_at_rest: people.iter().map(|person| person.of(method).not_at_rest).sum(),
    })
}

fn difference(
    actual: &[Outcomes],
    simulated: &[Outcomes],
    metric: stats::Outcome,
    bootstrap: &Bootstrap,
) -> Result<WithInterval, TwinError> {
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

fn forecast_rows(people: &[PersonEvaluation]) -> Result<Vec<ForecastRow>, TwinError> {
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
