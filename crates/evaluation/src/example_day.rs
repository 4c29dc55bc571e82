//! Up to three consecutive held-out days of one person, measured and simulated, for the report.

use std::collections::BTreeMap;
use std::ops::Range;

use chrono::Timelike as _;
use cohort::{Cohort, MissingDoses, Person};
use contract::example_day::{SeriesOutcomes, TimeInRanges};
use contract::{Document as _, ExampleDay};
use nn_statespace::PopulationModel;
use physiology::{MgPerDl, OpenLoop, Plant, STEPS_PER_DAY, StepInput, simulate};
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
    let Some(chosen) = choose(cohort, twins, evaluation, protocol) else { return Ok(None) };
    simulate_day(cohort, population, models, &chosen, protocol)
        .map(Some)
        .map_err(|error| error.of_person(&cohort.people[chosen.person].id))
}

/// Which days to show.
struct Chosen<'a> {
    person: usize,
    twin: &'a Twin,
    steps: Range<usize>,
}

/// The days to show: of the person with the median error of the twin, the first three consecutive
/// calendar days after the training days with readings enough, or the first two or one where there
/// are no three. Nothing about how the days themselves come out enters the choice.
fn choose<'a>(
    cohort: &Cohort,
    twins: &'a BTreeMap<String, Twin>,
    evaluation: &Evaluation,
    protocol: &Protocol,
) -> Option<Chosen<'a>> {
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
        let steps = days_with_readings(record.cgm(), midnight)?;
        Some(Chosen { person, twin, steps })
    })
}

/// The first three consecutive days from `midnight` on that have readings enough, or two, or one.
fn days_with_readings(cgm: &[Option<f64>], midnight: usize) -> Option<Range<usize>> {
    let read: Vec<bool> = cgm
        .get(midnight..)?
        .chunks_exact(STEPS_PER_DAY)
        .map(|day| {
            let readings = day.iter().flatten().count();
            readings as f64 >= LEAST_READ * STEPS_PER_DAY as f64
        })
        .collect();
    (1..=MOST_DAYS).rev().find_map(|days| {
        let first = read.windows(days).position(|run| run.iter().all(|day| *day))?;
        let start = midnight + first * STEPS_PER_DAY;
        Some(start..start + days * STEPS_PER_DAY)
    })
}

/// Runs the days.
fn simulate_day(
    cohort: &Cohort,
    population: &PopulationModel,
    models: &BTreeMap<String, PersonModels>,
    chosen: &Chosen<'_>,
    protocol: &Protocol,
) -> Result<ExampleDay, EvaluationError> {
    let person = &cohort.people[chosen.person];
    let record = &person.record;
    let closest = models.get(&person.id).and_then(|models| match models.of(Method::Closest) {
        Some(Model::Ode(plant)) => Some(plant),
        _ => None,
    });
    let range = chosen.steps.clone();
    let cgm = record.cgm()[range.clone()].to_vec();
    let before = cgm.iter().position(Option::is_some).expect("most steps have readings");
    let inputs = person.inputs(range.clone(), MissingDoses::Zero)?;
    let run = FreeRun {
        person,
        cut: &PersonWindows::new(chosen.person, person, protocol)?,
        protocol,
        first: range.start + before,
        inputs: &inputs[before..],
        before,
    };
    let ode = ode_baseline(person.weight);
    let network = run.start(population)?;
    let population = run.series(population, network)?;
    let twin = run.series(chosen.twin, network)?;
    let ode = run.series(&ode, run.start(&ode)?)?;
    let closest = closest.map(|plant| run.series(plant, run.start(plant)?)).transpose()?;
    let days = range.len() / STEPS_PER_DAY;
    Ok(ExampleDay {
        schema: ExampleDay::SCHEMA.to_owned(),
        person_id: person.id.clone(),
        date: dates(person, &range),
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
    let glucose = read.filter_map(|(glucose, _)| *glucose).map(|g| sensor_reading(MgPerDl(g)));
    let Outcomes { tbr, tir, tar, .. } = Outcomes::of(glucose)?;
    Ok(TimeInRanges { tbr, tir, tar })
}

/// One run over the days.
struct FreeRun<'a> {
    person: &'a Person,
    cut: &'a PersonWindows,
    protocol: &'a Protocol,
    /// Step of the record with the first reading.
    first: usize,
    /// Inputs from there on.
    inputs: &'a [StepInput],
    /// Steps of the days before it.
    before: usize,
}

impl FreeRun<'_> {
    fn start<P: Startable>(&self, plant: &P) -> Result<P::State, EvaluationError> {
        let found = starts(plant, self.person, self.cut, self.protocol, &[self.first])?;
        Ok(found.into_iter().next().expect("a start for each step"))
    }

    /// Glucose at every step of the days; nothing before the start.
    fn series<P: Plant>(
        &self,
        plant: &P,
        start: P::State,
    ) -> Result<Vec<Option<f64>>, EvaluationError> {
        let simulated = glucose(plant, start, self.inputs)?.into_iter().map(Some);
        Ok(std::iter::repeat_n(None, self.before).chain(simulated).collect())
    }
}

/// The states of a plant at the start of each of `steps`.
pub(crate) fn starts<P: Startable>(
    plant: &P,
    person: &Person,
    cut: &PersonWindows,
    protocol: &Protocol,
    steps: &[usize],
) -> Result<Vec<P::State>, EvaluationError> {
    let found = window_starts(plant, person, &cut.inputs, steps, protocol.start, cut.mean_basal)?;
    Ok(found.states)
}

/// Glucose at the start of each step, mg/dL.
pub(crate) fn glucose<P: Plant>(
    plant: &P,
    start: P::State,
    inputs: &[StepInput],
) -> Result<Vec<f64>, EvaluationError> {
    let run = simulate(plant, start, &mut OpenLoop::new(inputs), inputs.len())?;
    let mut glucose: Vec<f64> = run.glucose(plant).into_iter().map(MgPerDl::value).collect();
    glucose.truncate(inputs.len());
    Ok(glucose)
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
