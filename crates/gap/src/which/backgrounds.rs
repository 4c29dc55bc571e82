//! The background of a hidden event's test: constant directions.

use effects::{Card, EffectId};

use super::held_out;
use super::statistics::TestStatistics;
use super::tried::Tried;
use crate::background::Allowed;
use crate::design::{Background, Column, Design, HiddenEvents};
use crate::event_bank::FittedBackground;

/// The constant directions that are fitted before hidden events are scored: events must not be made of what every
/// meal or every low of a person shows.
pub(super) struct Backgrounds<'a> {
    each: Vec<FittedBackground<'a>>,
    /// Each effect with the index of its background in `each`.
    indices: Vec<(EffectId, usize)>,
}

impl<'a> Backgrounds<'a> {
    /// Directions that are what an effect itself would change are left out for it. `hidden` are the design's.
    pub(super) fn of(
        design: &'a Design,
        statistics: &TestStatistics,
        hidden: &HiddenEvents,
        tried: &Tried<'_>,
    ) -> Self {
        let mut sets: Vec<Vec<usize>> = Vec::new();
        let mut found = Self { each: Vec::new(), indices: Vec::new() };
        for effect in hidden.effects() {
            let card = tried.get(effect).card();
            let directions = allowed(&statistics.columns, &[], 0, Some(&card));
            let columns: Vec<usize> = directions.iter().map(|a| a.column).collect();
            let known = sets.iter().position(|set| *set == columns);
            found.indices.push((effect, known.unwrap_or(sets.len())));
            if known.is_none() {
                sets.push(columns);
                found.each.push(fitted(design, statistics, &directions));
            }
        }
        found
    }

    /// The background of an effect that acts by hidden events.
    pub(super) fn for_effect(&self, effect: EffectId) -> &FittedBackground<'a> {
        let entry = self.indices.iter().find(|(known, _)| *known == effect);
        &self.each[entry.map_or(0, |(_, index)| *index)]
    }
}

/// Standard deviation of the amplitude of a guard that was not named.
const GUARD_SD: f64 = 0.5;

/// An effect that is allowed for while others are tested.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Guard {
    pub(super) effect: EffectId,
    /// Standard deviation of its amplitude.
    pub(super) sd: f64,
    /// The variant by which it was named, by person; empty where it was not: then the first stands for it.
    pub(super) variants: Vec<usize>,
}

impl Guard {
    /// An effect that every body has in its own measure.
    pub(super) fn usual(effect: EffectId) -> Self {
        Self { effect, sd: GUARD_SD, variants: Vec::new() }
    }
}

/// What is allowed for when an effect is tested in a person: the background and one variant of each guard, with their
/// standard deviations; nothing that is the effect itself. `None` is for no effect in particular.
pub(super) fn allowed(
    columns: &[Column],
    guards: &[Guard],
    person: usize,
    tested: Option<&Card>,
) -> Vec<Allowed> {
    let mut guarded: Vec<EffectId> = Vec::new();
    columns
        .iter()
        .enumerate()
        .filter_map(|(column, stands_for)| match stands_for {
            Column::Background { which, prior_sd } => {
                let own = tested.is_some_and(|card| is_itself(card, *which));
                (!own).then_some(Allowed { column, mean: 0.0, sd: *prior_sd })
            }
            Column::Effect { effect, variant } => {
                // One variant of each guard: its others differ in sign or phase.
                let guard = guards.iter().find(|guard| guard.effect == *effect)?;
                let own = tested.is_some_and(|card| card.id == *effect);
                let other = guard.variants.get(person).is_some_and(|named| named != variant);
                if own || other || guarded.contains(effect) {
                    return None;
                }
                guarded.push(*effect);
                Some(Allowed { column, mean: 0.0, sd: guard.sd })
            }
        })
        .collect()
}

fn fitted<'a>(
    design: &'a Design,
    statistics: &TestStatistics,
    allowed: &[Allowed],
) -> FittedBackground<'a> {
    let (fitted, factor) = held_out::fitted_to_all(&statistics.folds, allowed);
    let mut residuals = design.residuals.clone();
    for (allowed, value) in allowed.iter().zip(fitted) {
        for (residual, signature) in residuals.iter_mut().zip(&design.signatures[allowed.column]) {
            *residual += value * f64::from(*signature);
        }
    }
    let of = |allowed: &Allowed| design.signatures[allowed.column].as_slice();
    FittedBackground::of(&residuals, &design.weights, allowed.iter().map(of).collect(), &factor)
}

/// Whether a direction of the background is what an effect itself would change.
fn is_itself(effect: &Card, direction: Background) -> bool {
    effect.relations.is_itself.iter().any(|allowance| direction.is(*allowance))
}
