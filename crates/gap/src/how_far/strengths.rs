//! How frequent and strong hidden changes are, from training days.

use rayon::prelude::*;

use super::NamedEffect;
use super::folds::FOLDS;
use super::person_fold::PersonFold;
use super::reconstruction::{self, Strength, StrengthSums};
use super::subject::Subject;
use crate::filter::calibration::CalibrationRule;

/// How frequent and strong each hidden effect is in the training days of each fold, over all people: one
/// list a fold. Who cannot be counted is left to a note.
pub(super) fn strengths(
    subjects: &[Subject<'_>],
    person_folds: &[PersonFold<'_>],
    found: &[NamedEffect<'_>],
    hidden: &[usize],
    calibration: &CalibrationRule,
    notes: &mut Vec<String>,
) -> Vec<Vec<Strength>> {
    let form_of = |index: usize| subjects.iter().find_map(|s| s.forms[index].as_ref());
    let first: Vec<(usize, Strength)> = hidden
        .iter()
        .filter_map(|index| {
            let people = subjects.len() as f64;
            let mean =
                (0..subjects.len()).map(|i| found[*index].amplitude(i)).sum::<f64>() / people;
            Some((*index, reconstruction::published(form_of(*index)?, mean)?))
        })
        .collect();
    let tallies: Vec<Option<Vec<StrengthSums>>> = person_folds
        .par_iter()
        .map(|person_fold| {
            person_fold.tallies(&subjects[person_fold.subject], &first, calibration).ok()
        })
        .collect();
    let lost = tallies.iter().filter(|tally| tally.is_none()).count();
    if lost > 0 {
        notes.push(format!("hidden events of {lost} fits could not be counted"));
    }
    (0..FOLDS)
        .map(|fold| {
            let of_fold = person_folds
                .iter()
                .zip(&tallies)
                .filter(|(person_fold, _)| person_fold.fold == fold);
            let mut sums = vec![StrengthSums::default(); first.len()];
            for tallies in of_fold.filter_map(|(_, tallies)| tallies.as_ref()) {
                for (sum, tally) in sums.iter_mut().zip(tallies) {
                    *sum = sum.plus(*tally);
                }
            }
            sums.iter()
                .zip(&first)
                .map(|(sum, (index, strength))| {
                    form_of(*index).map_or(*strength, |form| sum.strength(form, *strength))
                })
                .collect()
        })
        .collect()
}
