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
mod hierarchy;
mod judge;
mod person_fold;
mod prepared_steps;
mod reconstruction;
mod refit;
#[cfg(test)]
mod sample;
mod shrinkage;
mod small_sample;
mod summary;

use effects::{Course, Effect, Form};
use rayon::prelude::*;
use stats::Bootstrap;

use self::drivers::Driver;
use self::fitting::{FoldFits, fitted};
use self::folds::{FOLDS, Folds};
use self::hierarchy::CohortAmplitudes;
use self::summary::{Pair, Summary};
use crate::calibrated_person::CalibratedPerson;
use crate::config::DiagnosisConfig;
use crate::error::GapError;
use contract::WithInterval;
use contract::diagnosis::{AmplitudeChange, HowFar};

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

/// A person as every fold needs her, with what her drivers look at.
struct Subject<'a> {
    index: usize,
    input: &'a CalibratedPerson<'a>,
    course: Course,
    folds: Folds,
    /// How each effect found acts for her.
    forms: Vec<Option<Form>>,
    /// The effects that have a driver in somebody's record, and the amplitudes at which fits start.
    drivers: Vec<Driver<'a>>,
    starts: Vec<f64>,
}

impl<'a> Subject<'a> {
    fn new(index: usize, input: &'a CalibratedPerson<'a>, found: &[NamedEffect<'_>]) -> Self {
        let course = input.course();
        let folds = Folds::new(&course.day, FOLDS);
        let forms = found.iter().map(|f| f.effect.form(&course)).collect();
        Self { index, input, course, folds, forms, drivers: Vec::new(), starts: Vec::new() }
    }

    /// Gives the person the drivers of the effects that have one in somebody's record.
    fn drive(&mut self, driven: &[&NamedEffect<'a>]) {
        for found in driven {
            self.drivers.push(Driver::new(found.effect, found.variant, &self.course));
            let largest = found.effect.card().prior.largest;
            self.starts.push(found.amplitude(self.index).clamp(0.0, largest));
        }
    }
}

/// What adding the effects found changes on days held out.
///
/// `people` is everyone who was diagnosed and `found` the effects in the order in which they were found. `config` says how
/// fits before and after are made, how free runs are started and scored, and how people and days are resampled.
/// People are fitted in parallel; the result depends on `seed` (resampling) and not on the number of
/// threads. A person whose record cannot be split or whose fit fails is left out with a note.
///
/// # Errors
/// [`GapError::EmptyCohort`]; [`GapError::Statistics`].
pub fn how_far(
    people: &[CalibratedPerson<'_>],
    found: &[NamedEffect<'_>],
    config: &DiagnosisConfig,
    seed: u64,
) -> Result<HowFar, GapError> {
    if people.is_empty() {
        return Err(GapError::EmptyCohort);
    }
    let everyone = people.par_iter().enumerate();
    let mut subjects: Vec<Subject<'_>> =
        everyone.map(|(index, input)| Subject::new(index, input, found)).collect();
    let of_form = |wanted: fn(&Form) -> bool| -> Vec<usize> {
        let acts = |s: &Subject<'_>, index: usize| s.forms[index].as_ref().is_some_and(wanted);
        (0..found.len()).filter(|index| subjects.iter().any(|s| acts(s, *index))).collect()
    };
    let hidden = of_form(|form| *form != Form::Driven);
    let driven = of_form(|form| *form == Form::Driven);
    let driven: Vec<&NamedEffect<'_>> = driven.iter().map(|index| &found[*index]).collect();
    for subject in &mut subjects {
        subject.drive(&driven);
    }
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
    let fits = fitted(&subjects, &driven, &config.calibration);
    let strengths = fits.strengths(&subjects, found, &hidden, &config.calibration, &mut notes);
    let judged: Vec<_> =
        fits.person_folds.par_iter().map(|fold| fold.judged(&strengths, config)).collect();
    let nobody = subjects.iter().map(|subject| (subject.input.person.id.clone(), Vec::new()));
    let mut predicted: Vec<(String, Vec<Pair>)> = nobody.collect();
    let mut reconstructed = predicted.clone();
    // Folds come in the order of their days.
    for (person_fold, judged) in fits.person_folds.iter().zip(judged) {
        match judged {
            Ok((days, known)) => {
                predicted[person_fold.subject.index].1.extend(days);
                reconstructed[person_fold.subject.index].1.extend(known);
            }
            Err(error) => notes.push(format!("some days could not be judged: {error}")),
        }
    }
    let plan = Bootstrap { replicates: config.localisation.replicates, level: 0.95, seed };
    let summary = Summary { people: &predicted, config, plan };
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
        let summary = Summary { people: &reconstructed, ..summary };
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
    let people = subjects.len();
    let unsignalled = subjects.iter().filter(|s| !s.drivers[index].signalled).count();
    let missing = (unsignalled > 0)
        .then(|| format!("{name}: {unsignalled} of {people} records do not signal it"));
    let reads_glucose = subjects.iter().any(|s| s.drivers[index].reads_glucose);
    let own = reads_glucose
        .then(|| format!("{name} depends on glucose: free runs drive it with their own"));
    missing.into_iter().chain(own).collect()
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
    let change = |(index, found): (usize, &&NamedEffect<'_>)| {
        let value = mean(&|fold| fold.mean[index]);
        // Each fold trains on all blocks but one; together they use the data once.
        let within = mean(&|fold| fold.within[index]) * (n - 1.0).max(1.0) / n;
        let half = 1.96 * (within + mean(&|fold| fold.between[index])).sqrt();
        let of_person = |person: usize| {
            let own = fits.person_folds.iter().filter(|fold| fold.subject.index == person);
            let own: Vec<f64> = own.map(|fold| fold.after.amplitudes[index]).collect();
            if own.is_empty() { value } else { own.iter().sum::<f64>() / own.len() as f64 }
        };
        AmplitudeChange {
            effect: found.effect.card().id.name().to_owned(),
            variants: fits.variants.iter().map(|of_fold| of_fold[index]).collect(),
            mean: WithInterval { value, lower: (value - half).max(0.0), upper: value + half },
            sd: mean(&|fold| fold.sd[index]),
            people: (0..people).map(of_person).collect(),
        }
    };
    driven.iter().enumerate().map(change).collect()
}
