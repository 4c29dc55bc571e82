//! Recorded doses as the inputs of a simulation.

use std::collections::BTreeMap;

use physiology::{Grams, InputSource, MgPerDl, StepInput};

use super::doses::Doses;
use super::recorded_life::RecordedLife;
use crate::behaviour::Life;
use crate::effects::{Amplitudes, Effect};
use crate::reactions::Reaction;

/// Glucose at which unrecorded rescue carbohydrate may be eaten, its probability per step, and the
/// steps between two such treatments, as in the made worlds.
const LOW: f64 = 66.0;
const TREATS: f64 = 0.2;
const PAUSE: usize = 3;
/// Share of treatments that are not logged at amplitude 1; the logged ones are in the record.
const UNLOGGED: f64 = 0.5;

/// Carbohydrate that is eaten besides treatments, g, by step of the calendar.
pub(super) struct Eaten(BTreeMap<usize, f64>);

impl Eaten {
    /// The meals of a `life` that holds what was eaten, and what is eaten besides the record.
    pub(super) fn new(recorded: &RecordedLife, life: &Life, amplitudes: &Amplitudes) -> Self {
        let mut eaten = BTreeMap::new();
        for meal in &life.meals {
            *eaten.entry(meal.step).or_insert(0.0) += meal.eaten.0;
        }
        let missed = amplitudes.of(Effect::MissedMeals);
        for (step, grams, from) in &recorded.unlogged {
            if *from < missed {
                *eaten.entry(*step).or_insert(0.0) += grams.0;
            }
        }
        Self(eaten)
    }
}

/// What a body gets in the days of a record, whatever the body.
pub(super) struct RecordedInputs<'a> {
    /// Steps from the start of the calendar to that of the record.
    pub(super) offset: usize,
    pub(super) doses: &'a Doses,
    pub(super) life: Life,
    pub(super) eaten: Eaten,
    pub(super) reactions: Vec<Reaction>,
    /// Amplitude of the effect that leaves rescue carbohydrate out of the log.
    pub(super) unlogged_rescues: f64,
}

/// The doses of a record, with what is truly eaten.
pub(super) struct Replaying<'a> {
    recorded: &'a RecordedInputs<'a>,
    unlogged: f64,
    last_treatment: Option<usize>,
}

impl<'a> Replaying<'a> {
    /// The doses of these days.
    pub(super) fn new(recorded: &'a RecordedInputs<'a>) -> Self {
        let unlogged = UNLOGGED * recorded.unlogged_rescues;
        Self { recorded, unlogged, last_treatment: None }
    }
}

impl InputSource for Replaying<'_> {
    fn next(&mut self, step: usize, glucose: MgPerDl) -> Option<StepInput> {
        let mut input = *self.recorded.doses.inputs.get(step)?;
        let at = step + self.recorded.offset;
        input.carbs = Grams(self.recorded.eaten.0.get(&at).copied().unwrap_or(0.0));
        input.exercise = self.recorded.life.session_at(at).map(|session| session.exercise);
        let reaction = self.recorded.reactions.get(at)?;
        let waits = self.last_treatment.is_some_and(|last| step - last < PAUSE);
        if glucose.0 < LOW
            && !waits
            && reaction.treat < TREATS
            && reaction.treat_log < self.unlogged
        {
            self.last_treatment = Some(step);
            input.rescue.amount = Grams((12.0 + 8.0 * reaction.treat_size).round());
        }
        Some(input)
    }
}
