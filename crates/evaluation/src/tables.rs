//! `outcomes.json` and `twins.json`.

use contract::outcomes::{
    Comparison, ForecastRow, IntervalMethod, MethodRows, OutcomeRow, OutcomesTable, ScenarioTable,
};
use contract::{Document as _, Spread, Summary, TwinRow, TwinsTable, WithInterval};
use stats::{Bootstrap, Outcomes, compare_outcomes, multiplicity, paired, summary, tost};
use twins::PersonTwin;

use crate::error::EvaluationError;
use crate::evaluate::Evaluation;
use crate::forecast::{FORECAST_MINUTES, Forecaster};
use crate::method::Method;
use crate::person::{MethodResult, PersonEvaluation};
use crate::scenario::Scenario;
use crate::settings::EvaluationSettings;

/// The table of an evaluation.
///
/// # Errors
/// [`EvaluationError::TooFewPeople`] below two people, and [`EvaluationError::Stats`].
pub fn outcomes_table(
    cohort: &str,
    evaluation: &Evaluation,
    settings: &EvaluationSettings,
) -> Result<OutcomesTable, EvaluationError> {
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
    Ok(OutcomesTable {
        schema: OutcomesTable::SCHEMA.to_owned(),
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

/// The table of built twins; errors on test windows from an evaluation of the same cohort.
#[must_use]
pub fn twins_table(twins: &[PersonTwin], evaluation: &Evaluation) -> TwinsTable {
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
    TwinsTable { schema: TwinsTable::SCHEMA.to_owned(), people: people.collect() }
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
            rmse_5h: spread(summary(&self.rmse())?),
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
                difference_t: test.difference,
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
                    people: errors.len(),
                    rmse: spread(summary(&errors)?),
                });
            }
        }
    }
    Ok(rows)
}
