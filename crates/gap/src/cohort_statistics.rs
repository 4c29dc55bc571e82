//! Everything that a posterior reads of a cohort, as numbers by name.

use std::collections::BTreeMap;

use cohort::{Channel, Cohort};
use effects::Effect;
use rayon::prelude::*;

use crate::calibrated_person::CalibratedPerson;
use crate::config::DiagnosisConfig;
use crate::error::GapError;
use crate::filter::plants::Ode;
use crate::person::{PersonOutcome, analyse};
use crate::person_statistics::of_person;
use crate::which::{Evidence, Thresholds, which};

/// Channels whose presence decides what a record can show.
const CHANNELS: [Channel; 4] =
    [Channel::HeartRate, Channel::Steps, Channel::SleepEfficiency, Channel::SetChange];

/// Reads the statistics of a cohort on the ODE plant: natural units, evidence by name, spreads, and what its people are
/// like. `None` where everybody has to be excluded.
///
/// # Errors
/// As [`Diagnoser::run`](crate::Diagnoser::run), exclusion aside.
pub fn cohort_statistics(
    cohort: &Cohort,
    library: &[Box<dyn Effect>],
    config: &DiagnosisConfig,
) -> Result<Option<BTreeMap<String, f64>>, GapError> {
    let outcomes: Vec<PersonOutcome> = cohort
        .people
        .par_iter()
        .map(|person| analyse(person, &Ode, config))
        .collect::<Result<_, _>>()?;
    let included: Vec<CalibratedPerson<'_>> = cohort
        .people
        .iter()
        .zip(&outcomes)
        .filter_map(|(person, outcome)| outcome.calibrated(person))
        .collect();
    if included.is_empty() {
        return Ok(None);
    }
    // One round, in which nothing is named.
    let found = which(&included, library, &Thresholds::never(), None, &config.calibration)?;
    Ok(Some(found.statistics))
}

/// The statistics of people whose first round is known: its evidence, its spreads and what natural units show.
pub(crate) fn statistics(
    people: &[CalibratedPerson<'_>],
    evidence: &Evidence,
    spreads: &BTreeMap<String, f64>,
    units: &BTreeMap<String, f64>,
) -> BTreeMap<String, f64> {
    let count = people.len() as f64;
    let mut found = BTreeMap::new();
    found.insert("cohort/people".to_owned(), count.ln());
    found.insert("cohort/person-days".to_owned(), evidence.person_days.ln());
    for channel in CHANNELS {
        let has = |p: &&CalibratedPerson<'_>| {
            p.person.record.channel(channel).iter().any(Option::is_some)
        };
        let share = people.iter().filter(has).count() as f64 / count;
        found.insert(format!("cohort/{channel:?}"), share);
    }
    let mut of_people: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for person in people {
        for (name, value) in of_person(person) {
            of_people.entry(name).or_default().push(value);
        }
    }
    for (name, values) in of_people {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n;
        found.insert(format!("{name}/mean"), mean);
        found.insert(format!("{name}/SD"), variance.sqrt());
    }
    for (name, spread) in spreads {
        found.insert(format!("spread/{name}"), *spread);
    }
    for (name, gain) in &evidence.gains {
        found.insert(format!("evidence/{name}"), *gain);
    }
    let units = units.iter().map(|(name, value)| (format!("units/{name}"), *value));
    found.extend(units);
    found
}
