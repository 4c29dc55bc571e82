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
mod hierarchy;
mod judge;
mod modulated_plant;
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
use self::hierarchy::{Hierarchy, empirical_bayes};
use self::judge::{Candidate, Day, Floor, HeldOut};
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
    let mut notes = Vec::new();
    if driven.is_empty() {
        return Ok(HowFar { notes, ..HowFar::default() });
    }
    let (units, hierarchies) = fitted(&subjects, &driven, config, rule);
    let judged: Vec<Result<(usize, Vec<(usize, Pair)>), GapError>> =
        units.into_par_iter().map(|unit| unit.judged(config, rule)).collect();
    let days = gathered(&subjects, judged, &mut notes);
    let summary = Summary { people: &days, config, rule, seed };
    Ok(HowFar {
        horizons: summary.horizons(false)?,
        outcomes: summary.outcomes()?,
        amplitudes: amplitudes(&driven, &hierarchies),
        innovations: summary.innovations()?,
        people: summary.people(),
        notes,
    })
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

    /// The unit's days, judged with both fits, and whose they are.
    fn judged(
        self,
        config: &DiagnosisConfig,
        rule: &HowFarRule,
    ) -> Result<(usize, Vec<(usize, Pair)>), GapError> {
        if let Some(error) = self.failed {
            return Err(error);
        }
        let Some(block) = self.folds.held_out(self.fold) else {
            return Ok((self.subject, Vec::new()));
        };
        let held_out = HeldOut {
            observations: self.training.observations,
            whole_days: &self.folds.whole_days(&block),
            block: &block,
            config,
            rule,
        };
        let mut course = self.training.course;
        let before = Candidate { fit: &self.before, drivers: &[] };
        let before = held_out.judge(&before, &mut course, Floor::Skip)?;
        let after = Candidate { fit: &self.after, drivers: &self.training.drivers };
        let after = held_out.judge(&after, &mut course, Floor::Take)?;
        let pair = |((day, before), (_, after)): ((usize, Day), (usize, Day))| {
            (day, Pair { before, after })
        };
        Ok((self.subject, before.into_iter().zip(after).map(pair).collect()))
    }
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

/// Everyone's days in their order; who fails is named.
fn gathered(
    subjects: &[Subject<'_>],
    judged: Vec<Result<(usize, Vec<(usize, Pair)>), GapError>>,
    notes: &mut Vec<String>,
) -> Vec<(String, Vec<Pair>)> {
    let mut people: Vec<(String, Vec<(usize, Pair)>)> =
        subjects.iter().map(|s| (s.input.person.id.clone(), Vec::new())).collect();
    for result in judged {
        match result {
            Ok((place, days)) => people[place].1.extend(days),
            Err(error) => notes.push(format!("some days could not be judged: {error}")),
        }
    }
    let in_order = |(person, mut days): (String, Vec<(usize, Pair)>)| {
        days.sort_by_key(|(day, _)| *day);
        (person, days.into_iter().map(|(_, pair)| pair).collect())
    };
    people.into_iter().map(in_order).collect()
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
