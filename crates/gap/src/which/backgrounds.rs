//! The background of a hidden event's test: constant directions.

use std::collections::BTreeMap;

use effects::{Allowance, Card, EffectId};

use super::held_out;
use super::statistics::TestStatistics;
use super::tried::Tried;
use crate::background::Allowed;
use crate::design::{Column, Design, EventBank, HiddenEvents};
use crate::event_bank::FittedBackground;

/// The hidden events of a design, scored beside constant directions: events must not be made of what every meal or every
/// low of a person shows. `before` are the banks of an earlier round.
///
/// Directions that are what an effect itself would change are left out for it; effects with the same directions share what
/// is fitted.
pub(super) fn banks(
    design: &Design,
    statistics: &TestStatistics,
    hidden: HiddenEvents,
    tried: &Tried<'_>,
    before: &[EventBank],
) -> Vec<EventBank> {
    let beside = |effect: EffectId| -> Vec<Allowed> {
        allowed(&statistics.columns, &[], 0, Some(&tried.get(effect).card()))
    };
    let columns =
        |allowed: &[Allowed]| -> Vec<usize> { allowed.iter().map(|a| a.column).collect() };
    let mut each = BTreeMap::new();
    for effect in hidden.effects() {
        let allowed = beside(effect);
        each.entry(columns(&allowed)).or_insert_with(|| fitted(design, statistics, &allowed));
    }
    hidden.banks(|effect| &each[&columns(&beside(effect))], &design.weights, before)
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
                let holds = |allowance: &Allowance| which.is(*allowance);
                let own = tested.is_some_and(|card| card.relations.is_itself.iter().any(holds));
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
