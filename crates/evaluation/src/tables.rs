//! `outcomes.json` and `twins.json`.

use contract::outcomes::{
    Comparison, ForecastRow, IntervalMethod, MethodRows, OutcomeRow, OutcomesTable, ScenarioTable,
};
use contract::{Document as _, Spread, Summary, TwinRow, TwinsTable, WithInterval};
use stats::{Outcome, Outcomes, compare_outcomes, multiplicity, paired, summary, tost};
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
    let mut judged: Vec<Method> = people[0].methods.iter().map(|found| found.method).collect();
    judged.sort_by_key(|method| method.rank());
    let all: Vec<Figures<'_>> = people.iter().map(|p| (p.actual, &p.methods[..])).collect();
    let (mut methods, mut ablation) = (Vec::new(), Vec::new());
    for method in &judged {
        let part = if matches!(method, Method::Ablated(_)) { &mut ablation } else { &mut methods };
        part.push(method_rows(&all, *method, settings)?);
    }
    let scenarios =
        Scenario::ALL.map(|scenario| scenario_table(people, scenario, &judged, settings));
    let scenarios = scenarios.into_iter().collect::<Result<Vec<_>, _>>()?;
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
        comparisons: comparisons(people, &judged, settings)?,
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

/// Measured outcomes of a person, and what each method made of the same windows.
type Figures<'a> = (Outcomes, &'a [MethodResult]);

/// One method's figures over people.
fn method_rows(
    people: &[Figures<'_>],
    method: Method,
    settings: &EvaluationSettings,
) -> Result<MethodRows, EvaluationError> {
    let of = people.iter().filter_map(|(actual, methods)| {
        Some((*actual, methods.iter().find(|found| found.method == method)?))
    });
    let (actual, found): (Vec<Outcomes>, Vec<&MethodResult>) = of.unzip();
    let simulated: Vec<Outcomes> = found.iter().map(|found| found.outcomes).collect();
    let rmse: Vec<f64> = found.iter().map(|found| found.rmse).collect();
    Ok(MethodRows {
        name: method.name().to_owned(),
        label: method.label().to_owned(),
        rows: outcome_rows(&actual, &simulated, settings)?,
        rmse_5h: spread(summary(&rmse)?),
        starts_not_at_rest: found.iter().map(|found| found.not_at_rest).sum(),
    })
}

/// Each outcome of some simulated days beside the measured ones, over people.
fn outcome_rows(
    actual: &[Outcomes],
    simulated: &[Outcomes],
    settings: &EvaluationSettings,
) -> Result<Vec<OutcomeRow>, EvaluationError> {
    let tests = compare_outcomes(actual, simulated, settings.alpha)?;
    let holm = multiplicity::holm(&tests.iter().map(|row| row.p).collect::<Vec<f64>>())?;
    let outcomes = Outcome::ALL.into_iter().zip(tests).zip(holm);
    outcomes
        .map(|((outcome, test), p_holm)| {
            let pairs = simulated.iter().zip(actual);
            let differences: Vec<f64> =
                pairs.map(|(s, a)| s.get(outcome) - a.get(outcome)).collect();
            let estimate = settings.bootstrap.people(&differences, |drawn| {
                drawn.iter().copied().sum::<f64>() / drawn.len() as f64
            })?;
            // The test after the mean difference was taken out.
            let mean = differences.iter().sum::<f64>() / differences.len() as f64;
            let centred: Vec<f64> = differences.iter().map(|one| one - mean).collect();
            let none = vec![0.0; centred.len()];
            let unbiased = tost::paired(&none, &centred, test.margin, settings.alpha)?;
            Ok(OutcomeRow {
                metric: test.metric,
                unit: test.unit,
                margin: test.margin,
                actual: spread(test.actual),
                simulated: spread(test.simulated),
                difference: with_bootstrap(&estimate),
                difference_t: test.difference,
                p: test.p,
                p_holm,
                equivalent: test.equivalent,
                p_unbiased: unbiased.p,
            })
        })
        .collect()
}

/// Five-hour errors of twins against those of other methods.
fn comparisons(
    people: &[PersonEvaluation],
    judged: &[Method],
    settings: &EvaluationSettings,
) -> Result<Vec<Comparison>, EvaluationError> {
    let rmse = |method| -> Vec<f64> {
        people.iter().filter_map(|person| Some(person.of(method)?.rmse)).collect()
    };
    let mut rows = Vec::new();
    for first in [Method::Twin, Method::SpreadTwin, Method::ConstrainedTwin] {
        if !judged.contains(&first) {
            continue;
        }
        // The twin is compared with everything, other kinds of twins with what is not a twin.
        let compared = |second: &Method| match first {
            Method::Twin => *second != first,
            _ => !second.is_twin(),
        };
        let seconds: Vec<Method> = judged.iter().copied().filter(compared).collect();
        let found = seconds
            .iter()
            .map(|second| paired::compare(&rmse(first), &rmse(*second), &settings.bootstrap))
            .collect::<Result<Vec<_>, _>>()?;
        // One family of tests for each first method, for each has a claim of its own.
        let p: Vec<f64> = found.iter().map(|found| found.signed_rank.p).collect();
        for ((second, found), p_holm) in seconds.iter().zip(found).zip(multiplicity::holm(&p)?) {
            rows.push(Comparison {
                first: first.name().to_owned(),
                second: second.name().to_owned(),
                quantity: "RMSE over 5 h".to_owned(),
                unit: "mg/dL".to_owned(),
                difference: with_bootstrap(&found.difference),
                p: found.signed_rank.p,
                p_holm,
            });
        }
    }
    Ok(rows)
}

/// Twins of every kind and the population model over the windows of a scenario.
fn scenario_table(
    people: &[PersonEvaluation],
    scenario: Scenario,
    judged: &[Method],
    settings: &EvaluationSettings,
) -> Result<ScenarioTable, EvaluationError> {
    let with = || people.iter().filter_map(|person| person.in_scenario(scenario));
    let figures: Vec<Figures<'_>> =
        with().map(|found| (found.actual, &found.methods[..])).collect();
    let mut methods = Vec::new();
    if figures.len() >= 2 {
        let shown = |method: &&Method| method.is_twin() || **method == Method::Population;
        for method in judged.iter().filter(shown) {
            methods.push(method_rows(&figures, *method, settings)?);
        }
    }
    Ok(ScenarioTable {
        scenario: scenario.name().to_owned(),
        label: scenario.label().to_owned(),
        people: figures.len(),
        windows: with().map(|found| found.windows).sum(),
        methods,
    })
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
