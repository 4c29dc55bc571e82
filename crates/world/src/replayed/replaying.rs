//! Recorded doses as the inputs of a simulation.

use std::collections::BTreeMap;

use physiology::{Grams, InputSource, MgPerDl, StepInput};

use super::doses::Doses;
use super::recorded_life::RecordedLife;
use crate::behaviour::Life;
use crate::effects::{Amplitudes, Effect};
use crate::reactions::Reaction;

/// Glucose at which rescue carbohydrate that no record holds may be eaten, how likely it is in a
/// step, and the steps between two such treatments, as in the made worlds.
const LOW: f64 = 66.0;
const TREATS: f64 = 0.2;
const PAUSE: usize = 3;
/// Share of treatments that are not logged at amplitude 1; the logged ones are in the record.
const UNLOGGED: f64 = 0.5;

/// The doses of a record, with what is eaten in truth.
pub(super) struct Replaying<'a> {
    offset: usize,
    doses: &'a Doses,
    life: &'a Life,
    reactions: &'a [Reaction],
    amplitudes: Amplitudes,
    eaten: BTreeMap<usize, f64>,
    last_treatment: Option<usize>,
}

impl<'a> Replaying<'a> {
    /// The doses of a record whose `life` holds what was eaten.
    pub(super) fn new(
        recorded: &RecordedLife,
        life: &'a Life,
        doses: &'a Doses,
        reactions: &'a [Reaction],
        amplitudes: Amplitudes,
    ) -> Self {
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
        let offset = recorded.offset;
        Self { offset, doses, life, reactions, amplitudes, eaten, last_treatment: None }
    }
}

impl InputSource for Replaying<'_> {
    fn next(&mut self, step: usize, glucose: MgPerDl) -> Option<StepInput> {
        let mut input = *self.doses.inputs.get(step)?;
        let at = step + self.offset;
        input.carbs = Grams(self.eaten.get(&at).copied().unwrap_or(0.0));
        input.exercise = self.life.session_at(at).map(|session| session.exercise);
        let reaction = self.reactions.get(at)?;
        let unlogged = UNLOGGED * self.amplitudes.of(Effect::UnloggedRescueCarbs);
        let waits = self.last_treatment.is_some_and(|last| step - last < PAUSE);
        if glucose.0 < LOW && !waits && reaction.treat < TREATS && reaction.treat_log < unlogged {
            self.last_treatment = Some(step);
            input.rescue.amount = Grams((12.0 + 8.0 * reaction.treat_size).round());
        }
        Some(input)
    }
}
