//! One round: everybody's linear model with what has been named so far, and the evidence of every effect.

use effects::{Allowance, Card, EffectId};
use rayon::prelude::*;

use super::Named;
use super::backgrounds::{Backgrounds, Guard, allowed};
use super::conditioned::{conditioned, longer_lags};
use super::events::EventEvidence;
use super::held_out::{FoldSums, HeldOutEvidence, Trial, fitted_to_all};
use super::lag::{self, LagEvidence};
use super::random_effects::{UnitEvidence, UnitSums};
use super::round_person::RoundPerson;
use super::statistics::{Sums, TestStatistics};
use super::tried::Tried;
use super::variance::{self, Estimated};
use crate::background::{Allowed, calibrated_factor};
use crate::calibrated_person::CalibratedPerson;
use crate::design::{Background, Column, Design, EventBank, design};
use crate::error::GapError;
use crate::filter::calibration::CalibrationRule;
use crate::units::PersonUnits;

/// Everything that is known in one round.
pub(super) struct Round {
    pub(super) subjects: Vec<RoundPerson>,
    /// Each person's folds of days, random differences integrated out.
    pub(super) marginal: Vec<FoldSums>,
    pub(super) estimated: Estimated,
    /// Guards that are not themselves named, and named driven effects with their spread.
    pub(super) guards: Vec<Guard>,
}

/// Evidence of one effect.
pub(super) struct Score {
    pub(super) effect: EffectId,
    pub(super) evidence: ScoreOf,
}

pub(super) enum ScoreOf {
    Driven(HeldOutEvidence),
    Events(EventEvidence),
    Lag(LagEvidence),
    /// With the spread at amplitude 1.
    Random(UnitEvidence, f64),
}

impl Score {
    /// Gain of the cohort, nats.
    pub(super) fn gain(&self) -> f64 {
        self.gains().iter().sum()
    }

    /// Gain of each person, nats.
    pub(super) fn gains(&self) -> &[f64] {
        match &self.evidence {
            ScoreOf::Driven(found) => &found.gains,
            ScoreOf::Events(found) => &found.gains,
            ScoreOf::Lag(found) => &found.gains,
            ScoreOf::Random(found, _) => &found.gains,
        }
    }
}

impl Round {
    /// The round of these people when some effects are named; `before` are their banks of events of the round before
    /// where their information still holds, otherwise empty lists.
    pub(super) fn of(
        people: &[CalibratedPerson<'_>],
        tried: &Tried<'_>,
        named: &[Named],
        before: Vec<Vec<EventBank>>,
        rule: &CalibrationRule,
    ) -> Result<Self, GapError> {
        let mut guards: Vec<Guard> = Vec::new();
        for effect in tried.ids() {
            let known = named.iter().find(|n| n.effect == effect);
            if let Some(known) = known {
                let sd = (0.5 * known.amplitude.0).hypot(0.1);
                guards.push(Guard { effect, sd, variants: known.variants.clone() });
            } else if tried.is_guard(effect) {
                guards.push(Guard::usual(effect));
            }
        }
        let mut subjects: Vec<RoundPerson> = people
            .par_iter()
            .zip(before)
            .enumerate()
            .map(|(index, (input, before))| {
                let about = conditioned(input, index, tried, named, rule)?;
                let person = about.as_ref().map_or(*input, |(observations, calibration)| {
                    CalibratedPerson { observations, calibration, ..*input }
                });
                let mut design = design(&person, tried.effects())?;
                let lags = tried
                    .lag()
                    .filter(|lag| named.iter().all(|n| n.effect != lag.card().id))
                    .map(|lag| lag::likelihoods(&person, rule, lag, &lag::AMPLITUDES[..lag::FIRST]))
                    .transpose()?;
                let statistics = TestStatistics::of(&design);
                let of = |bank| UnitSums::of(&design, &statistics, bank);
                let units = design.random.iter().map(of).collect();
                let hidden = std::mem::take(&mut design.events);
                let backgrounds = Backgrounds::of(&design, &statistics, &hidden, tried);
                let events =
                    hidden.banks(|effect| backgrounds.for_effect(effect), &design.weights, &before);
                drop(backgrounds);
                let natural = named
                    .is_empty()
                    .then(|| natural(&person, index, &design, &statistics, &guards))
                    .transpose()?;
                let untried = design.untried;
                Ok(RoundPerson { untried, statistics, units, events, lags, natural })
            })
            .collect::<Result<_, GapError>>()?;
        longer_lags(&mut subjects, people, tried, named, rule)?;
        Ok(Self::estimated(subjects, guards))
    }

    /// The round of these linear models: random differences between days are estimated and integrated out.
    pub(super) fn estimated(subjects: Vec<RoundPerson>, guards: Vec<Guard>) -> Self {
        let mut round =
            Self { subjects, marginal: Vec::new(), estimated: Estimated::default(), guards };
        // Constant directions, then spreads given them, twice: each needs the other.
        for _ in 0..2 {
            round.marginal = round.marginals();
            let fixed: Vec<Vec<f64>> = (0..round.subjects.len())
                .into_par_iter()
                .map(|person| round.constant(person))
                .collect();
            let statistics: Vec<&TestStatistics> =
                round.subjects.iter().map(|s| &s.statistics).collect();
            round.estimated = variance::estimate(&statistics, &fixed, round.estimated.spreads);
        }
        round.marginal = round.marginals();
        round
    }

    /// Each person's folds, random differences of the estimated spreads integrated out.
    fn marginals(&self) -> Vec<FoldSums> {
        self.subjects
            .par_iter()
            .enumerate()
            .map(|(person, s)| {
                variance::marginal(&s.statistics, &self.estimated.spreads)
                    .allowing_for(self.allowed(person, None))
            })
            .collect()
    }

    /// What is allowed for when an effect is tested in a person; `None` for no effect in particular.
    pub(super) fn allowed(&self, person: usize, tested: Option<&Card>) -> Vec<Allowed> {
        allowed(&self.subjects[person].statistics.columns, &self.guards, person, tested)
    }

    /// A person's constant directions, one number a column.
    pub(super) fn constant(&self, person: usize) -> Vec<f64> {
        let allowed = self.allowed(person, None);
        let columns = self.subjects[person].statistics.columns.len();
        let mut out = vec![0.0; columns];
        let (fitted, _) = fitted_to_all(&self.marginal[person].tests, &allowed);
        for (allowed, value) in allowed.iter().zip(fitted) {
            out[allowed.column] = value;
        }
        out
    }

    pub(super) fn trials(&self, card: &Card) -> Vec<Trial<'_>> {
        (0..self.subjects.len())
            .map(|person| Trial {
                folds: &self.marginal[person],
                allowed: self.allowed(person, Some(card)),
                variants: self.variants(person, card.id),
            })
            .collect()
    }

    pub(super) fn variants(&self, person: usize, wanted: EffectId) -> Vec<usize> {
        let columns = &self.subjects[person].statistics.columns;
        (0..columns.len())
            .filter(|c| matches!(columns[*c], Column::Effect { effect, .. } if effect == wanted))
            .collect()
    }
}

/// What a person's natural units show beside the background, and beside the part of it that says nothing of the clock
/// and of glucose.
fn natural(
    person: &CalibratedPerson<'_>,
    index: usize,
    design: &Design,
    statistics: &TestStatistics,
    guards: &[Guard],
) -> Result<PersonUnits, GapError> {
    let information = Sums::over(&statistics.folds, None).a;
    let mut usual = allowed(&statistics.columns, guards, index, None);
    let mut plain = Vec::new();
    for nuisance in &mut usual {
        let Column::Background { which, .. } = statistics.columns[nuisance.column] else {
            continue;
        };
        if let Some(prior) = of_calibration(which, person) {
            (nuisance.mean, nuisance.sd) = prior;
        }
        let asks = [Allowance::Clock, Allowance::Defence, Allowance::Shedding];
        let is_allowance = asks.into_iter().any(|allowance| which.is(allowance));
        if !is_allowance && which != Background::Effectiveness {
            plain.push(*nuisance);
        }
    }
    PersonUnits::of(person, design, &information, &usual, &plain)
}

/// The prior of what a calibrated factor still lacks, in logarithms: its own, seen from where the calibration ended.
///
/// The innovations are the same that the calibration saw; with the calibration's own prior they are counted once.
fn of_calibration(which: Background, person: &CalibratedPerson<'_>) -> Option<(f64, f64)> {
    let Background::Parameter(parameter) = which else { return None };
    let factor = calibrated_factor(parameter)?;
    Some((-person.calibration.factors.get(factor), factor.prior_sd()))
}

#[cfg(test)]
mod tests {
    use super::super::held_out::held_out;
    use super::super::sample::{
        A_DAY, CLOCK, COLUMNS, DAWN, PRIOR_SD, RENAL, design, only, subject, week,
    };
    use super::*;

    fn card(name: &str) -> Card {
        effects::find(name).expect("in the library").card()
    }

    #[test]
    fn the_background_and_one_variant_of_each_guard_are_allowed_for_but_never_the_effect_itself() {
        let guard = |effect, sd| Guard { effect, sd, variants: Vec::new() };
        let guards = vec![guard(EffectId::RENAL_THRESHOLD, 0.5), guard(EffectId::DAWN, 0.3)];
        let round = Round::estimated(vec![week(0, 0.0)], guards);
        let allowed = |tested: Option<&str>| -> Vec<usize> {
            let card = tested.map(card);
            round.allowed(0, card.as_ref()).iter().map(|allowed| allowed.column).collect()
        };
        let background: Vec<usize> = (0..=CLOCK).collect();
        assert_eq!(allowed(None), [&background[..], &[DAWN[0], RENAL]].concat());
        assert_eq!(allowed(Some("renal_threshold")), [&background[..], &[DAWN[0]]].concat());
        // Dawn is a pattern of the clock.
        assert_eq!(allowed(Some("dawn")), [&background[..CLOCK], &[RENAL]].concat());
        let sds: Vec<f64> = round.allowed(0, None).iter().map(|allowed| allowed.sd).collect();
        assert_eq!(sds[CLOCK..], [PRIOR_SD, 0.3, 0.5]);
    }

    #[test]
    fn each_person_is_allowed_the_variant_by_which_an_effect_was_named() {
        let variants = vec![1, 0];
        let named = Guard { effect: EffectId::DAWN, sd: 0.3, variants };
        let round = Round::estimated(vec![week(0, 0.0), week(0, 0.0)], vec![named]);
        let last = |person| round.allowed(person, None).last().map(|allowed| allowed.column);
        assert_eq!([last(0), last(1)], [Some(DAWN[1]), Some(DAWN[0])]);
    }

    #[test]
    fn a_constant_direction_is_shrunk_by_its_prior() {
        let subjects = vec![week(CLOCK, 0.4), week(CLOCK, 0.8)];
        let of = |subject: &RoundPerson| {
            variance::marginal(&subject.statistics, &variance::Spreads::default())
        };
        let marginal = subjects.iter().map(of).collect();
        let round =
            Round { subjects, marginal, estimated: Estimated::default(), guards: Vec::new() };
        let n = (7 * A_DAY) as f64;
        for (person, amplitude) in [0.4, 0.8].into_iter().enumerate() {
            let expected = only(CLOCK, n * amplitude / (n + PRIOR_SD.powi(-2)));
            for (found, expected) in round.constant(person).into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-12, "{found} {expected}"); // rounding
            }
        }
    }

    #[test]
    fn a_cohort_of_nobody_has_no_spread_and_one_day_is_no_evidence() {
        let nobody = Round::estimated(Vec::new(), Vec::new());
        assert!(nobody.estimated.spreads.day.iter().all(|spread| *spread == 0.0));
        assert!(nobody.trials(&card("dawn")).is_empty());
        let day = subject(design(only(DAWN[0], 1.0), &[0.0]));
        let round = Round::estimated(vec![day], Vec::new());
        assert_eq!(held_out(&round.trials(&card("dawn"))).gains, [0.0]);
        assert_eq!(round.constant(0).len(), COLUMNS);
    }
}
