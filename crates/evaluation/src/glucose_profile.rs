//! Percentiles of glucose by time of day: of each person's readings, and of the held-out windows,
//! measured and simulated by the twins (the ambulatory glucose profile).

use std::collections::BTreeMap;

use chrono::Timelike as _;
use cohort::{Cohort, Person, insulin_u_day, mass_balance};
use contract::agp::Percentiles;
use contract::glucose_by_person::{GlucoseRanges, PersonGlucose};
use contract::{Document as _, GlucoseByPerson, GlucoseProfile};
use nn_statespace::PopulationModel;
use physiology::{MgPerDl, STEPS_PER_DAY};
use stats::Outcomes;
use stats::profile::percentiles;
use twins::{PersonWindows, Protocol, SteadyStates, Twin};

use crate::error::EvaluationError;
use crate::evaluate::Evaluation;
use crate::method::Method;
use crate::readings::{runs, within};

/// Slots of the day: half hours.
const SLOTS: usize = 48;
/// Least readings of a person: a spread needs two.
const LEAST: usize = 2;
/// Decimals of a percentile: a sensor has none.
const DECIMALS: f64 = 10.0;

/// The slot of a step of a person's record.
fn slot(person: &Person, step: usize) -> usize {
    let step_of_day = person.record.time(step).num_seconds_from_midnight() as usize / 300;
    step_of_day * SLOTS / STEPS_PER_DAY
}

/// The middle of each slot, h.
fn hours() -> Vec<f64> {
    (0..SLOTS).map(|slot| (slot as f64 + 0.5) * 24.0 / SLOTS as f64).collect()
}

/// The profile over everybody who was judged: the same windows and steps for both curves.
///
/// # Errors
/// Somebody who is not in the cohort or has no twin, and a run that cannot be.
pub fn glucose_profile(
    cohort: &Cohort,
    twins: &BTreeMap<String, Twin>,
    population: &PopulationModel,
    evaluation: &Evaluation,
    protocol: &Protocol,
) -> Result<GlucoseProfile, EvaluationError> {
    let steady = SteadyStates::new(population);
    let (mut samples, mut windows) = (Vec::new(), 0);
    for judged in &evaluation.people {
        let id = || judged.person_id.clone();
        let found = cohort.find(&judged.person_id);
        let (index, person) = found.ok_or_else(|| EvaluationError::NotInCohort(id()))?;
        let method = Method::Twin.name();
        let twin = twins.get(&judged.person_id);
        let twin = twin.ok_or_else(|| EvaluationError::MissingModel { person: id(), method })?;
        let of_person = |error: EvaluationError| error.of_person(&person.id);
        let cut = PersonWindows::new(index, person, protocol);
        let cut = cut.map_err(|error| of_person(error.into()))?;
        let found = runs(twin, &steady, (person, &cut), &within(&cut.test));
        let (runs, _) = found.map_err(of_person)?;
        windows += cut.test.len();
        for (window, run) in cut.test.iter().zip(runs) {
            // The start is the reading itself and shows nothing about the twin.
            for (step, simulated) in window.range().zip(run).skip(1) {
                if let Some(reading) = person.record.cgm()[step] {
                    samples.push((slot(person, step), reading, simulated.0));
                }
            }
        }
    }
    let observed = samples.iter().map(|(slot, reading, _)| (*slot, *reading));
    let simulated = samples.iter().map(|(slot, _, simulated)| (*slot, *simulated));
    Ok(GlucoseProfile {
        schema: GlucoseProfile::SCHEMA.to_owned(),
        person_id: "cohort".to_owned(),
        hour: hours(),
        observed: percentiles(observed, SLOTS)?,
        twin: percentiles(simulated, SLOTS)?,
        windows,
    })
}

/// Everybody's glucose; people with fewer than two readings are not in the list.
///
/// # Errors
/// A reading that is no glucose.
pub fn glucose_by_person(cohort: &Cohort) -> Result<GlucoseByPerson, EvaluationError> {
    let read = |person: &&Person| person.record.cgm().iter().flatten().count() >= LEAST;
    let of = |person: &Person| of_person(person).map_err(|error| error.of_person(&person.id));
    let people = cohort.people.iter().filter(read).map(of).collect::<Result<_, _>>()?;
    Ok(GlucoseByPerson { schema: GlucoseByPerson::SCHEMA.to_owned(), hour: hours(), people })
}

/// A person's measured glucose: ranges, mean, variation, and percentiles by time of day.
fn of_person(person: &Person) -> Result<PersonGlucose, EvaluationError> {
    let cgm = person.record.cgm().iter().enumerate();
    let readings: Vec<(usize, f64)> =
        cgm.filter_map(|(step, reading)| Some((slot(person, step), (*reading)?))).collect();
    let outcomes = Outcomes::of(readings.iter().map(|(_, glucose)| MgPerDl(*glucose)))?;
    let Percentiles { p05, p25, p50, p75, p95 } = percentiles(readings.iter().copied(), SLOTS)?;
    let [p05, p25, p50, p75, p95] = [p05, p25, p50, p75, p95].map(|series| {
        let rounded = |value: f64| (DECIMALS * value).round() / DECIMALS;
        series.into_iter().map(|value| value.map(rounded)).collect()
    });
    let balance = mass_balance(person);
    Ok(PersonGlucose {
        person_id: person.id.clone(),
        readings: readings.len(),
        mean_mg_dl: outcomes.mg,
        cv: outcomes.cv,
        gmi: outcomes.gmi,
        ranges: GlucoseRanges {
            below_54: outcomes.tbr54,
            from_54_to_70: outcomes.tbr - outcomes.tbr54,
            from_70_to_180: outcomes.tir,
            from_180_to_250: outcomes.tar - outcomes.tar250,
            above_250: outcomes.tar250,
        },
        insulin_u_day: insulin_u_day(&balance),
        carbs_g_day: balance.carbs_g_day,
        percentiles: Percentiles { p05, p25, p50, p75, p95 },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use cohort::{Channel, Record, Therapy};

    #[test]
    fn a_day_of_known_glucose_has_known_figures() {
        let start = "2024-03-08T00:00:00".parse().expect("a literal time");
        let person = |id: &str, readings: usize| {
            let mut record = Record::new(start, STEPS_PER_DAY).expect("on the grid");
            // A quarter of the day each at 50, 100, 200 and 300 mg/dL.
            for (step, cgm) in
                record.channel_mut(Channel::Cgm).iter_mut().enumerate().take(readings)
            {
                *cgm = Some([50.0, 100.0, 200.0, 300.0][step * 4 / STEPS_PER_DAY]);
            }
            let (weight, heart_rate_baseline) = (None, None);
            Person { id: id.into(), weight, therapy: Therapy::Unknown, heart_rate_baseline, record }
        };
        let cohort = Cohort { people: vec![person("a", STEPS_PER_DAY), person("b", 1)] };
        let found = glucose_by_person(&cohort).expect("glucose");
        let [one] = &found.people[..] else { panic!("one reading has no spread: {found:?}") };
        assert_eq!((one.person_id.as_str(), one.readings, one.mean_mg_dl), ("a", 288, 162.5));
        let GlucoseRanges { below_54, from_54_to_70, from_70_to_180, from_180_to_250, above_250 } =
            one.ranges;
        assert_eq!(
            [below_54, from_54_to_70, from_70_to_180, from_180_to_250, above_250],
            [25.0, 0.0, 25.0, 25.0, 25.0]
        );
        assert_eq!(one.percentiles.p50[0], Some(50.0));
        assert_eq!(one.percentiles.p95[47], Some(300.0));
        assert_eq!(one.insulin_u_day, None);

        let mut broken = person("c", STEPS_PER_DAY);
        broken.record.channel_mut(Channel::Cgm)[7] = Some(0.5);
        let error = glucose_by_person(&Cohort { people: vec![broken] }).expect_err("no glucose");
        assert!(error.to_string().starts_with("person 'c'"), "{error}");
    }
}
