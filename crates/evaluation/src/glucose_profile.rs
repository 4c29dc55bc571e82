//! The ambulatory glucose profile of the held-out windows, measured and simulated by the twins.

use std::collections::BTreeMap;

use chrono::Timelike as _;
use cohort::{Cohort, Person};
use contract::{Document as _, GlucoseProfile};
use nn_statespace::PopulationModel;
use physiology::{MgPerDl, STEPS_PER_DAY};
use stats::profile::percentiles;
use twins::{PersonWindows, Protocol, Twin};

use crate::error::EvaluationError;
use crate::evaluate::Evaluation;
use crate::example_day::{glucose, starts};
use crate::method::Method;
use crate::readings::sensor_reading;

/// Slots of the day: half hours.
const SLOTS: usize = 48;

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
    let mut samples = Samples::default();
    for judged in &evaluation.people {
        let id = || judged.person_id.clone();
        let found = cohort.find(&judged.person_id);
        let (index, person) = found.ok_or_else(|| EvaluationError::NotInCohort { person: id() })?;
        let method = Method::Twin.name();
        let twin = twins.get(&judged.person_id);
        let twin = twin.ok_or_else(|| EvaluationError::MissingModel { person: id(), method })?;
        samples
            .add((index, person), twin, population, protocol)
            .map_err(|error| error.of_person(&person.id))?;
    }
    Ok(GlucoseProfile {
        schema: GlucoseProfile::SCHEMA.to_owned(),
        person_id: "cohort".to_owned(),
        hour: (0..SLOTS).map(|slot| (slot as f64 + 0.5) * 24.0 / SLOTS as f64).collect(),
        observed: percentiles(samples.observed, SLOTS)?,
        twin: percentiles(samples.simulated, SLOTS)?,
        windows: samples.windows,
    })
}

/// Glucose by slot of the day, mg/dL.
#[derive(Default)]
struct Samples {
    observed: Vec<(usize, f64)>,
    simulated: Vec<(usize, f64)>,
    windows: usize,
}

impl Samples {
    /// Adds the held-out windows of a person.
    fn add(
        &mut self,
        (index, person): (usize, &Person),
        twin: &Twin,
        population: &PopulationModel,
        protocol: &Protocol,
    ) -> Result<(), EvaluationError> {
        let cut = PersonWindows::new(index, person, protocol)?;
        let steps: Vec<usize> = cut.test.iter().map(|window| window.start).collect();
        let starts = starts(population, person, &cut, protocol, &steps)?;
        for (window, start) in cut.test.iter().zip(starts) {
            let range = window.range();
            let course = glucose(twin, start, &cut.inputs[range.clone()])?;
            self.windows += 1;
            // The start is the reading itself and shows nothing about the twin.
            for (step, simulated) in range.zip(course).skip(1) {
                let Some(reading) = person.record.cgm()[step] else { continue };
                let time = person.record.time(step);
                let step_of_day = time.num_seconds_from_midnight() as usize / 300;
                let slot = step_of_day * SLOTS / STEPS_PER_DAY;
                self.observed.push((slot, reading));
                self.simulated.push((slot, sensor_reading(MgPerDl(simulated)).0));
            }
        }
        Ok(())
    }
}
