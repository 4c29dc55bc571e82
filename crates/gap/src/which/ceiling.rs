//! What the exact course of an effect would show: the ceiling of any template.
//!
//! The difference that an effect makes to a person's readings, under the insulin delivered and the carbohydrate
//! logged, is an offset of the sensor as far as the filter is concerned: with gains held, what the filter's
//! innovations answer to it is the signature of the effect itself. It becomes one more column of the linear model of a
//! person. Its held-out evidence passes the same background, the same random differences between days, the same folds
//! and hierarchy as a driven effect of the library, and directions that rival the effect are left out as they are
//! for it. What the library loses by its form is then the distance between an effect's power and the share
//! of worlds in which its exact course exceeds the threshold.

use cohort::Cohort;
use effects::{Card, Course, Effect, Field, Form, Modulation, Port, Prior};
use physiology::STEPS_PER_DAY;
use rayon::prelude::*;

use super::GUARDS;
use super::held_out::{Trial, held_out};
use super::round::{GUARD_SD, Round, Subject};
use super::statistics::Person as Statistics;
use crate::config::DiagnosisConfig;
use crate::design::{Column, design};
use crate::error::GapError;
use crate::person::{PersonAnalysis, PersonOutcome, analyse};
use crate::plants::Plants;

/// The exact course of an effect in a cohort.
#[derive(Debug, Clone, PartialEq)]
pub struct ExactCourse {
    /// The name under which the library knows the effect, and thresholds are kept.
    pub effect: String,
    /// What readings show more with the effect than without it: a list a person of the cohort, an entry a step of
    /// the record, mg/dL; `None` where it is not known.
    pub people: Vec<Vec<Option<f64>>>,
}

impl ExactCourse {
    fn lies_along(&self, cohort: &Cohort) -> Result<(), GapError> {
        let entries = self.people.iter().zip(&cohort.people);
        let lengths = entries.map(|(own, person)| (own.len(), person.record.len()));
        let lists = std::iter::once((self.people.len(), cohort.people.len()));
        match lists.chain(lengths).find(|(found, needed)| found != needed) {
            None => Ok(()),
            Some((found, needed)) => {
                Err(GapError::Course { effect: self.effect.clone(), found, needed })
            }
        }
    }
}

/// Evidence of one exact course.
#[derive(Debug, Clone, PartialEq)]
pub struct ExactEvidence {
    /// The effect.
    pub effect: String,
    /// Held-out evidence, nats.
    pub gain: f64,
    /// Evidence at which a diagnosis of this cohort names the effect, nats.
    pub threshold: f64,
    /// Estimated share of the course that is there: mean over people; 1 is all of it.
    pub amplitude: f64,
}

/// The evidence of exact courses in a cohort, one entry a course.
///
/// People whom a diagnosis excludes take no part. The calibration is that of a diagnosis: what it took of an effect
/// into a person's factors stays there.
///
/// # Errors
/// [`GapError::Course`] for a course that does not lie along the records; otherwise as
/// [`diagnose`](crate::diagnose).
pub fn exact_course_evidence(
    cohort: &Cohort,
    courses: &[ExactCourse],
    plants: &dyn Plants,
    config: &DiagnosisConfig,
) -> Result<Vec<ExactEvidence>, GapError> {
    let config = config.clone().validated()?;
    for course in courses {
        course.lies_along(cohort)?;
    }
    let outcomes: Vec<PersonOutcome> = cohort
        .people
        .par_iter()
        .map(|person| analyse(person, plants, &config))
        .collect::<Result<_, GapError>>()?;
    let found: Vec<(Subject, usize)> = cohort
        .people
        .par_iter()
        .zip(&outcomes)
        .enumerate()
        .filter_map(|(index, (person, outcome))| {
            let analysis = outcome.analysis.as_ref()?;
            let own: Vec<&[Option<f64>]> =
                courses.iter().map(|course| course.people[index].as_slice()).collect();
            let steps = analysis.observations.len();
            Some(subject(person, analysis, &own).map(|subject| (subject, steps)))
        })
        .collect::<Result<_, GapError>>()?;
    if found.is_empty() {
        let first = outcomes.first().map(|outcome| &outcome.summary);
        return Err(first.map_or(GapError::EmptyCohort, |first| GapError::NobodyLeft {
            people: outcomes.len(),
            person: first.person_id.clone(),
            reason: first.excluded.clone().unwrap_or_default(),
        }));
    }
    let (subjects, steps): (Vec<Subject>, Vec<usize>) = found.into_iter().unzip();
    let days = steps.iter().sum::<usize>() as f64 / STEPS_PER_DAY as f64;
    let guards = (0..GUARDS.len()).map(|guard| (courses.len() + guard, GUARD_SD)).collect();
    let round = Round::estimated(subjects, guards);
    let evidence = courses.par_iter().enumerate().map(|(index, course)| {
        let found = held_out(&trials(&round, index, courses));
        ExactEvidence {
            effect: course.effect.clone(),
            gain: found.gain(),
            threshold: config.thresholds.of(&course.effect).over(days),
            amplitude: found.hierarchy.mean,
        }
    });
    Ok(evidence.collect())
}

/// The linear model of one person: the background, the courses, and then the guards.
fn subject(
    person: &cohort::Person,
    analysis: &PersonAnalysis,
    courses: &[&[Option<f64>]],
) -> Result<Subject, GapError> {
    let observations = &analysis.observations;
    let templates: Vec<Template<'_>> = courses.iter().map(|course| Template { course }).collect();
    let guards: Vec<Box<dyn Effect>> =
        GUARDS.iter().filter_map(|name| effects::find(name)).collect();
    let templates = templates.iter().map(|template| template as &dyn Effect);
    let library: Vec<&dyn Effect> = templates.chain(guards.iter().map(AsRef::as_ref)).collect();
    let person = analysis.person.as_ref().unwrap_or(person);
    let mut design = design(person, observations, &analysis.calibration, &library)?;
    let statistics = Statistics::of(&design);
    // The largest parts of a person, and summed up.
    design.signatures = Vec::new();
    Ok(Subject {
        design,
        statistics,
        units: Vec::new(),
        events: Vec::new(),
        bins: None,
        lags: None,
    })
}

/// What everybody brings to the test of a course; the guard of the same name does not stand beside it.
fn trials<'a>(round: &'a Round, index: usize, courses: &[ExactCourse]) -> Vec<Trial<'a>> {
    let name = courses[index].effect.as_str();
    let own_guard = GUARDS.iter().position(|guard| *guard == name).map(|k| courses.len() + k);
    let mut trials = round.trials(index, name);
    for (trial, subject) in trials.iter_mut().zip(&round.subjects) {
        trial.allowed.retain(|allowed| match subject.statistics.columns[allowed.column] {
            Column::Effect { effect, .. } => Some(effect) != own_guard,
            Column::Background { .. } => true,
        });
    }
    trials
}

/// An offset of the sensor that follows a course.
#[derive(Debug)]
struct Template<'a> {
    course: &'a [Option<f64>],
}

impl Effect for Template<'_> {
    fn card(&self) -> Card {
        Card {
            name: "exact_course",
            port: Port::Sensor,
            summary: "what readings show more with an effect than without it",
            size_at_one: "all of it",
            source: "the world that made the record",
            signature: "its own",
            channels: &[],
            confusable_with: &[],
            prior: Prior { median: 1.0, log_sd: 0.5, largest: 3.0 },
        }
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
