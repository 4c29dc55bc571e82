//! All people of a cohort under all methods.

use std::collections::BTreeMap;
use std::sync::Arc;

use cohort::Cohort;
use nn_statespace::PopulationModel;
use rayon::prelude::*;
use twins::{PersonWindows, SteadyStates};

use crate::error::EvaluationError;
use crate::models::PersonModels;
use crate::person::{PersonEvaluation, evaluate_person};
use crate::settings::EvaluationSettings;
use contract::outcomes::ExclusionRow;

/// Everything found about a cohort: people with their figures, and who was left out.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// One entry a person judged, in the order of the cohort.
    pub people: Vec<PersonEvaluation>,
    /// People left out, with the reason.
    pub exclusions: Vec<ExclusionRow>,
    /// Length of a test window, min.
    pub window_minutes: u32,
}

/// Judges the models of a cohort's people, found by person.
///
/// People are left out for the reasons of [`Exclusion`](twins::Exclusion), or because there is no
/// model of theirs. The result does not depend on the number of threads.
///
/// # Errors
/// The first error by order of people; [`EvaluationError::MissingModel`] unless everybody has models
/// of the same methods.
pub fn evaluate(
    cohort: &Cohort,
    models: &BTreeMap<String, PersonModels>,
    population: &Arc<PopulationModel>,
    settings: &EvaluationSettings,
) -> Result<Evaluation, EvaluationError> {
    let steady = SteadyStates::new(&**population);
    let judged: Vec<Result<Judged, EvaluationError>> = cohort
        .people
        .par_iter()
        .enumerate()
        .map(|(index, person)| {
            let of_person = |error: EvaluationError| error.of_person(&person.id);
            let cut = PersonWindows::new(index, person, &settings.protocol)
                .map_err(|error| of_person(error.into()))?;
            if let Some(reason) = cut.excluded {
                return Ok(Judged::Out(reason.to_string()));
            }
            match models.get(&person.id) {
                None => Ok(Judged::Out("no twin was given".to_owned())),
                Some(models) => {
                    let found = evaluate_person(index, person, &cut, models, &steady, settings)
                        .map_err(of_person)?;
                    Ok(Judged::In(Box::new(found)))
                }
            }
        })
        .collect();
    let mut evaluation = Evaluation {
        people: Vec::new(),
        exclusions: Vec::new(),
        window_minutes: (settings.protocol.test.len as f64 * physiology::STEP.0) as u32,
    };
    for (person, judged) in cohort.people.iter().zip(judged) {
        match judged? {
            Judged::In(found) => evaluation.people.push(*found),
            Judged::Out(reason) => {
                evaluation.exclusions.push(ExclusionRow { person_id: person.id.clone(), reason });
            }
        }
    }
    alike(&evaluation.people)?;
    Ok(evaluation)
}

/// Whether everybody was judged by the same methods in the same order.
fn alike(people: &[PersonEvaluation]) -> Result<(), EvaluationError> {
    let Some(first) = people.first() else { return Ok(()) };
    for person in people {
        for (ours, theirs) in [(first, person), (person, first)] {
            if let Some(missing) = ours.methods.iter().find(|m| theirs.of(m.method).is_none()) {
                return Err(EvaluationError::MissingModel {
                    person: theirs.person_id.clone(),
                    method: missing.method.name(),
                });
            }
        }
    }
    Ok(())
}

enum Judged {
    In(Box<PersonEvaluation>),
    Out(String),
}
