//! How frequent and strong hidden changes are, from training days.

use rayon::prelude::*;

use super::NamedEffect;
use super::reconstruction::{self, Strength, Tally};
use super::settings::Settings;
use super::subject::Subject;
use super::unit::Unit;

/// How frequent and strong each hidden effect is in the training days of each fold, over all people: one
/// list a fold. Who cannot be counted is left to a note.
pub(super) fn strengths(
    subjects: &[Subject<'_>],
    units: &[Unit<'_>],
    found: &[NamedEffect<'_>],
    hidden: &[usize],
    settings: Settings<'_>,
    notes: &mut Vec<String>,
) -> Vec<Vec<Strength>> {
    let form_of = |place: usize| subjects.iter().find_map(|s| s.forms[place].as_ref());
    let first: Vec<(usize, Strength)> = hidden
        .iter()
        .filter_map(|place| {
            let people = subjects.len() as f64;
            let mean =
                (0..subjects.len()).map(|i| found[*place].amplitude(i)).sum::<f64>() / people;
            Some((*place, reconstruction::published(form_of(*place)?, mean)?))
        })
        .collect();
    let tallies: Vec<Option<Vec<Tally>>> = units
        .par_iter()
        .map(|unit| unit.tallies(&subjects[unit.subject], &first, settings.calibration).ok())
        .collect();
    let lost = tallies.iter().filter(|tally| tally.is_none()).count();
    if lost > 0 {
        notes.push(format!("hidden events of {lost} fits could not be counted"));
    }
    (0..settings.rule.folds)
        .map(|fold| {
            let of_fold = units.iter().zip(&tallies).filter(|(unit, _)| unit.fold == fold);
            let mut sums = vec![Tally::default(); first.len()];
            for tallies in of_fold.filter_map(|(_, tallies)| tallies.as_ref()) {
                for (sum, tally) in sums.iter_mut().zip(tallies) {
                    *sum = sum.plus(*tally);
                }
            }
            sums.iter()
                .zip(&first)
                .map(|(sum, (place, strength))| {
                    form_of(*place).map_or(*strength, |form| sum.strength(form, *strength))
                })
                .collect()
        })
        .collect()
}
