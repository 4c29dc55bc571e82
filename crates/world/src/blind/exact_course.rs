//! The exact course of an effect, which only its world knows.
//!
//! A diagnosis with this course as its template would lose nothing by the form of its library. What
//! it still could not name is lost to the noise, to the background and to the rate of false alarms.

use cohort::{Cohort, Person};
use physiology::STEP;
use rayon::prelude::*;

use super::planned_effect::PlannedEffect;
use super::realised::RealisedWorld;
use crate::effects::Amplitudes;
use crate::error::WorldError;
use crate::virtual_person::{LivedDays, VirtualPerson};

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
        let known = self.people.iter().flatten().flatten();
        let (sum, n) = known.fold((0.0, 0_usize), |(sum, n), value| (sum + value.abs(), n + 1));
        if n == 0 { 0.0 } else { sum / n as f64 }
    }
}

impl RealisedWorld {
    /// The exact course of every effect that acts, each in the presence of the others, and of those
    /// of `idle` that do not act. Meals and rescue carbohydrate that were never eaten have none: of these two, an
    /// idle course is 0.
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
        let lived = self.lived()?;
        let acting: Vec<PlannedEffect> = self.effects.iter().map(|found| found.effect).collect();
        let idle = idle.iter().copied().filter(|effect| !acting.contains(effect));
        let effects = acting.iter().map(|e| (*e, true)).chain(idle.map(|e| (e, false)));
        effects
            .map(|(effect, acts)| {
                let people = lived
                    .par_iter()
                    .zip(&cohort.people)
                    .map(|((person, days), recorded)| {
                        let course = if acts {
                            person.shown_by(days, &effect.set(person.amplitudes, 0.0), 1.0)?
                        } else {
                            person.shown_by(days, &effect.set(person.amplitudes, 1.0), -1.0)?
                        };
                        Ok(along(&course, days, recorded))
                    })
                    .collect::<Result<_, WorldError>>()?;
                Ok(ExactCourse { effect, acts, people })
            })
            .collect()
    }
}

impl VirtualPerson {
    /// `sign` times the difference in what the sensor shows: the days as lived minus the days with
    /// other amplitudes.
    fn shown_by(
        &self,
        lived: &LivedDays,
        other: &Amplitudes,
        sign: f64,
    ) -> Result<Vec<Option<f64>>, WorldError> {
        let with = self.sensed(&lived.life, &lived.glucose, &self.amplitudes)?;
        let without = self.counterfactual(lived, other)?.sensed;
        let pairs = with.iter().zip(&without);
        Ok(pairs.map(|(a, b)| Some(sign * ((*a)?.0 - (*b)?.0))).collect())
    }
}

/// The part of a course along a record that covers some of the days.
fn along(course: &[Option<f64>], lived: &LivedDays, recorded: &Person) -> Vec<Option<f64>> {
    let late = recorded.record.start() - lived.life.calendar.time(0);
    let first = (late.num_minutes() as f64 / STEP.0) as usize;
    (first..first + recorded.record.len()).map(|step| course.get(step).copied().flatten()).collect()
}
