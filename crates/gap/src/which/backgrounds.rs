//! What stands beside a hidden event: the constant directions of the background.

use effects::{Card, EffectId};

use super::held_out::{self, Allowed};
use super::statistics::Person as Statistics;
use super::tried::Tried;
use crate::design::{Background, Column, Design, HiddenEvents};
use crate::event_bank::Beside;

/// The constant directions of the background beside hidden events, which must not be made of what every meal or
/// every low of a person shows.
pub(super) struct Backgrounds<'a> {
    each: Vec<Beside<'a>>,
    /// Effects and the index of theirs in `each`.
    places: Vec<(EffectId, usize)>,
}

impl<'a> Backgrounds<'a> {
    /// Directions that are what an effect itself would change are left out for it. `hidden` are the design's.
    pub(super) fn of(
        design: &'a Design,
        statistics: &Statistics,
        hidden: &HiddenEvents,
        tried: &Tried<'_>,
    ) -> Self {
        let mut sets: Vec<Vec<usize>> = Vec::new();
        let mut found = Self { each: Vec::new(), places: Vec::new() };
        for effect in hidden.effects() {
            let allowed = beside_columns(statistics, &tried.get(effect).card());
            let columns: Vec<usize> = allowed.iter().map(|a| a.column).collect();
            let known = sets.iter().position(|set| *set == columns);
            found.places.push((effect, known.unwrap_or(sets.len())));
            if known.is_none() {
                sets.push(columns);
                found.each.push(beside(design, statistics, &allowed));
            }
        }
        found
    }

    /// The background of an effect that acts by hidden events.
    pub(super) fn beside(&self, effect: EffectId) -> &Beside<'a> {
        let place = self.places.iter().find(|(known, _)| *known == effect);
        &self.each[place.map_or(0, |(_, place)| *place)]
    }
}

/// The directions of the background that may stand beside a hidden event of an effect.
pub(super) fn beside_columns(statistics: &Statistics, effect: &Card) -> Vec<Allowed> {
    let columns = statistics.columns.iter().enumerate();
    columns
        .filter_map(|(column, stands_for)| match stands_for {
            Column::Background { which, prior_sd } if !is_itself(effect, *which) => {
                Some(Allowed { column, mean: 0.0, sd: *prior_sd })
            }
            _ => None,
        })
        .collect()
}

fn beside<'a>(design: &'a Design, statistics: &Statistics, allowed: &[Allowed]) -> Beside<'a> {
    let (fitted, factor) = held_out::fitted_to_all(&statistics.folds, allowed);
    let mut left = design.residuals.clone();
    for (allowed, value) in allowed.iter().zip(fitted) {
        for (rest, signature) in left.iter_mut().zip(&design.signatures[allowed.column]) {
            *rest += value * f64::from(*signature);
        }
    }
    let of = |allowed: &Allowed| design.signatures[allowed.column].as_slice();
    Beside::of(&left, &design.weights, allowed.iter().map(of).collect(), &factor)
}

/// Whether a direction of the background is what an effect itself would change.
pub(super) fn is_itself(effect: &Card, direction: Background) -> bool {
    effect.relations.is_itself.iter().any(|allowance| direction.is(*allowance))
}
