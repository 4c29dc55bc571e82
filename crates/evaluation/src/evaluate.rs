//! All people of a cohort under all methods.

use std::collections::BTreeMap;
use std::sync::Arc;

use cohort::Cohort;
use nn_statespace::PopulationModel;
use ode_sim::{OdeParameters, OdePlant};
use physiology::Kilograms;
use rayon::prelude::*;
use stats::Bootstrap;
use twins::{PersonWindows, Protocol, SteadyStates};

use crate::error::EvaluationError;
use crate::models::PersonModels;
use crate::person::{PersonEvaluation, evaluate_person};
use contract::outcomes::ExclusionRow;

/// Weight of the simulator's average person, kg, for people whose weight is unknown (Resalat et al.
/// 2019).
pub const AVERAGE_WEIGHT: Kilograms = Kilograms(ode_sim::population::MEAN_WEIGHT);

/// How methods are judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EvaluationSettings {
    /// How records are cut; the same as in training.
    pub protocol: Protocol,
    /// Level of each one-sided test.
    pub alpha: f64,
    /// Resampling of people for intervals.
    pub bootstrap: Bootstrap,
}

impl EvaluationSettings {
    /// Level 0.05 as in the paper; intervals of level 0.90, which belong to such tests, from 2,000
    /// bootstrap samples of people.
    #[must_use]
    pub const fn paper(protocol: Protocol, seed: u64) -> Self {
        Self { protocol, alpha: 0.05, bootstrap: Bootstrap { replicates: 2000, level: 0.9, seed } }
    }
}

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

/// The ODE baseline for a person: population parameters, the person's weight or
/// [`AVERAGE_WEIGHT`], integrated as the authors do.
#[must_use]
pub fn ode_baseline(weight: Option<Kilograms>) -> OdePlant {
    OdePlant::reproduction(OdeParameters::nominal(), weight.unwrap_or(AVERAGE_WEIGHT))
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
