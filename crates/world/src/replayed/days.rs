//! The recorded days of a person, ready to be lived by a body.

use cohort::Person;
use physiology::MgPerDl;

use super::doses::Doses;
use super::recorded_life::{self, RecordedLife};
use super::replaying::{Eaten, RecordedInputs, Replaying};
use super::{ReplayedPerson, restoring};
use crate::effects::{Amplitudes, Condition, Effect, conditions};
use crate::error::WorldError;
use crate::physique::{Course, Physique};
use crate::reactions::reactions;
use crate::stream::{Concept, stream};
use crate::warp::Warps;

/// Everything about the recorded days of a person under given amplitudes, except the body.
pub(super) struct Days<'a> {
    person: usize,
    pub(super) inputs: RecordedInputs<'a>,
    conditions: Vec<Condition>,
    amplitudes: Amplitudes,
    start: MgPerDl,
}

impl<'a> Days<'a> {
    /// The days of a person's record with these doses.
    pub(super) fn new(
        person: &ReplayedPerson,
        recorded: &RecordedLife,
        doses: &'a Doses,
        amplitudes: Amplitudes,
    ) -> Self {
        let mut life = recorded.life.clone();
        let miscount = amplitudes.of(Effect::CarbMiscount);
        recorded_life::eaten(&mut life, &person.background, &person.shapes, miscount);
        let happenings = person.happenings(&life);
        let mut conditions =
            conditions(&recorded.habits, &life, &happenings, &person.shapes, &amplitudes);
        conditions.drain(..recorded.offset);
        let mut rng = stream(person.seed, person.index, Concept::Reactions);
        let in_body = person.shapes.forms.in_body(amplitudes);
        let inputs = RecordedInputs {
            offset: recorded.offset,
            doses,
            eaten: Eaten::new(recorded, &life, &amplitudes),
            reactions: reactions(&life.calendar, &mut rng),
            life,
            unlogged_rescues: in_body.of(Effect::UnloggedRescueCarbs),
        };
        Self {
            person: person.index,
            inputs,
            conditions,
            amplitudes: in_body,
            start: MgPerDl(first_glucose(&person.original)),
        }
    }

    /// The course of a body with a restoring change through these days.
    pub(super) fn lived(&self, body: Physique, restoring: &[f64]) -> Result<Course, WorldError> {
        let mut conditions = self.conditions.clone();
        restoring::restore(&mut conditions, self.inputs.offset, restoring);
        let mut source = Replaying::new(&self.inputs);
        body.run(
            &conditions,
            self.amplitudes,
            Warps::NONE,
            self.start,
            &mut source,
            self.inputs.doses.len(),
        )
        .map_err(|source| WorldError::Body { person: self.person, source })
    }
}

/// Glucose at the start, mg/dL: the first reading, clamped to where bodies have a steady state.
fn first_glucose(person: &Person) -> f64 {
    person.record.cgm().iter().flatten().next().copied().unwrap_or(140.0).clamp(90.0, 160.0)
}
