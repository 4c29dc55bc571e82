//! The exact course of an effect, which only its world knows.
//!
//! A diagnosis with this course as its template would lose nothing by the form of its library. What
//! it still could not name is lost to the noise, to the background and to the rate of false alarms.

use std::ops::Range;

use cohort::{Cohort, Person};
use physiology::STEP;
use rayon::prelude::*;

use super::planned_effect::PlannedEffect;
use super::realised::LivedWorld;
use crate::error::WorldError;
use crate::shift::mean;
use crate::virtual_person::LivedDays;

/// The difference that an effect makes to the sensors, under the insulin delivered and the
/// carbohydrate logged.
#[derive(Debug, Clone, PartialEq)]
pub struct ExactCourse {
    /// The effect.
    pub effect: PlannedEffect,
    /// Whether it acts in the world. Otherwise the course is what it would add at its published
    /// size.
    pub acts: bool,
    /// A list per person with an entry per step of their record, mg/dL; `None` where the reading is
    /// lost.
    pub people: Vec<Vec<Option<f64>>>,
}

impl ExactCourse {
    /// Mean absolute course over people and steps, mg/dL; 0 where nothing is known.
    #[must_use]
    pub fn size(&self) -> f64 {
        mean(self.people.iter().flatten().flatten().map(|value| value.abs())).unwrap_or(0.0)
    }
}

impl LivedWorld {
    /// The exact course of every effect that acts, each in the presence of the others, and of those
    /// of `idle` that do not act. Meals and rescue carbohydrate that were never eaten have none: of
    /// these two, an idle course is 0.
    ///
    /// `cohort` is the result of [`cohort`](Self::cohort) for this world: courses run along its
    /// records.
    ///
    /// # Errors
    /// If a body fails.
    pub fn exact_courses(
        &self,
        cohort: &Cohort,
        idle: &[PlannedEffect],
    ) -> Result<Vec<ExactCourse>, WorldError> {
        let everybody = self.everybody();
        let acting: Vec<PlannedEffect> =
            self.world.effects.iter().map(|found| found.effect).collect();
        let idle = idle.iter().copied().filter(|effect| !acting.contains(effect));
        let effects = acting.iter().map(|e| (*e, true)).chain(idle.map(|e| (e, false)));
        effects
            .map(|(effect, acts)| {
                // With minus without it: the days as lived are with it where it acts.
                let (other, sign) = if acts { (0.0, 1.0) } else { (1.0, -1.0) };
                let people = everybody
                    .par_iter()
                    .zip(&cohort.people)
                    .map(|((person, days), recorded)| {
                        let other = effect.set(person.amplitudes, other);
                        let other = person.counterfactual(days, &other)?.sensed;
                        let course = person.readings_less(days, &other)?;
                        let at = |step: usize| Some(sign * (*course.get(step)?)?);
                        let along: Vec<_> = steps_of(recorded, days).map(at).collect();
                        Ok(along)
                    })
                    .collect::<Result<_, WorldError>>()?;
                Ok(ExactCourse { effect, acts, people })
            })
            .collect()
    }
}

/// The steps of a life that a record covers.
fn steps_of(recorded: &Person, lived: &LivedDays) -> Range<usize> {
    let late = recorded.record.start() - lived.life.calendar.time(0);
    let first = (late.num_minutes() as f64 / STEP.0) as usize;
    first..first + recorded.record.len()
}
