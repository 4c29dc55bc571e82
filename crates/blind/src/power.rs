//! How often an effect is found, by its name and by the shift that it causes.

use crate::outcome::outcome;
use crate::share::among;
use contract::blind_check::{Kind, Outcome, PowerRow};

use std::collections::BTreeSet;

use crate::error::BlindError;
use crate::scored_world::ScoredWorld;

/// Lower limits of the bins of the achieved shift, mg/dL; the last has no upper limit. They are
/// halfway between the targets 2.5, 5, 10 and 15.
pub const SHIFT_BINS: [f64; 4] = [0.0, 3.75, 7.5, 12.5];

/// Rows of all effects together, then of each effect; bins without a world have no row.
pub(crate) fn power(worlds: &[ScoredWorld]) -> Result<Vec<PowerRow>, BlindError> {
    let singles: Vec<&ScoredWorld> =
        worlds.iter().filter(|w| w.label.kind == Kind::Single).collect();
    let names: BTreeSet<&str> =
        singles.iter().flat_map(|w| &w.label.effects).map(|e| e.effect.as_str()).collect();
    let mut rows = Vec::new();
    for effect in std::iter::once(None).chain(names.into_iter().map(Some)) {
        for (index, from) in SHIFT_BINS.into_iter().enumerate() {
            let to = SHIFT_BINS.get(index + 1).copied();
            let within: Vec<&ScoredWorld> = singles
                .iter()
                .copied()
                .filter(|w| effect.is_none_or(|name| w.label.has(name)))
                .filter(|w| {
                    let shift = w.label.largest_shift();
                    from <= shift && to.is_none_or(|to| shift < to)
                })
                .collect();
            if !within.is_empty() {
                let outcome = |w: &ScoredWorld| outcome(&w.label, &w.answer);
                let shifts: f64 = within.iter().map(|w| w.label.largest_shift()).sum();
                rows.push(PowerRow {
                    effect: effect.map(str::to_owned),
                    from_mg_dl: from,
                    to_mg_dl: to,
                    mean_shift_mg_dl: shifts / within.len() as f64,
                    named: among(&within, |w| outcome(w) == Outcome::Correct)?,
                    named_or_in_set: among(&within, |w| outcome(w).is_correct_or_in_set())?,
                    detected: among(&within, |w| w.answer.raises_alarm())?,
                    ceiling: None,
                });
            }
        }
    }
    Ok(rows)
}
