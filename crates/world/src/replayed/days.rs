//! The recorded days of a person, ready to be lived by a body.

use physiology::MgPerDl;

use super::doses::Doses;
use super::recorded_life::{self, RecordedLife};
use super::replaying::{Eaten, Replaying};
use super::{ReplayedPerson, fit, restoring};
use crate::behaviour::Life;
use crate::effects::{Amplitudes, Condition, Effect, conditions};
use crate::error::WorldError;
use crate::physique::{Course, Physique};
use crate::reactions::{Reaction, reactions};
use crate::stream::{Concept, stream};
use crate::warp::Warps;

/// Everything about the recorded days of a person under given amplitudes, except the body.
pub(super) struct Days<'a> {
    person: usize,
    pub(super) offset: usize,
    pub(super) doses: &'a Doses,
    pub(super) life: Life,
    conditions: Vec<Condition>,
    pub(super) eaten: Eaten,
    pub(super) reactions: Vec<Reaction>,
    pub(super) amplitudes: Amplitudes,
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
        Self {
            person: person.index,
            offset: recorded.offset,
            doses,
            conditions,
            eaten: Eaten::new(recorded, &life, &amplitudes),
            reactions: reactions(
                &life.calendar,
                &mut stream(person.seed, person.index, Concept::Reactions),
            ),
            life,
            amplitudes: person.shapes.forms.in_body(amplitudes),
            start: MgPerDl(fit::first_glucose(&person.original)),
        }
    }

    /// The course of a body with a restoring change through these days.
    pub(super) fn lived(&self, body: Physique, restoring: &[f64]) -> Result<Course, WorldError> {
        let mut conditions = self.conditions.clone();
        restoring::restore(&mut conditions, self.offset, restoring);
        let mut source = Replaying::new(self);
        body.run(
            &conditions,
            self.amplitudes,
            Warps::NONE,
            self.start,
            &mut source,
            self.doses.len(),
        )
        .map_err(|source| WorldError::Body { person: self.person, source })
    }
}
