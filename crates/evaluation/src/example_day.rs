//! Up to three consecutive held-out days of one person, measured and simulated, for the report.

use std::collections::BTreeMap;
use std::ops::Range;

use chrono::Timelike as _;
use cohort::{Cohort, Person};
use contract::example_day::{SeriesOutcomes, TimeInRanges};
use contract::{Document as _, ExampleDay};
use nn_statespace::PopulationModel;
use ode_sim::OdePlant;
use physiology::{MgPerDl, OpenLoop, Plant, STEPS_PER_DAY, simulate};
use stats::Outcomes;
use twins::{PersonWindows, Protocol, Startable, Twin, window_starts};

use crate::error::EvaluationError;
use crate::evaluate::Evaluation;
use crate::method::Method;
use crate::models::{Model, PersonModels};
use crate::readings::sensor_reading;
use crate::settings::ode_baseline;

/// Most days that are shown, as many as the paper's figure has.
const MOST_DAYS: usize = 3;
/// Length of a step of a record, s.
const STEP_SECONDS: usize = 24 * 3600 / STEPS_PER_DAY;
/// Fewest readings of a day that is shown, as a share of its steps.
const LEAST_READ: f64 = 0.9;

/// The example days of a cohort that was judged, in one run from the first reading on, under the twin, the population
/// model, the ODE and, where `models` has it, the closest virtual patient.
///
/// `None` if nobody with a twin has such a day.
///
/// # Errors
/// A start or a run that cannot be.
pub fn example_day(
    cohort: &Cohort,
    twins: &BTreeMap<String, Twin>,
    population: &PopulationModel,
    models: &BTreeMap<String, PersonModels>,
    evaluation: &Evaluation,
    protocol: &Protocol,
) -> Result<Option<ExampleDay>, EvaluationError> {
    let Some((index, twin, range)) = choose(cohort, twins, evaluation, protocol) else {
        return Ok(None);
    };
    let person = &cohort.people[index];
    let closest = match models.get(&person.id).and_then(|models| models.of(Method::Closest)) {
        Some(Model::Ode(plant)) => Some(plant),
        _ => None,
    };
    PersonWindows::new(index, person, protocol)
        .map_err(EvaluationError::from)
        .and_then(|cut| simulate_days((person, &cut), &range, population, twin, closest))
        .map(Some)
        .map_err(|error| error.of_person(&person.id))
}

/// Whose days to show (their place in the cohort, and their twin), and the steps: of the person
/// with the median error of the twin, the first three consecutive calendar days after the training
/// days with readings enough, or the first two or one where there are no three. Nothing about how
/// the days themselves come out enters the choice.
fn choose<'a>(
    cohort: &Cohort,
    twins: &'a BTreeMap<String, Twin>,
    evaluation: &Evaluation,
    protocol: &Protocol,
) -> Option<(usize, &'a Twin, Range<usize>)> {
    let mut judged: Vec<(f64, usize, &Twin)> = evaluation
        .people
        .iter()
        .filter_map(|found| {
            let (index, person) = cohort.find(&found.person_id)?;
            let rmse = found.of(Method::Twin)?.rmse;
            Some((rmse, index, twins.get(&person.id)?))
        })
        .collect();
    judged.sort_by(|a, b| a.0.total_cmp(&b.0));
    // From the median upwards, then downwards, should the first have no such day.
    let middle = judged.len() / 2;
    let order = (middle..judged.len()).chain((0..middle).rev());
    order.map(|index| judged[index]).find_map(|(_, person, twin)| {
        let record = &cohort.people[person].record;
        let first_test = protocol.training_days_of(record) * STEPS_PER_DAY;
        let midnight = (first_test..record.len())
            .find(|k| (record.time(*k).num_seconds_from_midnight() as usize) < STEP_SECONDS)?;
        Some((person, twin, days_with_readings(record.cgm(), midnight)?))
    })
}

/// The first three consecutive days from `midnight` on that have readings enough, or two, or one.
fn days_with_readings(cgm: &[Option<f64>], midnight: usize) -> Option<Range<usize>> {
    let read: Vec<bool> = cgm
        .get(midnight..)?
        .chunks_exact(STEPS_PER_DAY)
        .map(|day| day.iter().flatten().count() as f64 >= LEAST_READ * STEPS_PER_DAY as f64)
        .collect();
    (1..=MOST_DAYS).rev().find_map(|days| {
        let first = read.windows(days).position(|run| run.iter().all(|day| *day))?;
        let start = midnight + first * STEPS_PER_DAY;
        Some(start..start + days * STEPS_PER_DAY)
    })
}

/// Runs the days.
fn simulate_days(
    of: (&Person, &PersonWindows),
    range: &Range<usize>,
    population: &PopulationModel,
    twin: &Twin,
    closest: Option<&OdePlant>,
) -> Result<ExampleDay, EvaluationError> {
    let (person, cut) = of;
    let record = &person.record;
    let cgm = record.cgm()[range.clone()].to_vec();
    let inputs = &cut.inputs[range.clone()];
    let ode = ode_baseline(person.weight);
    let ode = series(&ode, &ode, of, range)?;
    let closest = closest.map(|plant| series(plant, plant, of, range)).transpose()?;
    let twin = series(twin, population, of, range)?;
    let population = series(population, population, of, range)?;
    let days = range.len() / STEPS_PER_DAY;
    Ok(ExampleDay {
        schema: ExampleDay::SCHEMA.to_owned(),
        person_id: person.id.clone(),
        date: dates(person, range),
        days,
        time: range.clone().map(|k| record.time(k).format("%H:%M").to_string()).collect(),
        outcomes: SeriesOutcomes {
            cgm: in_ranges(&cgm, &cgm)?,
            population: in_ranges(&population, &cgm)?,
            twin: in_ranges(&twin, &cgm)?,
            ode: in_ranges(&ode, &cgm)?,
            closest: closest.as_ref().map(|series| in_ranges(series, &cgm)).transpose()?,
        },
        cgm,
        population,
        twin,
        ode,
        closest,
        basal_u_h: inputs.iter().map(|input| input.basal.0).collect(),
        bolus_u: inputs.iter().map(|input| input.bolus.0).collect(),
        carbs_g: inputs.iter().map(|input| input.carbs.0).collect(),
        heart_rate_over_baseline: inputs
            .iter()
            .map(|input| input.context.heart_rate_over_baseline.map(|rate| rate.0))
            .collect(),
        sleep_efficiency: inputs.iter().map(|input| input.context.sleep_efficiency).collect(),
        chosen: format!(
            "person with the median twin error, first {} after training with at least {:.0} % of \
             readings",
            match days {
                1 => "day".to_owned(),
                days => format!("{days} consecutive days"),
            },
            100.0 * LEAST_READ
        ),
    })
}

/// The first and the last date.
fn dates(person: &Person, range: &Range<usize>) -> String {
    let date = |step| person.record.time(step).format("%Y-%m-%d").to_string();
    let (first, last) = (date(range.start), date(range.end - 1));
    if first == last { first } else { format!("{first} to {last}") }
}

/// Times in ranges of a series over the steps after the first reading at which the sensor reads: the
/// first reading is where every series starts.
fn in_ranges(series: &[Option<f64>], cgm: &[Option<f64>]) -> Result<TimeInRanges, EvaluationError> {
    let read = series.iter().zip(cgm).filter(|(_, reading)| reading.is_some()).skip(1);
    // The ranges of the outcomes lie within a sensor's.
    let glucose = read.filter_map(|(glucose, _)| *glucose).map(|g| MgPerDl(sensor_reading(g)));
    let Outcomes { tbr, tir, tar, .. } = Outcomes::of(glucose)?;
    Ok(TimeInRanges { tbr, tir, tar })
}

/// Glucose of a plant at every step of the days, mg/dL, from the first reading on; nothing before.
/// The run starts where `startable` does at that reading.
fn series<S: Startable>(
    plant: &impl Plant<State = S::State>,
    startable: &S,
    (person, cut): (&Person, &PersonWindows),
    range: &Range<usize>,
) -> Result<Vec<Option<f64>>, EvaluationError> {
    let before = person.record.cgm()[range.clone()].iter().position(Option::is_some);
    let before = before.expect("most steps have readings");
    let first = range.start + before;
    let starts =
        window_starts(startable, person, &cut.inputs, &[first], cut.start, cut.mean_basal)?;
    let start = starts.states.into_iter().next().expect("a start for each step");
    let inputs = &cut.inputs[first..range.end - 1];
    let run = simulate(plant, start, &mut OpenLoop::new(inputs), inputs.len())?;
    let glucose = run.glucose(plant).into_iter().map(|glucose| Some(glucose.0));
    Ok(std::iter::repeat_n(None, before).chain(glucose).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten steps of an unfinished day, then days with so many readings each.
    fn record(readings: &[usize]) -> Vec<Option<f64>> {
        let mut cgm = vec![Some(100.0); 10];
        for readings in readings {
            cgm.extend((0..STEPS_PER_DAY).map(|k| (k < *readings).then_some(100.0)));
        }
        cgm
    }

    #[test]
    fn three_days_are_shown_or_as_many_as_there_are() {
        let (full, enough, few) = (288, 260, 259);
        for (readings, expected) in [
            (&[full, full, full, full][..], Some((0, 3))),
            (&[few, full, enough, full], Some((1, 3))),
            (&[full, few, full, full, few], Some((2, 2))),
            (&[few, full, few], Some((1, 1))),
            (&[few, 0], None),
            (&[], None),
        ] {
            let found = days_with_readings(&record(readings), 10);
            let steps = expected.map(|(first, days)| {
                let start = 10 + first * STEPS_PER_DAY;
                start..start + days * STEPS_PER_DAY
            });
            assert_eq!(found, steps, "{readings:?}");
        }
        assert_eq!(days_with_readings(&record(&[]), 11), None);
    }

    #[test]
    fn series_are_judged_at_the_readings_after_their_start() {
        let cgm = [None, Some(100.0), None, Some(60.0), Some(200.0), Some(100.0), Some(100.0)];
        let run = [None, Some(100.0), Some(10.0), Some(-5.0), Some(65.0), Some(500.0), Some(90.0)];
        let shares = |series| in_ranges(series, &cgm).expect("five readings");
        assert_eq!(shares(&cgm), TimeInRanges { tbr: 25.0, tir: 50.0, tar: 25.0 });
        // Below a sensor's range is still below; what was simulated without a reading is not judged.
        assert_eq!(shares(&run), TimeInRanges { tbr: 50.0, tir: 25.0, tar: 25.0 });
    }
}
