//! One round: everybody's linear model with what has been named so far, and the evidence of every effect.

use effects::Effect;
use rayon::prelude::*;

use super::backgrounds::{Backgrounds, rivals};
use super::by_unit::{UnitEvidence, UnitSums};
use super::conditioned::{conditioned, longer_lags};
use super::events::EventEvidence;
use super::held_out::{self, Allowed, Folds, HeldOut, Trial};
use super::lag::{self, LagEvidence};
use super::statistics::{self, Person as Statistics};
use super::unknown::bins::Bins;
use super::variance::{self, Estimated, Spreads};
use super::{GUARDS, Named};
use crate::config::DiagnosisConfig;
use crate::design::{Column, Design, EventBank, design};
use crate::error::GapError;
use crate::how_far::PersonInput;

/// Standard deviation of the amplitude of a guard.
pub(super) const GUARD_SD: f64 = 0.5;

/// One person in one round: the model with what has been named so far.
pub(super) struct Subject {
    pub(super) design: Design,
    pub(super) statistics: Statistics,
    pub(super) units: Vec<UnitSums>,
    pub(super) events: Vec<EventBank>,
    /// The record in bins, until something is named.
    pub(super) bins: Option<Bins>,
    /// Likelihoods of sensor lags; `None` once the lag is named.
    pub(super) lags: Option<lag::Likelihoods>,
}

/// Everything that is known in one round.
pub(super) struct Round {
    pub(super) subjects: Vec<Subject>,
    /// Each person's folds of days, random differences integrated out.
    pub(super) marginal: Vec<Folds>,
    pub(super) estimated: Estimated,
    /// Guards that are not themselves named, and named driven effects with their spread.
    pub(super) guards: Vec<(usize, f64)>,
}

/// Evidence of one effect.
pub(super) struct Score {
    pub(super) effect: usize,
    pub(super) evidence: ScoreOf,
}

pub(super) enum ScoreOf {
    Driven(HeldOut),
    Events(EventEvidence),
    Lag(LagEvidence),
    /// With the spread at amplitude 1.
    Random(UnitEvidence, f64),
}

impl Score {
    pub(super) fn gain(&self) -> f64 {
        match &self.evidence {
            ScoreOf::Driven(found) => found.gain(),
            ScoreOf::Events(found) => found.gain(),
            ScoreOf::Lag(found) => found.gain(),
            ScoreOf::Random(found, _) => found.gain(),
        }
    }
}

impl Round {
    /// The round of these people when some effects are named; `before` are their banks of events of the round before
    /// where their information still holds, otherwise empty lists.
    pub(super) fn of(
        people: &[PersonInput<'_>],
        library: &[&dyn Effect],
        named: &[Named],
        before: Vec<Vec<EventBank>>,
        config: &DiagnosisConfig,
    ) -> Result<Self, GapError> {
        let mut subjects: Vec<Subject> = people
            .par_iter()
            .zip(before)
            .enumerate()
            .map(|(place, (input, before))| {
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
                        lag::likelihoods(observations, calibration, rule, library[lag], first)
                    })
                    .transpose()?;
                let statistics = Statistics::of(&design);
                let of = |bank| UnitSums::of(&design, &statistics, bank);
                let units = design.random.iter().map(of).collect();
                let hidden = std::mem::take(&mut design.events);
                let backgrounds = Backgrounds::of(&design, &statistics, &hidden, library);
                let events =
                    hidden.banks(|effect| backgrounds.beside(effect), &design.weights, &before);
                drop(backgrounds);
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
        Ok(Self::estimated(subjects, guards))
    }

    /// The round of these linear models: random differences between days are estimated and integrated out.
    pub(super) fn estimated(subjects: Vec<Subject>, guards: Vec<(usize, f64)>) -> Self {
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
            .enumerate()
            .map(|(person, s)| {
                variance::marginal(&s.statistics, &spreads).beside(round.allowed(person, None))
            })
            .collect();
        round
    }

    /// What is allowed for when an effect is tested in a person; `None` for no effect in particular.
    pub(super) fn allowed(&self, person: usize, tested: Option<(usize, &str)>) -> Vec<Allowed> {
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
    pub(super) fn constant(&self, person: usize) -> Vec<f64> {
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

    pub(super) fn trials(&self, effect: usize, name: &str) -> Vec<Trial<'_>> {
        (0..self.subjects.len())
            .map(|person| Trial {
                folds: &self.marginal[person],
                allowed: self.allowed(person, Some((effect, name))),
                variants: self.variants(person, effect),
            })
            .collect()
    }

    pub(super) fn variants(&self, person: usize, wanted: usize) -> Vec<usize> {
        let columns = &self.subjects[person].statistics.columns;
        (0..columns.len())
            .filter(|c| matches!(columns[*c], Column::Effect { effect, .. } if effect == wanted))
            .collect()
    }
}

pub(super) fn none() -> Estimated {
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
