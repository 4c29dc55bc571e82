//! One round: everybody's linear model with what has been named so far, and the evidence of every effect.

use effects::{Card, EffectId};
use rayon::prelude::*;

use super::Score;
use super::backgrounds::{self, Guard, allowed};
use super::conditioned::conditioned;
use super::held_out::{FoldSums, Trial, fitted_to_all};
use super::lag;
use super::random_effects::UnitSums;
use super::statistics::{Sums, TestStatistics};
use super::tried::Tried;
use super::variance::{self, Estimated};
use crate::background::{Allowed, calibrated_factor};
use crate::calibrated_person::CalibratedPerson;
use crate::design::{Background, Column, Design, EventBank, design};
use crate::error::GapError;
use crate::filter::calibration::CalibrationRule;
use crate::units::PersonUnits;

/// One person in one round: the model with what has been named so far.
pub(super) struct RoundPerson {
    /// Effects that the record cannot show.
    pub(super) untried: Vec<EffectId>,
    pub(super) statistics: TestStatistics,
    pub(super) units: Vec<UnitSums>,
    pub(super) events: Vec<EventBank>,
    /// What natural units show, until something is named.
    pub(super) natural: Option<PersonUnits>,
}

impl RoundPerson {
    /// The person of a design; hidden events and natural units are yet to come.
    pub(super) fn of(design: &Design) -> Self {
        let statistics = TestStatistics::of(design);
        let of = |bank| UnitSums::of(design, &statistics, bank);
        let units = design.random.iter().map(of).collect();
        let untried = design.untried.clone();
        Self { untried, statistics, units, events: Vec::new(), natural: None }
    }
}

/// Everything that is known in one round.
pub(super) struct Round {
    pub(super) subjects: Vec<RoundPerson>,
    /// Likelihoods of sensor lags, one entry a person; none once the lag is named.
    pub(super) lags: Vec<lag::Likelihoods>,
    /// Each person's folds of days, random differences integrated out.
    pub(super) marginal: Vec<FoldSums>,
    pub(super) estimated: Estimated,
    /// Guards that are not themselves named, and named driven effects with their spread.
    pub(super) guards: Vec<Guard>,
}

impl Round {
    /// The round of these people when some effects are named; `before` are their banks of events of the round before
    /// where their information still holds, otherwise empty lists.
    pub(super) fn of(
        people: &[CalibratedPerson<'_>],
        tried: &Tried<'_>,
        named: &[Score],
        before: Vec<Vec<EventBank>>,
        rule: &CalibrationRule,
    ) -> Result<Self, GapError> {
        let guard = |effect: EffectId| match named.iter().find(|n| n.effect == effect) {
            Some(known) => {
                let sd = (0.5 * known.amplitude.0).hypot(0.1);
                Some(Guard { effect, sd, variants: known.variants.clone() })
            }
            None => tried.is_guard(effect).then(|| Guard::usual(effect)),
        };
        let guards: Vec<Guard> = tried.ids().into_iter().filter_map(guard).collect();
        let subjects = people.par_iter().zip(before).enumerate().map(|(index, (input, before))| {
            conditioned(input, index, tried, named, rule, |person| {
                let mut design = design(person, &tried.effects)?;
                let hidden = std::mem::take(&mut design.events);
                let mut found = RoundPerson::of(&design);
                let statistics = &found.statistics;
                if named.is_empty() {
                    found.natural = Some(natural(person, index, &design, statistics, &guards)?);
                }
                found.events = backgrounds::banks(&design, statistics, hidden, tried, &before);
                Ok(found)
            })
        });
        let subjects = subjects.collect::<Result<Vec<_>, GapError>>()?;
        let lags = lag::likelihoods(people, tried, named, rule)?;
        Ok(Self { lags, ..Self::estimated(subjects, guards) })
    }

    /// The round of these linear models: random differences between days are estimated and integrated out.
    pub(super) fn estimated(subjects: Vec<RoundPerson>, guards: Vec<Guard>) -> Self {
        let (lags, marginal, estimated) = (Vec::new(), Vec::new(), Estimated::default());
        let mut round = Self { subjects, lags, marginal, estimated, guards };
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
        let of = |(person, s): (usize, &RoundPerson)| {
            let tests = variance::marginal(&s.statistics, &self.estimated.spreads);
            FoldSums::new(s.statistics.days.len(), tests, self.allowed(person, None))
        };
        self.subjects.par_iter().enumerate().map(of).collect()
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

    /// The test of a driven effect.
    pub(super) fn trials(&self, card: &Card) -> Vec<Trial<'_>> {
        let is_variant =
            |column: &Column| matches!(column, Column::Effect { effect, .. } if *effect == card.id);
        (0..self.subjects.len())
            .map(|person| {
                let columns = &self.subjects[person].statistics.columns;
                Trial {
                    folds: &self.marginal[person],
                    allowed: self.allowed(person, Some(card)),
                    variants: (0..columns.len()).filter(|c| is_variant(&columns[*c])).collect(),
                }
            })
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
    use Background::{Clock, Defence, Effectiveness, Shedding};
    let information = Sums::over(&statistics.folds, None).a;
    let mut usual = allowed(&statistics.columns, guards, index, None);
    let mut plain = Vec::new();
    for nuisance in &mut usual {
        let Column::Background { which, .. } = statistics.columns[nuisance.column] else {
            continue;
        };
        // What a calibrated factor still lacks has the calibration's own prior, in logarithms, seen from where it ended:
        // the innovations are the same that the calibration saw, and are counted once.
        if let Background::Parameter(parameter) = which
            && let Some(factor) = calibrated_factor(parameter)
        {
            nuisance.mean = -person.calibration.factors.get(factor);
            nuisance.sd = factor.prior_sd();
        }
        if !matches!(which, Clock | Defence | Shedding | Effectiveness) {
            plain.push(*nuisance);
        }
    }
    PersonUnits::of(person, design, &information, &usual, &plain)
}

#[cfg(test)]
mod tests {
    use super::super::held_out::held_out;
    use super::super::sample::{A_DAY, CLOCK, COLUMNS, DAWN, PRIOR_SD, RENAL, design, only, week};
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
        let mut round = Round { subjects, ..Round::estimated(Vec::new(), Vec::new()) };
        round.marginal = round.marginals();
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
        let day = RoundPerson::of(&design(only(DAWN[0], 1.0), &[0.0]));
        let round = Round::estimated(vec![day], Vec::new());
        assert_eq!(held_out(EffectId::DAWN, &round.trials(&card("dawn"))).gains, [0.0]);
        assert_eq!(round.constant(0).len(), COLUMNS);
    }
}
