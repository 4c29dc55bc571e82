//! All people of a cohort under all methods.

use std::collections::BTreeMap;
use std::sync::Arc;

use cohort::{Cohort, Person};
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
    let judge = |index: usize, person: &Person| -> Result<Judged, EvaluationError> {
        let cut = PersonWindows::new(index, person, &settings.protocol)?;
        match (cut.excluded, models.get(&person.id)) {
            (Some(reason), _) => Ok(Err(reason.to_string())),
            (None, None) => Ok(Err("no twin was given".to_owned())),
            (None, Some(models)) => {
                evaluate_person(index, person, &cut, models, &steady, settings).map(Ok)
            }
        }
    };
    let judged: Vec<Result<Judged, EvaluationError>> = cohort
        .people
        .par_iter()
        .enumerate()
        .map(|(index, person)| judge(index, person).map_err(|error| error.of_person(&person.id)))
        .collect();
    let mut evaluation = Evaluation {
        people: Vec::new(),
        exclusions: Vec::new(),
        window_minutes: (settings.protocol.test.len as f64 * physiology::STEP.0) as u32,
    };
    for (person, judged) in cohort.people.iter().zip(judged) {
        match judged? {
            Ok(found) => evaluation.people.push(found),
            Err(reason) => {
                evaluation.exclusions.push(ExclusionRow { person_id: person.id.clone(), reason });
            }
        }
    }
    alike(&evaluation.people)?;
    Ok(evaluation)
}

/// A person's figures, or why they are left out.
type Judged = Result<PersonEvaluation, String>;

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
