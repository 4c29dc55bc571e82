//! What the exact course of an effect would show: the ceiling of any template.
//!
//! The difference that an effect makes to a person's readings, under the insulin delivered and the carbohydrate
//! logged, is an offset of the sensor as far as the filter is concerned: with gains held, what the filter's
//! innovations answer to it is the signature of the effect itself. It becomes one more column of the linear model of a
//! person. Its held-out evidence passes the same background, the same random differences between days, the same folds
//! and hierarchy as a driven effect of the library, and directions that rival the effect are left out as they are
//! for it. What the library loses by its form is then the distance between an effect's power and the share
//! of worlds in which its exact course shows more than courses of effects that do not act.

use std::iter;

use cohort::Cohort;
use effects::{Card, Course, Effect, EffectId, Field, Form, Modulation, Structure};
use rayon::prelude::*;

use super::backgrounds::Guard;
use super::held_out::held_out;
use super::round::{Round, RoundPerson};
use crate::calibrated_person::CalibratedPerson;
use crate::config::DiagnosisConfig;
use crate::design::design;
use crate::error::GapError;
use crate::filter::plants::Plants;
use crate::person::{all_calibrated, analyse_all, nobody_left};

/// The exact course of an effect in a cohort.
#[derive(Debug, Clone, PartialEq)]
pub struct ExactCourse {
    /// The card of the effect: its identity, and what rivals it.
    pub card: Card,
    /// What readings show more with the effect than without it: a list a person of the cohort, an entry a step of
    /// the record, mg/dL; `None` where it is not known.
    pub people: Vec<Vec<Option<f64>>>,
}

impl ExactCourse {
    fn lies_along(&self, cohort: &Cohort) -> Result<(), GapError> {
        let entries = self.people.iter().zip(&cohort.people);
        let lengths = entries.map(|(own, person)| (own.len(), person.record.len()));
        let lists = iter::once((self.people.len(), cohort.people.len()));
        match lists.chain(lengths).find(|(found, needed)| found != needed) {
            None => Ok(()),
            Some((found, needed)) => Err(GapError::Course { effect: self.card.id, found, needed }),
        }
    }
}

/// Evidence of one exact course.
#[derive(Debug, Clone, PartialEq)]
pub struct ExactEvidence {
    /// The effect.
    pub effect: EffectId,
    /// Held-out evidence, nats.
    pub gain: f64,
    /// Estimated share of the course that is there: mean over people; 1 is all of it.
    pub amplitude: f64,
}

/// The evidence of exact courses in a cohort, one entry a course. `library` tells what is allowed for beside them.
///
/// People whom a diagnosis excludes take no part. The calibration is that of a diagnosis: what it took of an effect
/// into a person's factors stays there.
///
/// # Errors
/// [`GapError::Course`] for a course that does not lie along the records; otherwise as
/// [`Diagnoser::run`](crate::Diagnoser::run).
pub fn exact_course_evidence(
    cohort: &Cohort,
    courses: &[ExactCourse],
    library: &[Box<dyn Effect>],
    plants: &dyn Plants,
    config: &DiagnosisConfig,
) -> Result<Vec<ExactEvidence>, GapError> {
    let config = config.clone().validated()?;
    for course in courses {
        course.lies_along(cohort)?;
    }
    let outcomes = analyse_all(cohort, plants, &config)?;
    let people: Vec<(usize, CalibratedPerson<'_>)> = all_calibrated(cohort, &outcomes).collect();
    if people.is_empty() {
        return Err(nobody_left(&outcomes));
    }
    courses
        .par_iter()
        .map(|course| {
            let is_guard = |card: &Card| card.relations.structure == Structure::Guard;
            let guards: Vec<&dyn Effect> = library
                .iter()
                .map(AsRef::as_ref)
                .filter(|effect| is_guard(&effect.card()) && effect.card().id != course.card.id)
                .collect();
            // The linear model of each person: the background, the course, and the guards.
            let subjects = people
                .par_iter()
                .map(|(index, person)| {
                    let template = Template { card: &course.card, course: &course.people[*index] };
                    let exact: &dyn Effect = &template;
                    let tried: Vec<_> = iter::once(exact).chain(guards.iter().copied()).collect();
                    Ok(RoundPerson::of(&design(person, &tried)?))
                })
                .collect::<Result<Vec<_>, GapError>>()?;
            let spreads = guards.iter().map(|guard| Guard::usual(guard.card().id)).collect();
            let round = Round::estimated(subjects, spreads);
            let found = held_out(course.card.id, &round.trials(&course.card));
            Ok(ExactEvidence {
                effect: found.effect,
                gain: found.gain(),
                amplitude: found.amplitude.0,
            })
        })
        .collect()
}

/// An offset of the sensor that follows a course.
#[derive(Debug)]
struct Template<'a> {
    /// That of the effect whose course it is: what rivals the effect rivals its course.
    card: &'a Card,
    course: &'a [Option<f64>],
}

impl Effect for Template<'_> {
    fn card(&self) -> Card {
        self.card.clone()
    }

    fn form(&self, _: &Course) -> Option<Form> {
        Some(Form::Driven)
    }

    fn modulate(&self, _: usize, amplitude: f64, _: &Course, into: &mut [Modulation]) {
        for (change, modulation) in self.course.iter().zip(into) {
            modulation[Field::SensorOffset] += amplitude * change.unwrap_or(0.0);
        }
    }
}
