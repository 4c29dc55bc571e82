//! How far the effects found go: held-out error before and after.
//!
//! "Before" is the plant recalibrated on training days; "after" is the same plant with calibration
//! and amplitudes refitted jointly on the same days, from the same start, with at most the same number of
//! Gauss-Newton iterations to the same tolerance. Both are judged by free runs that start on the days held out. Training never
//! sees a reading of a day held out, and a run never sees a reading after its start: what drives an
//! effect is either on the log (meals, heart rate, sleep, the clock, set changes), which counts as
//! input, or the run's own glucose.
//!
//! Hidden events and random factors cannot be predicted. They are reconstructed from the readings of the
//! days held out, and stand in rows of their own.

mod drivers;
mod fitting;
mod floor;
mod folds;
mod hidden;
mod hierarchy;
mod judge;
mod person_fold;
mod prepared_steps;
mod reconstruction;
mod refit;
#[cfg(test)]
mod sample;
mod settings;
mod shrinkage;
mod small_sample;
mod strengths;
mod subject;
mod summary;

use effects::{Effect, Form};
use rayon::prelude::*;

use self::fitting::{FoldFits, fitted};
use self::hierarchy::CohortAmplitudes;
use self::person_fold::{Judged, PersonFold};
use self::strengths::strengths;
use self::subject::Subject;
use self::summary::{Pair, Summary};
use crate::calibrated_person::CalibratedPerson;
use crate::error::GapError;
use contract::WithInterval;
use contract::diagnosis::{AmplitudeChange, HowFar};

pub use settings::Settings;
pub use shrinkage::shrinkage;

/// An effect that was found.
#[derive(Debug, Clone)]
pub struct NamedEffect<'a> {
    /// The effect.
    pub effect: &'a dyn Effect,
    /// Its variant on the whole record; each fold chooses again, on its training days.
    pub variant: usize,
    /// Its amplitude, one value a person in their order; 1 is the published size. The fits on training days start
    /// there; hidden events and random factors have that strength.
    pub amplitudes: Vec<f64>,
}

impl NamedEffect<'_> {
    /// The amplitude of one person.
    fn amplitude(&self, person: usize) -> f64 {
        self.amplitudes.get(person).copied().unwrap_or(0.0)
    }
}

/// What adding the effects found changes on days held out.
///
/// `people` is everyone who was diagnosed and `found` the effects in the order in which they were found.
/// People are fitted in parallel; the result depends on `seed` (resampling) and not on the number of
/// threads. A person whose record cannot be split or whose fit fails is left out with a note.
///
/// # Errors
/// [`GapError::EmptyCohort`]; [`GapError::Statistics`].
pub fn how_far(
    people: &[CalibratedPerson<'_>],
    found: &[NamedEffect<'_>],
    settings: Settings<'_>,
    seed: u64,
) -> Result<HowFar, GapError> {
    if people.is_empty() {
        return Err(GapError::EmptyCohort);
    }
    let mut subjects: Vec<Subject<'_>> =
        people.par_iter().map(|input| Subject::new(input, found)).collect();
    let is_driven = |index: &usize| subjects.iter().any(|s| s.forms[*index] == Some(Form::Driven));
    let indices: Vec<usize> = (0..found.len()).filter(is_driven).collect();
    let driven: Vec<&NamedEffect<'_>> = indices.iter().map(|index| &found[*index]).collect();
    for (index, subject) in subjects.iter_mut().enumerate() {
        subject.drive(index, &driven);
    }
    let is_hidden = |index: &usize| {
        subjects.iter().any(|subject| {
            matches!(subject.forms[*index], Some(Form::Events(_) | Form::Random { .. }))
        })
    };
    let hidden: Vec<usize> = (0..found.len()).filter(is_hidden).collect();
    let mut notes = Vec::new();
    if driven.is_empty() && hidden.is_empty() {
        if !found.is_empty() {
            notes.push("nobody's record signals the effects found".to_owned());
        }
        return Ok(HowFar { notes, ..HowFar::default() });
    }
    let short = subjects.iter().filter(|subject| subject.folds.held_out(0).is_none());
    notes.extend(short.map(|subject| {
        format!("{}: fewer than two whole days, none can be held out", subject.input.person.id)
    }));
    notes.extend(driven.iter().enumerate().flat_map(|(k, found)| remarks(k, found, &subjects)));
    let calibration = settings.calibration;
    let fits = fitted(&subjects, &driven, calibration);
    let strengths =
        strengths(&subjects, &fits.person_folds, found, &hidden, calibration, &mut notes);
    let judged: Vec<Result<Judged, GapError>> = fits
        .person_folds
        .par_iter()
        .map(|person_fold| {
            person_fold.judged(&subjects[person_fold.subject], &hidden, &strengths, settings)
        })
        .collect();
    let (predicted, reconstructed) = gathered(&subjects, judged, &mut notes);
    let summary = Summary { people: &predicted, settings, seed };
    let mut changed = HowFar {
        people: summary.people(if hidden.is_empty() { &[] } else { &reconstructed }),
        notes,
        ..HowFar::default()
    };
    if !driven.is_empty() {
        changed.horizons = summary.horizons(false)?;
        changed.outcomes = summary.outcomes()?;
        changed.innovations = summary.innovations()?;
        changed.amplitudes = amplitudes(&driven, &fits, subjects.len());
    }
    if !hidden.is_empty() {
        let summary = Summary { people: &reconstructed, settings, seed };
        changed.horizons.extend(summary.horizons(true)?);
        let names: Vec<&str> = hidden.iter().map(|k| found[*k].effect.card().id.name()).collect();
        changed.notes.push(format!(
            "{} cannot be predicted: rows marked as reconstructed use the readings of the days held out",
            names.join(", ")
        ));
    }
    Ok(changed)
}

/// What is to be said of a driven effect.
fn remarks(index: usize, found: &NamedEffect<'_>, subjects: &[Subject<'_>]) -> Vec<String> {
    let name = found.effect.card().id.name();
    let mut remarks = Vec::new();
    let unsignalled = subjects.iter().filter(|s| !s.drivers[index].signalled).count();
    if unsignalled > 0 {
        let people = subjects.len();
        remarks.push(format!("{name}: {unsignalled} of {people} records do not signal it"));
    }
    if subjects.iter().any(|s| s.drivers[index].reads_glucose) {
        remarks.push(format!("{name} depends on glucose: free runs drive it with their own"));
    }
    remarks
}

/// Everyone with their days.
type People = Vec<(String, Vec<Pair>)>;

/// Everyone's days in their order, predicted and reconstructed; who fails is named.
fn gathered(
    subjects: &[Subject<'_>],
    judged: Vec<Result<Judged, GapError>>,
    notes: &mut Vec<String>,
) -> (People, People) {
    let nobody = || -> Vec<(String, Vec<(usize, Pair)>)> {
        subjects.iter().map(|s| (s.input.person.id.clone(), Vec::new())).collect()
    };
    let (mut predicted, mut reconstructed) = (nobody(), nobody());
    for result in judged {
        match result {
            Ok(days) => {
                predicted[days.subject].1.extend(days.predicted);
                reconstructed[days.subject].1.extend(days.reconstructed);
            }
            Err(error) => notes.push(format!("some days could not be judged: {error}")),
        }
    }
    let in_order = |(person, mut days): (String, Vec<(usize, Pair)>)| {
        days.sort_by_key(|(day, _)| *day);
        (person, days.into_iter().map(|(_, pair)| pair).collect())
    };
    let all = |people: Vec<_>| people.into_iter().map(in_order).collect();
    (all(predicted), all(reconstructed))
}

/// A person's amplitude of an effect, mean over folds.
fn of_person(person_folds: &[PersonFold<'_>], subject: usize, index: usize) -> Option<f64> {
    let of = |person_fold: &PersonFold<'_>| person_fold.after.amplitudes.get(index).copied();
    let values: Vec<f64> = person_folds
        .iter()
        .filter(|person_fold| person_fold.subject == subject)
        .filter_map(of)
        .collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Amplitudes of the cohort over the folds, and of its `people`.
fn amplitudes(
    driven: &[&NamedEffect<'_>],
    fits: &FoldFits<'_>,
    people: usize,
) -> Vec<AmplitudeChange> {
    let folds = &fits.hierarchies;
    let n = folds.len() as f64;
    if folds.is_empty() {
        return Vec::new();
    }
    let mean = |value: &dyn Fn(&CohortAmplitudes) -> f64| folds.iter().map(value).sum::<f64>() / n;
    driven
        .iter()
        .enumerate()
        .map(|(index, found)| {
            let value = mean(&|fold| fold.mean[index]);
            // Each fold trains on all blocks but one; together they use the data once.
            let within = mean(&|fold| fold.within[index]) * (n - 1.0).max(1.0) / n;
            let half = 1.96 * (within + mean(&|fold| fold.between[index])).sqrt();
            AmplitudeChange {
                effect: found.effect.card().id.name().to_owned(),
                variants: fits.variants.iter().map(|of_fold| of_fold[index]).collect(),
                mean: WithInterval { value, lower: (value - half).max(0.0), upper: value + half },
                sd: mean(&|fold| fold.sd[index]),
                people: (0..people)
                    .map(|person| of_person(&fits.person_folds, person, index).unwrap_or(value))
                    .collect(),
            }
        })
        .collect()
}
