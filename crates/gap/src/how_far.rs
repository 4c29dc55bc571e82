//! How far the effects found go: held-out error before and after.
//!
//! "Before" is the plant recalibrated on training days; "after" is the same plant with calibration
//! and amplitudes refitted jointly on the same days, from the same start, with the same number of
//! Gauss-Newton iterations. Both are judged by free runs that start on the days held out. Training never
//! sees a reading of a day held out, and a run never sees a reading after its start: what drives an
//! effect is either on the log (meals, heart rate, sleep, the clock, set changes), which counts as
//! input, or the run's own glucose.
//!
//! Hidden events and random factors cannot be predicted. They are reconstructed from the readings of the
//! days held out, and stand in rows of their own.

mod drivers;
mod floor;
mod folds;
mod hidden;
mod hierarchy;
mod judge;
mod modulated_plant;
mod reconstruction;
mod refit;
#[cfg(test)]
mod sample;
mod shrinkage;
mod summary;

use cohort::Person;
use effects::{Course, Effect, Form};
use physiology::Plant;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use self::drivers::Driver;
use self::folds::Folds;
use self::hidden::Hidden;
use self::hierarchy::{Hierarchy, empirical_bayes};
use self::judge::{Candidate, Day, Floor, HeldOut};
use self::reconstruction::{Linear, Strength, Tally};
use self::refit::{Equations, Fit, Training};
use self::summary::{Pair, Summary};
use crate::calibration::Calibration;
use crate::config::DiagnosisConfig;
use crate::course::course;
use crate::diagnosis::{AmplitudeChange, HowFar, WithInterval};
use crate::error::GapError;
use crate::observations::Observations;

pub use modulated_plant::{ModulatedPlant, ModulatedState};
pub use shrinkage::{Shrinkage, shrinkage};

/// A person, as the diagnosis knows her.
#[derive(Debug, Clone, Copy)]
pub struct PersonInput<'a> {
    /// Her record.
    pub person: &'a Person,
    /// Her readings and inputs, without modulations.
    pub observations: &'a Observations,
    /// Her calibration on the whole record: where every fit starts.
    pub calibration: &'a Calibration,
}

/// An effect that was found.
#[derive(Debug, Clone)]
pub struct NamedEffect<'a> {
    /// The effect.
    pub effect: &'a dyn Effect,
    /// Its variant.
    pub variant: usize,
    /// Its amplitude: where the fits on training days start, for hidden events and random factors their
    /// strength.
    pub amplitude: Amplitude,
}

/// How strong an effect was found to be; 1 is the published size.
#[derive(Debug, Clone, PartialEq)]
pub enum Amplitude {
    /// One value a person, in their order.
    OfPeople(Vec<f64>),
    /// The same distribution for everybody.
    Population {
        /// Mean.
        mean: f64,
        /// Standard deviation between people.
        sd: f64,
    },
}

impl Amplitude {
    /// The amplitude of one person.
    #[must_use]
    pub fn of(&self, person: usize) -> f64 {
        match self {
            Self::OfPeople(values) => values.get(person).copied().unwrap_or(0.0),
            Self::Population { mean, .. } => *mean,
        }
    }
}

/// How the held-out comparison is made.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HowFarRule {
    /// Folds of contiguous days; every whole day is held out in one of them.
    pub folds: usize,
    /// Gauss-Newton iterations of the fits before and after alike.
    pub iterations: usize,
    /// Steps from one start of a free run to the next.
    pub every: usize,
    /// People below whose number days are resampled as well as people.
    pub few_people: usize,
    /// Smallest share of readings in a day whose outcomes are compared.
    pub least_readings: f64,
    /// Error above the floor below which no share of it is given, mg/dL.
    pub least_gap: f64,
    /// Level of each one-sided test of equivalence.
    pub alpha: f64,
}

impl HowFarRule {
    /// The values in use: two folds, three iterations, a start every two hours, days resampled below
    /// five people, 70 % of a day's readings (Battelino et al., Diabetes Care 2019;42:1593), 0.5 mg/dL.
    #[must_use]
    pub const fn working() -> Self {
        Self {
            folds: 2,
            iterations: 3,
            every: 24,
            few_people: 5,
            least_readings: 0.7,
            least_gap: 0.5,
            alpha: 0.05,
        }
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
    people: &[PersonInput<'_>],
    found: &[NamedEffect<'_>],
    config: &DiagnosisConfig,
    rule: &HowFarRule,
    seed: u64,
) -> Result<HowFar, GapError> {
    if people.is_empty() {
        return Err(GapError::EmptyCohort);
    }
    let mut subjects: Vec<Subject<'_>> =
        people.par_iter().map(|input| Subject::new(input, found, rule)).collect();
    let is_driven = |place: &usize| subjects.iter().any(|s| s.forms[*place] == Some(Form::Driven));
    let places: Vec<usize> = (0..found.len()).filter(is_driven).collect();
    let driven: Vec<&NamedEffect<'_>> = places.iter().map(|place| &found[*place]).collect();
    for (place, subject) in subjects.iter_mut().enumerate() {
        subject.drive(place, &driven);
    }
    let is_hidden = |place: &usize| {
        subjects.iter().any(|subject| {
            matches!(subject.forms[*place], Some(Form::Events(_) | Form::Random { .. }))
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
    let (units, hierarchies) = fitted(&subjects, &driven, config, rule);
    let strengths = strengths(&subjects, &units, found, &hidden, config, rule, &mut notes);
    let judged: Vec<Result<Judged, GapError>> = units
        .par_iter()
        .map(|unit| unit.judged(&subjects[unit.subject], &hidden, &strengths, config, rule))
        .collect();
    let (predicted, reconstructed) = gathered(&subjects, judged, &mut notes);
    let summary = Summary { people: &predicted, config, rule, seed };
    let mut changed = HowFar {
        people: summary.people(if hidden.is_empty() { &[] } else { &reconstructed }),
        notes,
        ..HowFar::default()
    };
    if !driven.is_empty() {
        changed.horizons = summary.horizons(false)?;
        changed.outcomes = summary.outcomes()?;
        changed.innovations = summary.innovations()?;
        changed.amplitudes = amplitudes(&driven, &hierarchies);
    }
    if !hidden.is_empty() {
        let summary = Summary { people: &reconstructed, config, rule, seed };
        changed.horizons.extend(summary.horizons(true)?);
        let names: Vec<&str> = hidden.iter().map(|k| found[*k].effect.card().name).collect();
        changed.notes.push(format!(
            "{} cannot be predicted: rows marked as reconstructed use the readings of the days held out",
            names.join(", ")
        ));
    }
    Ok(changed)
}

/// A person with what her drivers look at.
struct Subject<'a> {
    input: &'a PersonInput<'a>,
    course: Course,
    folds: Folds,
    /// How each effect found acts for her.
    forms: Vec<Option<Form>>,
    /// The effects that have a driver in somebody's record, and the amplitudes at which fits start.
    drivers: Vec<Driver<'a>>,
    starts: Vec<f64>,
}

impl<'a> Subject<'a> {
    fn new(input: &'a PersonInput<'a>, found: &[NamedEffect<'_>], rule: &HowFarRule) -> Self {
        let plant = input.calibration.model.plant();
        let states = &input.calibration.filtered.states;
        let course =
            course(input.person, states.iter().map(|s| plant.glucose(&s.body).0).collect());
        let folds = Folds::new(&course.day, rule.folds);
        let forms = found.iter().map(|f| f.effect.form(&course)).collect();
        Self { input, course, folds, forms, drivers: Vec::new(), starts: Vec::new() }
    }

    /// Gives the person the drivers of the effects that have one in somebody's record.
    fn drive(&mut self, place: usize, driven: &[&NamedEffect<'a>]) {
        for found in driven {
            self.drivers.push(Driver::new(found.effect, found.variant, &self.course));
            let largest = found.effect.card().prior.largest;
            self.starts.push(found.amplitude.of(place).clamp(0.0, largest));
        }
    }
}

/// A person in one fold.
struct Unit<'a> {
    subject: usize,
    fold: usize,
    folds: &'a Folds,
    training: Training<'a>,
    before: Fit,
    after: Fit,
    failed: Option<GapError>,
}

impl Unit<'_> {
    /// One iteration of the fit without effects.
    fn iterate_before(&mut self, config: &DiagnosisConfig) {
        match self.training.equations(&mut self.before, config) {
            Ok(equations) => {
                equations.step(&mut self.before, Vec::new(), config.calibration.bound);
            }
            Err(error) => self.failed = Some(error),
        }
    }

    /// The equations of the fit with effects; `None` for a unit that has failed.
    fn equations_after(&mut self, config: &DiagnosisConfig) -> Option<Equations> {
        if self.failed.is_some() {
            return None;
        }
        match self.training.equations(&mut self.after, config) {
            Ok(equations) => Some(equations),
            Err(error) => {
                self.failed = Some(error);
                None
            }
        }
    }

    /// What training days say about each hidden effect.
    ///
    /// # Errors
    /// As [`filter`](crate::filter::filter()).
    fn tallies(
        &self,
        subject: &Subject<'_>,
        hidden: &[(usize, Strength)],
        config: &DiagnosisConfig,
    ) -> Result<Vec<Tally>, GapError> {
        let mut tallies = vec![Tally::default(); hidden.len()];
        for range in &self.training.stretches {
            let mut linear = self.linear(range, config)?;
            for (tally, (place, strength)) in tallies.iter_mut().zip(hidden) {
                if let Some(form) = &subject.forms[*place] {
                    let course = &self.training.course;
                    let (_, counted) = linear.reconstruct(form, *strength, range, course)?;
                    *tally = tally.plus(counted);
                }
            }
        }
        Ok(tallies)
    }

    /// The innovations of a stretch under the fit with effects.
    fn linear(
        &self,
        range: &std::ops::Range<usize>,
        config: &DiagnosisConfig,
    ) -> Result<Linear<'_>, GapError> {
        let training = &self.training;
        let modulations = drivers::modulations(
            &training.drivers,
            &self.after.amplitudes,
            &training.course,
            |_| true,
        );
        Linear::new(training.observations, range, &modulations, &self.after, config)
    }

    /// The unit's days, judged with both fits, and with hidden changes reconstructed where there are.
    fn judged(
        &self,
        subject: &Subject<'_>,
        hidden: &[usize],
        strengths: &[Vec<Strength>],
        config: &DiagnosisConfig,
        rule: &HowFarRule,
    ) -> Result<Judged, GapError> {
        if let Some(error) = &self.failed {
            return Err(error.clone());
        }
        let mut judged =
            Judged { subject: self.subject, predicted: Vec::new(), reconstructed: Vec::new() };
        let Some(block) = self.folds.held_out(self.fold) else { return Ok(judged) };
        let held_out = HeldOut {
            observations: self.training.observations,
            whole_days: &self.folds.whole_days(&block),
            block: &block,
            config,
            rule,
        };
        let mut course = self.training.course.clone();
        let before = Candidate { fit: &self.before, drivers: &[], hidden: None };
        let before = held_out.judge(&before, &mut course, Floor::Skip)?;
        let after = if self.training.drivers.is_empty() {
            before.clone()
        } else {
            let drivers = &self.training.drivers;
            let candidate = Candidate { fit: &self.after, drivers, hidden: None };
            held_out.judge(&candidate, &mut course, Floor::Take)?
        };
        if !hidden.is_empty() {
            let mut linear = self.linear(&held_out.seen(), config)?;
            let mut changes = Hidden::default();
            for (place, strength) in hidden.iter().zip(&strengths[self.fold]) {
                if let Some(form) = &subject.forms[*place] {
                    changes.extend(linear.reconstruct(form, *strength, &block, &course)?.0);
                }
            }
            let drivers = &self.training.drivers;
            let candidate = Candidate { fit: &self.after, drivers, hidden: Some(&changes) };
            let known = held_out.judge(&candidate, &mut course, Floor::Skip)?;
            judged.reconstructed = pairs(after.clone(), known);
        }
        judged.predicted = pairs(before, after);
        Ok(judged)
    }
}

/// A person's days of one fold, by number.
struct Judged {
    subject: usize,
    predicted: Vec<(usize, Pair)>,
    reconstructed: Vec<(usize, Pair)>,
}

fn pairs(before: Vec<(usize, Day)>, after: Vec<(usize, Day)>) -> Vec<(usize, Pair)> {
    let pair =
        |((day, before), (_, after)): ((usize, Day), (usize, Day))| (day, Pair { before, after });
    before.into_iter().zip(after).map(pair).collect()
}

/// How frequent and strong each hidden effect is in the training days of each fold, over all people: one
/// list a fold. Who cannot be counted is left to a note.
fn strengths(
    subjects: &[Subject<'_>],
    units: &[Unit<'_>],
    found: &[NamedEffect<'_>],
    hidden: &[usize],
    config: &DiagnosisConfig,
    rule: &HowFarRule,
    notes: &mut Vec<String>,
) -> Vec<Vec<Strength>> {
    let form_of = |place: usize| subjects.iter().find_map(|s| s.forms[place].as_ref());
    let first: Vec<(usize, Strength)> = hidden
        .iter()
        .filter_map(|place| {
            let people = subjects.len() as f64;
            let amplitude = &found[*place].amplitude;
            let mean = (0..subjects.len()).map(|i| amplitude.of(i)).sum::<f64>() / people;
            Some((*place, reconstruction::published(form_of(*place)?, mean)?))
        })
        .collect();
    let tallies: Vec<Option<Vec<Tally>>> = units
        .par_iter()
        .map(|unit| unit.tallies(&subjects[unit.subject], &first, config).ok())
        .collect();
    let lost = tallies.iter().filter(|tally| tally.is_none()).count();
    if lost > 0 {
        notes.push(format!("hidden events of {lost} fits could not be counted"));
    }
    (0..rule.folds)
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

/// Fits before and after for every person and fold, and the cohort's amplitudes in each fold.
fn fitted<'a>(
    subjects: &'a [Subject<'a>],
    driven: &[&NamedEffect<'_>],
    config: &DiagnosisConfig,
    rule: &HowFarRule,
) -> (Vec<Unit<'a>>, Vec<Hierarchy>) {
    let folds = 0..rule.folds;
    let mut units: Vec<Unit<'_>> = folds
        .clone()
        .flat_map(|fold| subjects.iter().enumerate().map(move |(place, s)| (fold, place, s)))
        .filter(|(fold, _, subject)| subject.folds.held_out(*fold).is_some())
        .map(|(fold, place, subject)| Unit::new(place, fold, subject))
        .collect();
    let priors: Vec<_> = driven.iter().map(|found| found.effect.card().prior).collect();
    units.par_iter_mut().for_each(|unit| {
        for _ in 0..rule.iterations {
            if unit.failed.is_none() {
                unit.iterate_before(config);
            }
        }
    });
    let mut hierarchies: Vec<Hierarchy> = Vec::new();
    if driven.is_empty() {
        units.iter_mut().for_each(|unit| unit.after = unit.before.clone());
        return (units, hierarchies);
    }
    for _ in 0..rule.iterations {
        let equations: Vec<Option<Equations>> =
            units.par_iter_mut().map(|unit| unit.equations_after(config)).collect();
        hierarchies.clear();
        for fold in folds.clone() {
            let members: Vec<usize> = (0..units.len())
                .filter(|k| units[*k].fold == fold && equations[*k].is_some())
                .collect();
            let known: Vec<&Equations> =
                members.iter().filter_map(|k| equations[*k].as_ref()).collect();
            if known.is_empty() {
                continue;
            }
            let inflation = inflation(&known, priors.len());
            let evidence: Vec<_> = known.iter().map(|e| e.evidence(&inflation)).collect();
            let hierarchy = empirical_bayes(&evidence, &priors);
            for ((member, equations), amplitudes) in
                members.iter().zip(&known).zip(&hierarchy.people)
            {
                let bound = config.calibration.bound;
                equations.step(&mut units[*member].after, amplitudes.clone(), bound);
            }
            hierarchies.push(hierarchy);
        }
    }
    (units, hierarchies)
}

impl<'a> Unit<'a> {
    fn new(place: usize, fold: usize, subject: &'a Subject<'a>) -> Self {
        let calibration = subject.input.calibration;
        let fit = Fit {
            factors: calibration.factors,
            amplitudes: Vec::new(),
            autoregression: calibration.autoregression,
            scale: calibration.scale.max(1.0),
        };
        Self {
            subject: place,
            fold,
            folds: &subject.folds,
            training: Training {
                observations: subject.input.observations,
                stretches: subject.folds.training(fold),
                drivers: subject.drivers.clone(),
                course: subject.course.clone(),
            },
            after: Fit { amplitudes: subject.starts.clone(), ..fit.clone() },
            before: fit,
            failed: None,
        }
    }
}

/// By how much the information on each amplitude is overstated because steps of a day are not independent:
/// the squared scores of days over the information, over all people together.
fn inflation(equations: &[&Equations], effects: usize) -> Vec<f64> {
    (0..effects)
        .map(|effect| {
            let by_day: f64 = equations.iter().map(|e| e.by_day[effect]).sum();
            let by_step: f64 = equations.iter().map(|e| e.information[(effect, effect)]).sum();
            if by_step > 0.0 { (by_day / by_step).max(1.0) } else { 1.0 }
        })
        .collect()
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

/// Amplitudes over the folds.
fn amplitudes(driven: &[&NamedEffect<'_>], folds: &[Hierarchy]) -> Vec<AmplitudeChange> {
    let n = folds.len() as f64;
    if folds.is_empty() {
        return Vec::new();
    }
    let mean = |value: &dyn Fn(&Hierarchy) -> f64| folds.iter().map(value).sum::<f64>() / n;
    driven
        .iter()
        .enumerate()
        .map(|(place, found)| {
            let value = mean(&|fold| fold.mean[place]);
            // Each fold trains on all blocks but one; together they use the data once.
            let within = mean(&|fold| fold.within[place]) * (n - 1.0).max(1.0) / n;
            let half = 1.96 * (within + mean(&|fold| fold.between[place])).sqrt();
            let count = folds.iter().map(|fold| fold.people.len()).max().unwrap_or(0);
            AmplitudeChange {
                effect: found.effect.card().name.to_owned(),
                variant: found.variant,
                mean: WithInterval { value, lower: (value - half).max(0.0), upper: value + half },
                sd: mean(&|fold| fold.sd[place]),
                people: (0..count)
                    .map(|person| mean(&|fold| fold.people.get(person).map_or(0.0, |a| a[place])))
                    .collect(),
            }
        })
        .collect()
}
