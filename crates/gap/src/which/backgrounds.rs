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
            let allowed = background_columns(statistics, &tried.get(effect).card());
            let columns: Vec<usize> = allowed.iter().map(|a| a.column).collect();
            let known = sets.iter().position(|set| *set == columns);
            found.indices.push((effect, known.unwrap_or(sets.len())));
            if known.is_none() {
                sets.push(columns);
                found.each.push(fitted(design, statistics, &allowed));
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

/// The directions of the background that the test of an effect with hidden events allows for.
fn background_columns(statistics: &TestStatistics, effect: &Card) -> Vec<Allowed> {
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
pub(super) fn is_itself(effect: &Card, direction: Background) -> bool {
    effect.relations.is_itself.iter().any(|allowance| direction.is(*allowance))
}
