//! Which effect is missing: candidates against the background, one after the other.
//!
//! Every effect of the library is tested by held-out evidence on the linear model of the innovations
//! ([`design`](crate::design)), with the background profiled and random differences between days integrated
//! out. The effect that exceeds its threshold by most is named. The plant is then run again with it, and
//! the others are tested on what is left. Where nothing is named and a port varies by more than it does in
//! anybody, the answer is "unknown".

mod amplitude;
mod answer;
mod by_unit;
mod detection;
mod events;
mod held_out;
mod lag;
mod ports;
mod statistics;
mod thresholds;
mod unknown;
mod variance;

use effects::{Effect, Form, Modulation, Port};
use rayon::prelude::*;

use self::by_unit::{UnitEvidence, UnitSums, UnitTrial};
use self::events::EventEvidence;
use self::held_out::{Allowed, Folds, HeldOut, Trial, held_out};
use self::lag::LagEvidence;
use self::statistics::Person as Statistics;
use self::unknown::bins::Bins;
use self::unknown::{courses, unknown_events};
use self::variance::{Estimated, Spreads};
use crate::background::BackgroundKind;
use crate::calibration::Calibration;
use crate::config::DiagnosisConfig;
use crate::course::course;
use crate::design::{Column, Design, EventBank, HiddenEvents, design};
use crate::error::GapError;
use crate::event_bank::Beside;
use crate::how_far::PersonInput;
use crate::observations::Observations;

pub(crate) use self::detection::power;
pub use self::thresholds::{Evidence, Threshold, ThresholdStep, Thresholds};

/// Most effects that are named.
const MOST_EFFECTS: usize = 3;
/// How much more evidence an effect must show beside one that is named: what the first leaves unexplained, in form
/// or in people, looks like another effect.
const LATER: f64 = 1.5;
/// Correlation of two signatures, background profiled, above which the effects cannot be told apart.
const SAME: f64 = 0.8;
/// Nats within which a rival that clears its threshold is no worse an answer.
const RIVAL: f64 = 3.0;
/// Effects of the library that belong to the background of all others: every body sheds glucose when it is
/// high and defends itself when it is low, and plants differ in how.
const GUARDS: [&str; 2] = ["counter_regulation", "renal_threshold"];
/// Least factor that hidden events may leave of anything.
const LEAST_FACTOR: f64 = 0.05;
/// How much more evidence unknown events must show than a known effect: as a factor, and nats; courses at a port
/// the factor alone.
const UNKNOWN_FACTOR: f64 = 1.15;
const UNKNOWN_MARGIN: f64 = 5.0;
/// The same for events of the flux, as a factor: slow ones of no known kind are mistaken for meals, of whose evidence they
/// show nearly all or more, while of real meals' they show less.
const UNKNOWN_FLUX_FACTOR: f64 = 0.9;
/// Standard deviation of the amplitude of a guard.
const GUARD_SD: f64 = 0.5;

/// The answer to "which".
#[derive(Debug, Clone)]
pub struct Which {
    /// The effects named, in the order of conditioning.
    pub named: Vec<Named>,
    /// Every effect that was tried, at the first round.
    pub candidates: Vec<Candidate>,
    /// Evidence by port and scale, once the named effects are conditioned on.
    pub ports: Vec<PortCandidate>,
    /// Effects that no record could show.
    pub untried: Vec<usize>,
    /// People times days.
    pub person_days: f64,
    /// Number of effects in the library; places from there on stand for unknown events.
    pub known: usize,
    /// The port of each kind of unknown events.
    pub unknown: Vec<Port>,
    /// The evidence of the first round by name.
    pub evidence: Evidence,
    /// What the first round would have found of each driven effect.
    pub detectable: Vec<Detectable>,
}

/// The size of an effect that would have been found with 90 % probability.
#[derive(Debug, Clone)]
pub struct Detectable {
    /// Place in the library.
    pub effect: usize,
    /// Its amplitude.
    pub amplitude: f64,
    /// Each person's variant.
    pub variants: Vec<usize>,
}

/// An effect that was tried.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// Place in the library.
    pub effect: usize,
    /// Held-out evidence, nats.
    pub gain: f64,
    /// Evidence over the threshold, nats.
    pub excess: f64,
}

/// A port that was tried.
#[derive(Debug, Clone, Copy)]
pub struct PortCandidate {
    /// The port.
    pub port: Port,
    /// Evidence, nats.
    pub gain: f64,
    /// Evidence over the threshold, nats.
    pub excess: f64,
    /// Whether it varies within days rather than between them.
    pub within_days: bool,
}

/// An effect that was named.
#[derive(Debug, Clone)]
pub struct Named {
    /// Place in the library.
    pub effect: usize,
    /// Held-out evidence in the round in which it was named, nats.
    pub gain: f64,
    /// Evidence over the threshold, nats.
    pub excess: f64,
    /// Mean amplitude over people and its standard error.
    pub amplitude: (f64, f64),
    /// Each person's amplitude and its standard deviation.
    pub personal: Vec<(f64, f64)>,
    /// Each person's gain, nats.
    pub gains: Vec<f64>,
    /// Each person's variant.
    pub variants: Vec<usize>,
    /// Hidden events.
    pub events: Vec<NamedEvent>,
    /// Places in the library of effects that cannot be told from it.
    pub confusable: Vec<usize>,
    /// Candidates of its round.
    pub rivals: Vec<Candidate>,
}

/// A hidden event of an effect that was named.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NamedEvent {
    /// The person's place.
    pub person: usize,
    /// Step of its onset.
    pub onset: usize,
    /// Which of the effect's profiles it has.
    pub profile: usize,
    /// Its size relative to the published.
    pub size: f64,
}

impl Named {
    /// A course at a port that no known effect explains.
    fn course(found: &Candidate, candidates: &[Candidate], people: usize) -> Self {
        Self {
            effect: found.effect,
            gain: found.gain,
            excess: found.excess,
            amplitude: (1.0, 0.5),
            personal: vec![(1.0, 0.5); people],
            gains: vec![0.0; people],
            variants: vec![0; people],
            events: Vec::new(),
            confusable: Vec::new(),
            rivals: candidates.to_vec(),
        }
    }
}

/// One person in one round: the model with what has been named so far.
struct Subject {
    design: Design,
    statistics: Statistics,
    units: Vec<UnitSums>,
    events: Vec<EventBank>,
    /// The record in bins, until something is named.
    bins: Option<Bins>,
    /// Likelihoods of sensor lags; `None` once the lag is named.
    lags: Option<lag::Likelihoods>,
}

/// Names the effects that are missing.
///
/// # Errors
/// As [`design`].
pub fn which(
    people: &[PersonInput<'_>],
    library: &[Box<dyn Effect>],
    config: &DiagnosisConfig,
) -> Result<Which, GapError> {
    let thresholds = &config.thresholds;
    let known = library.len();
    let library: Vec<&dyn Effect> = library.iter().map(AsRef::as_ref).collect();
    let unknown = unknown_events();
    let library: Vec<&dyn Effect> =
        library.into_iter().chain(unknown.iter().map(AsRef::as_ref)).collect();
    let library = library.as_slice();
    let days: Vec<f64> = people
        .iter()
        .map(|p| p.observations.len() as f64 / physiology::STEPS_PER_DAY as f64)
        .collect();
    let person_days: f64 = days.iter().sum();
    let mut named: Vec<Named> = Vec::new();
    let mut first: Option<First> = None;
    loop {
        let round = Round::of(people, library, &named, config)?;
        let scores = round.scores(library, known, &named);
        let mut candidates: Vec<Candidate> = scores
            .iter()
            .map(|score| {
                let threshold = thresholds.of(library[score.effect].card().name);
                let needed =
                    if named.is_empty() { 1.0 } else { LATER } * threshold.over(person_days);
                let gain = score.gain();
                Candidate { effect: score.effect, gain, excess: gain - needed }
            })
            .collect();
        candidates.extend(round.courses().into_iter().enumerate().map(|(place, gain)| {
            let threshold = thresholds.of(&courses::name(place)).over(person_days);
            Candidate { effect: library.len() + place, gain, excess: gain - threshold }
        }));
        prefer_known(&mut candidates, known, library, &named);
        let untried: Vec<usize> = (0..known)
            .filter(|e| round.subjects.iter().all(|s| s.design.untried.contains(e)))
            .collect();
        let evidence = || {
            let of_candidate = |c: &Candidate| match library.get(c.effect) {
                Some(effect) => (effect.card().name.to_owned(), c.gain),
                None => (courses::name(c.effect - library.len()), c.gain),
            };
            let of_port =
                |p: ports::PortGain| (ports::threshold_name(p.port, p.within_days), p.gain);
            let gains = candidates.iter().map(of_candidate);
            let gains = gains.chain(ports::gains(&round.estimated).into_iter().map(of_port));
            Evidence { person_days, gains: gains.collect() }
        };
        let First { candidates: all, untried, evidence, detectable } = first
            .get_or_insert_with(|| First {
                candidates: candidates.clone(),
                untried,
                evidence: evidence(),
                detectable: detectable(&scores, library, known, thresholds, person_days),
            })
            .clone();
        let best = candidates.first().filter(|best| best.excess > 0.0);
        // A course at a port cannot be conditioned on.
        let course = best.filter(|best| best.effect >= library.len());
        if let Some(course) = course {
            named.push(Named::course(course, &candidates, people.len()));
        }
        let best = best.filter(|_| course.is_none() && named.len() < MOST_EFFECTS);
        let Some(best) = best else {
            let ports = round.ports(thresholds, person_days);
            let unknown = unknown.iter().map(|u| u.card().port).chain(courses::ports()).collect();
            return Ok(Which {
                named,
                candidates: all,
                ports,
                untried,
                person_days,
                known,
                unknown,
                evidence,
                detectable,
            });
        };
        let score = scores
            .iter()
            .find(|s| s.effect == best.effect)
            .expect("a candidate comes from a score");
        named.push(round.named(score, best, &candidates, library));
    }
}

/// Lowers the excess of unknown events beside a known effect that clears its threshold, and of guards once
/// something is named: what is left then shows in how glucose is shed and defended.
fn prefer_known(
    candidates: &mut [Candidate],
    known: usize,
    library: &[&dyn Effect],
    named: &[Named],
) {
    let explained = candidates.iter().any(|c| c.effect < known && c.excess > 0.0);
    for candidate in candidates.iter_mut() {
        if candidate.effect >= known {
            if explained {
                // Differences between days are integrated out of courses; other unknown events gain by them.
                let (margin, factor) = match library.get(candidate.effect) {
                    None => (0.0, UNKNOWN_FACTOR),
                    Some(kind) if kind.card().port == Port::GlucoseFlux => {
                        (0.0, UNKNOWN_FLUX_FACTOR)
                    }
                    Some(_) => (UNKNOWN_MARGIN, UNKNOWN_FACTOR),
                };
                candidate.excess = (candidate.excess - margin) / factor;
            }
        } else if !named.is_empty() && GUARDS.contains(&library[candidate.effect].card().name) {
            candidate.excess = candidate.excess.min(0.0);
        }
    }
    candidates.sort_by(|a, b| b.excess.total_cmp(&a.excess));
}

/// What is kept of the first round.
#[derive(Clone)]
struct First {
    candidates: Vec<Candidate>,
    untried: Vec<usize>,
    evidence: Evidence,
    detectable: Vec<Detectable>,
}

/// What a round would have found of each driven effect.
fn detectable(
    scores: &[Score],
    library: &[&dyn Effect],
    known: usize,
    thresholds: &Thresholds,
    person_days: f64,
) -> Vec<Detectable> {
    scores
        .iter()
        .filter(|score| score.effect < known)
        .filter_map(|score| {
            let ScoreOf::Driven(found) = &score.evidence else { return None };
            let threshold = thresholds.of(library[score.effect].card().name).over(person_days);
            Some(Detectable {
                effect: score.effect,
                amplitude: detection::amplitude(found.information, threshold)?,
                variants: found.variants.clone(),
            })
        })
        .collect()
}

/// Everything that is known in one round.
struct Round {
    subjects: Vec<Subject>,
    /// Each person's folds of days, random differences integrated out.
    marginal: Vec<Folds>,
    estimated: Estimated,
    /// Guards that are not themselves named, and named driven effects with their spread.
    guards: Vec<(usize, f64)>,
}

/// Evidence of one effect.
struct Score {
    effect: usize,
    evidence: ScoreOf,
}

enum ScoreOf {
    Driven(HeldOut),
    Events(EventEvidence),
    Lag(LagEvidence),
    /// With the spread at amplitude 1.
    Random(UnitEvidence, f64),
}

impl Score {
    fn gain(&self) -> f64 {
        match &self.evidence {
            ScoreOf::Driven(found) => found.gain(),
            ScoreOf::Events(found) => found.gain(),
            ScoreOf::Lag(found) => found.gain(),
            ScoreOf::Random(found, _) => found.gain(),
        }
    }
}

impl Round {
    fn of(
        people: &[PersonInput<'_>],
        library: &[&dyn Effect],
        named: &[Named],
        config: &DiagnosisConfig,
    ) -> Result<Self, GapError> {
        let mut subjects: Vec<Subject> = people
            .par_iter()
            .enumerate()
            .map(|(place, input)| {
                let about = (!named.is_empty())
                    .then(|| conditioned(input, place, library, named, config))
                    .transpose()?;
                let (observations, calibration) = about
                    .as_ref()
                    .map_or((input.observations, input.calibration), |a| (&a.0, &a.1));
                let mut design = design(input.person, observations, calibration, library)?;
                let lag = library.iter().position(|effect| effect.card().name == lag::NAME);
                let lags = lag
                    .filter(|lag| named.iter().all(|named| named.effect != *lag))
                    .map(|lag| {
                        let rule = &config.calibration;
                        let first = lag::first();
                        lag::likelihoods(observations, calibration, rule, library[lag], &first)
                    })
                    .transpose()?;
                let statistics = Statistics::of(&design);
                let of = |bank| UnitSums::of(&design, &statistics, bank);
                let units = design.random.iter().map(of).collect();
                let hidden = std::mem::take(&mut design.events);
                let backgrounds = Backgrounds::of(&design, &statistics, &hidden, library);
                let events = hidden.banks(|effect| backgrounds.beside(effect), &design.weights);
                let is_guard = |effect: usize| GUARDS.contains(&library[effect].card().name);
                let bins = named.is_empty().then(|| Bins::of(&design, is_guard));
                // The largest parts of a person, and summed up.
                design.signatures = Vec::new();
                (design.residuals, design.weights) = (Vec::new(), Vec::new());
                (design.days, design.hours) = (Vec::new(), Vec::new());
                Ok(Subject { design, statistics, units, events, bins, lags })
            })
            .collect::<Result<_, GapError>>()?;
        longer_lags(&mut subjects, people, library, named, config)?;
        let mut guards: Vec<(usize, f64)> = Vec::new();
        for (effect, entry) in library.iter().enumerate() {
            let known = named.iter().find(|n| n.effect == effect);
            if let Some(known) = known {
                guards.push((effect, (0.5 * known.amplitude.0).hypot(0.1)));
            } else if GUARDS.contains(&entry.card().name) {
                guards.push((effect, GUARD_SD));
            }
        }
        let mut round = Self { subjects, marginal: Vec::new(), estimated: none(), guards };
        // Constant directions, then spreads given them, twice: each needs the other.
        for _ in 0..2 {
            let spreads = round.estimated.spreads;
            round.marginal = round
                .subjects
                .par_iter()
                .map(|s| variance::marginal(&s.statistics, &spreads))
                .collect();
            let fixed: Vec<Vec<f64>> = (0..round.subjects.len())
                .into_par_iter()
                .map(|person| round.constant(person))
                .collect();
            let statistics: Vec<&Statistics> =
                round.subjects.iter().map(|s| &s.statistics).collect();
            round.estimated = variance::estimate(&statistics, &fixed, spreads);
        }
        let spreads = round.estimated.spreads;
        round.marginal = round
            .subjects
            .par_iter()
            .map(|s| variance::marginal(&s.statistics, &spreads))
            .collect();
        Ok(round)
    }

    /// What is allowed for when an effect is tested in a person; `None` for no effect in particular.
    fn allowed(&self, person: usize, tested: Option<(usize, &str)>) -> Vec<Allowed> {
        let columns = &self.subjects[person].statistics.columns;
        let mut guarded: Vec<usize> = Vec::new();
        columns
            .iter()
            .enumerate()
            .filter_map(|(column, stands_for)| match stands_for {
                Column::Background { name, prior_sd, kind } => {
                    let own = tested.is_some_and(|(_, effect)| rivals(effect, *kind, name));
                    (!own).then_some(Allowed { column, mean: 0.0, sd: *prior_sd })
                }
                Column::Effect { effect, .. } => {
                    // One variant of each guard: its others differ in sign or phase.
                    let (_, sd) = self.guards.iter().find(|(guard, _)| guard == effect)?;
                    let skip =
                        tested.is_some_and(|(own, _)| own == *effect) || guarded.contains(effect);
                    guarded.push(*effect);
                    (!skip).then_some(Allowed { column, mean: 0.0, sd: *sd })
                }
            })
            .collect()
    }

    /// A person's constant directions, one number a column.
    fn constant(&self, person: usize) -> Vec<f64> {
        let allowed = self.allowed(person, None);
        let columns = self.subjects[person].statistics.columns.len();
        let mut out = vec![0.0; columns];
        for (allowed, value) in
            allowed.iter().zip(held_out::background(&self.marginal[person], &allowed))
        {
            out[allowed.column] = value;
        }
        out
    }

    fn trials(&self, effect: usize, name: &str) -> Vec<Trial<'_>> {
        (0..self.subjects.len())
            .map(|person| Trial {
                folds: &self.marginal[person],
                allowed: self.allowed(person, Some((effect, name))),
                variants: self.variants(person, effect),
            })
            .collect()
    }

    fn variants(&self, person: usize, wanted: usize) -> Vec<usize> {
        let columns = &self.subjects[person].statistics.columns;
        (0..columns.len())
            .filter(|c| matches!(columns[*c], Column::Effect { effect, .. } if effect == wanted))
            .collect()
    }

    /// Evidence of every effect that is not named yet.
    fn scores(&self, library: &[&dyn Effect], known: usize, named: &[Named]) -> Vec<Score> {
        let days: Vec<usize> = self.subjects.iter().map(|s| s.statistics.days.len()).collect();
        let count = library.len();
        (0..count)
            .into_par_iter()
            .filter(|effect| named.iter().all(|n| n.effect != *effect))
            .filter_map(|effect| {
                if library[effect].card().name == lag::NAME {
                    let lags: Vec<&lag::Likelihoods> =
                        self.subjects.iter().filter_map(|s| s.lags.as_ref()).collect();
                    return Some(Score { effect, evidence: ScoreOf::Lag(lag::score(&lags)) });
                }
                let trials = self.trials(effect, library[effect].card().name);
                if trials.iter().any(|trial| !trial.variants.is_empty()) {
                    let evidence = ScoreOf::Driven(held_out(&trials));
                    return Some(Score { effect, evidence });
                }
                let banks: Vec<Option<&EventBank>> = self
                    .subjects
                    .iter()
                    .map(|s| s.events.iter().find(|bank| bank.effect == effect))
                    .collect();
                if banks.iter().any(Option::is_some) {
                    // Events of no known kind may go either way.
                    let evidence = events::score(&banks, &days, effect >= known);
                    return Some(Score { effect, evidence: ScoreOf::Events(evidence) });
                }
                let evidence = self.random(effect)?;
                Some(Score { effect, evidence })
            })
            .collect()
    }

    /// Evidence of every course at a port, as long as nothing is named.
    fn courses(&self) -> Vec<f64> {
        let mut people = Vec::with_capacity(self.subjects.len());
        for (place, subject) in self.subjects.iter().enumerate() {
            let Some(bins) = &subject.bins else { return Vec::new() };
            let sums = subject.statistics.folds.as_slice();
            people.push(courses::Subject { bins, sums, allowed: self.allowed(place, None) });
        }
        courses::gains(&people, &self.estimated.spreads.day)
    }

    /// Evidence that a factor is drawn anew for every unit.
    fn random(&self, effect: usize) -> Option<ScoreOf> {
        let banks = self.subjects.iter().flat_map(|s| &s.design.random);
        let bank = banks.into_iter().find(|bank| bank.effect == effect)?;
        let mut spreads = self.estimated.spreads;
        // The same factor by day of the record is not allowed for beside it.
        if let Some(place) = statistics::random_place(bank.field) {
            spreads.day[place] = 0.0;
        }
        let trials: Vec<UnitTrial<'_>> = self
            .subjects
            .iter()
            .enumerate()
            .map(|(person, subject)| UnitTrial {
                person: &subject.statistics,
                units: subject.units.iter().find(|units| units.effect == effect),
                allowed: self.allowed(person, None),
            })
            .collect();
        Some(ScoreOf::Random(by_unit::score(&trials, &spreads), bank.log_sd))
    }

    fn named(
        &self,
        score: &Score,
        best: &Candidate,
        candidates: &[Candidate],
        library: &[&dyn Effect],
    ) -> Named {
        let people = self.subjects.len();
        let mut confusable = self.same(score, library.len());
        for rival in candidates.iter().filter(|c| c.effect != best.effect && c.excess > 0.0) {
            if best.excess - rival.excess < RIVAL && !confusable.contains(&rival.effect) {
                confusable.push(rival.effect);
            }
        }
        let mut named = Named {
            effect: best.effect,
            gain: best.gain,
            excess: best.excess,
            amplitude: (1.0, 0.5),
            personal: vec![(1.0, 0.5); people],
            gains: vec![0.0; people],
            variants: vec![0; people],
            events: Vec::new(),
            confusable,
            rivals: candidates.to_vec(),
        };
        match &score.evidence {
            ScoreOf::Driven(found) => {
                named.amplitude = (found.hierarchy.mean, found.hierarchy.error);
                named.personal.clone_from(&found.personal);
                named.gains.clone_from(&found.gains);
                named.variants.clone_from(&found.variants);
            }
            ScoreOf::Lag(found) => {
                named.amplitude = found.mean;
                named.personal.clone_from(&found.personal);
                named.gains.clone_from(&found.gains);
            }
            ScoreOf::Events(found) => {
                let events = found.found.iter().map(|e| NamedEvent {
                    person: e.person,
                    onset: e.onset,
                    profile: e.profile,
                    size: e.size,
                });
                named.events = events.collect();
                named.gains.clone_from(&found.gains);
                named.amplitude = self.frequency(best.effect, found, 0..people);
                named.personal = (0..people)
                    .map(|person| self.frequency(best.effect, found, person..person + 1))
                    .collect();
            }
            ScoreOf::Random(found, log_sd) => {
                let (spread, error) = found.spread;
                named.amplitude = (spread / log_sd, error / log_sd);
                named.personal = vec![named.amplitude; people];
                named.gains.clone_from(&found.gains);
            }
        }
        named
    }

    /// Frequency of events of some people over the published one, and its standard error.
    fn frequency(
        &self,
        effect: usize,
        found: &EventEvidence,
        people: std::ops::Range<usize>,
    ) -> (f64, f64) {
        let published = self
            .subjects
            .iter()
            .find_map(|s| s.events.iter().find(|bank| bank.effect == effect))
            .map_or(1.0, |bank| bank.shape.per_day);
        let subjects = &self.subjects[people.clone()];
        let days: usize = subjects.iter().map(|s| s.statistics.days.len()).sum();
        let theirs = found.found.iter().filter(|event| people.contains(&event.person));
        // An empty sum is -0.
        let count = theirs.map(|e| e.probability * e.size.abs()).sum::<f64>() + 0.0;
        let expected = published * days as f64;
        (count / expected, (count.sqrt() + 1.0) / expected)
    }

    /// Driven effects, of `count`, whose signatures cannot be told from that of `score`.
    fn same(&self, score: &Score, count: usize) -> Vec<usize> {
        let ScoreOf::Driven(found) = &score.evidence else { return Vec::new() };
        let others: Vec<usize> = (0..count).filter(|e| *e != score.effect).collect();
        others
            .into_par_iter()
            .filter(|other| {
                let (mut cross, mut own, mut theirs) = (0.0, 0.0, 0.0);
                for person in 0..self.subjects.len() {
                    let mine = self.variants(person, score.effect);
                    let rival = self.variants(person, *other);
                    let Some(mine) = mine.get(found.variants[person]) else { continue };
                    let allowed: Vec<Allowed> = self
                        .allowed(person, None)
                        .into_iter()
                        .filter(|a| !rival.contains(&a.column))
                        .collect();
                    let best = rival
                        .iter()
                        .map(|r| held_out::profiled(&self.marginal[person], &allowed, *mine, *r))
                        .max_by(|a, b| a.correlation().total_cmp(&b.correlation()));
                    if let Some(best) = best {
                        cross += best.cross;
                        own += best.own;
                        theirs += best.other;
                    }
                }
                own > 0.0 && theirs > 0.0 && cross / (own * theirs).sqrt() > SAME
            })
            .collect()
    }

    fn ports(&self, thresholds: &Thresholds, person_days: f64) -> Vec<PortCandidate> {
        let mut ports: Vec<PortCandidate> = ports::gains(&self.estimated)
            .into_iter()
            .map(|found| {
                let name = ports::threshold_name(found.port, found.within_days);
                let threshold = thresholds.of(&name).over(person_days);
                PortCandidate {
                    port: found.port,
                    gain: found.gain,
                    excess: found.gain - threshold,
                    within_days: found.within_days,
                }
            })
            .collect();
        ports.sort_by(|a, b| b.excess.total_cmp(&a.excess));
        ports
    }
}

/// The constant directions of the background beside hidden events, which must not be made of what every meal or
/// every low of a person shows.
struct Backgrounds {
    each: Vec<Beside>,
    /// Effects and their places in `each`.
    places: Vec<(usize, usize)>,
}

impl Backgrounds {
    /// Directions that are what an effect itself would change are left out for it.
    /// Directions that are what an effect itself would change are left out for it. `hidden` are the design's.
    fn of(
        design: &Design,
        statistics: &Statistics,
        hidden: &HiddenEvents,
        library: &[&dyn Effect],
    ) -> Self {
        let mut sets: Vec<Vec<usize>> = Vec::new();
        let mut found = Self { each: Vec::new(), places: Vec::new() };
        for effect in hidden.effects() {
            let allowed = beside_columns(statistics, library[effect].card().name);
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
    fn beside(&self, effect: usize) -> &Beside {
        let place = self.places.iter().find(|(known, _)| *known == effect);
        &self.each[place.map_or(0, |(_, place)| *place)]
    }
}

/// The directions of the background that may stand beside a hidden event of `effect`.
fn beside_columns(statistics: &Statistics, effect: &str) -> Vec<Allowed> {
    let columns = statistics.columns.iter().enumerate();
    columns
        .filter_map(|(column, stands_for)| match stands_for {
            Column::Background { name, prior_sd, kind } if !rivals(effect, *kind, name) => {
                Some(Allowed { column, mean: 0.0, sd: *prior_sd })
            }
            _ => None,
        })
        .collect()
}

fn beside(design: &Design, statistics: &Statistics, allowed: &[Allowed]) -> Beside {
    let (fitted, factor) = held_out::fitted_to_all(&statistics.folds, allowed);
    let mut left = design.residuals.clone();
    for (allowed, value) in allowed.iter().zip(fitted) {
        for (rest, signature) in left.iter_mut().zip(&design.signatures[allowed.column]) {
            *rest += value * f64::from(*signature);
        }
    }
    let of = |allowed: &Allowed| design.signatures[allowed.column].as_slice();
    let signatures: Vec<&[f32]> = allowed.iter().map(of).collect();
    Beside::of(&left, &signatures, &factor)
}

/// Whether a direction of the background is what an effect itself would change.
fn rivals(effect: &str, kind: BackgroundKind, name: &str) -> bool {
    match effect {
        "dawn" | "circadian_sensitivity" => kind == BackgroundKind::Clock,
        "renal_threshold" => name == "shedding",
        "counter_regulation" | "unlogged_rescue_carbs" => name == "defence",
        _ => false,
    }
}

fn none() -> Estimated {
    let zero = variance::SpreadEvidence { gain: 0.0, beyond_usual: 0.0, spread: 0.0 };
    Estimated {
        spreads: Spreads {
            day: [0.0; statistics::RANDOM.len()],
            block: [0.0; statistics::RANDOM.len()],
        },
        day: [zero; statistics::RANDOM.len()],
        block: [zero; statistics::RANDOM.len()],
    }
}

/// Runs the longer lags for everybody where the first ones call for it.
fn longer_lags(
    subjects: &mut [Subject],
    people: &[PersonInput<'_>],
    library: &[&dyn Effect],
    named: &[Named],
    config: &DiagnosisConfig,
) -> Result<(), GapError> {
    let Some(lag) = library.iter().position(|effect| effect.card().name == lag::NAME) else {
        return Ok(());
    };
    let known: Vec<&lag::Likelihoods> = subjects.iter().filter_map(|s| s.lags.as_ref()).collect();
    if known.is_empty() || !lag::calls_for_longer(&known) {
        return Ok(());
    }
    subjects.par_iter_mut().zip(people).enumerate().try_for_each(|(place, (subject, input))| {
        let Some(lags) = &mut subject.lags else { return Ok(()) };
        let about = (!named.is_empty())
            .then(|| conditioned(input, place, library, named, config))
            .transpose()?;
        let (observations, calibration) = about
            .as_ref()
            .map_or((input.observations, input.calibration), |about| (&about.0, &about.1));
        let rule = &config.calibration;
        lags.extend(lag::likelihoods(observations, calibration, rule, library[lag], lag::rest())?);
        Ok(())
    })
}

/// A person's record under the effects that have been named, and the calibrated filter run on it.
fn conditioned(
    input: &PersonInput<'_>,
    place: usize,
    library: &[&dyn Effect],
    named: &[Named],
    config: &DiagnosisConfig,
) -> Result<(Observations, Calibration), GapError> {
    let calibration = input.calibration;
    let glucose = calibration.glucose();
    let course = course(input.person, glucose);
    let mut modulations = vec![Modulation::NEUTRAL; course.len()];
    for named in named {
        let effect = &library[named.effect];
        match effect.form(&course) {
            Some(Form::Driven) => {
                let (amplitude, _) = named.personal[place];
                effect.modulate(named.variants[place], amplitude, &course, &mut modulations);
            }
            Some(Form::Events(shape)) => {
                for event in named.events.iter().filter(|event| event.person == place) {
                    let profile = &shape.profiles[event.profile];
                    for (modulation, add) in modulations[event.onset..].iter_mut().zip(profile) {
                        modulation[shape.field] += event.size * add;
                        if shape.field.neutral() == 1.0 {
                            modulation[shape.field] = modulation[shape.field].max(LEAST_FACTOR);
                        }
                    }
                }
            }
            _ => {}
        }
    }
    let observations = Observations { modulations, ..input.observations.clone() };
    let about = calibration.about(&observations, &config.calibration)?;
    Ok((observations, about))
}
