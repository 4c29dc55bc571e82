//! The diagnosis of a cohort.

use cohort::Cohort;
use effects::{Effect, ShownBy};
use posterior::Posterior;
use rayon::prelude::*;
use stats::{Bootstrap, ReplicateMatrix};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::Diagnosis;
use crate::belief::working_posterior;
use crate::calibrated_person::CalibratedPerson;
use crate::config::DiagnosisConfig;
use crate::error::GapError;
use crate::expected_gap::share_out;
use crate::filter::plants::{Ode, Plants};
use crate::free_run::{FreeRunRule, minutes};
use crate::free_run_statistics::free_run_statistics;
use crate::hourly::hourly_gap;
use crate::how_far::{NamedEffect, how_far};
use crate::localisation::{CellEstimate, DayCells, LocalisationRule, of_each_person, over_people};
use crate::person::{
    HORIZONS, HorizonSums, PersonAnalysis, PersonOutcome, all_calibrated, analyse, cells,
    main_horizon, nobody_left,
};
use crate::quality::InUse;
use crate::questioned::doubts;
use crate::track_record::TrackRecord;
use crate::which::{Belief, NAMED_FROM, Which, is_free, which};
use contract::WithInterval;
use contract::diagnosis::{
    CellFactor, CellGap, HorizonError, HowFar, InnovationGap, PosteriorSaid, ProbableSet,
};

/// A diagnosis to be made: which effects are tried, with which settings, on which plant.
///
/// It answers where the calibrated plant misses a cohort, which effect of the library it lacks, and how far adding
/// that effect goes.
///
/// ```no_run
/// use gap::{Diagnoser, DiagnosisConfig};
///
/// let cohort = cohort::read_folder("my-cohort".as_ref())?;
/// // An effect of your own goes beside those of the library.
/// let library = effects::library();
/// let diagnosis = Diagnoser::new(&library, &DiagnosisConfig::working()).run(&cohort, 1)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy)]
pub struct Diagnoser<'a> {
    library: &'a [Box<dyn Effect>],
    config: &'a DiagnosisConfig,
    plants: &'a dyn Plants,
    posterior: Option<&'a Posterior>,
    in_use: Option<&'a InUse>,
    progress: &'a (dyn Fn(usize, usize) + Sync),
}

impl<'a> Diagnoser<'a> {
    /// Tries the effects of `library` on the ODE plant.
    #[must_use]
    pub fn new(library: &'a [Box<dyn Effect>], config: &'a DiagnosisConfig) -> Self {
        let progress = &|_, _| {};
        Self { library, config, plants: &Ode, posterior: None, in_use: None, progress }
    }

    /// Lets another posterior decide than [that in use](crate::working_posterior).
    #[must_use]
    pub fn posterior(self, posterior: &'a Posterior) -> Self {
        Self { posterior: Some(posterior), ..self }
    }

    /// Diagnoses another plant than the ODE.
    ///
    /// The posterior in use was trained on what the ODE misses.
    #[must_use]
    pub fn plants(self, plants: &'a dyn Plants) -> Self {
        Self { plants, ..self }
    }

    /// Uses the people and values of a list that was made before, for the cohort that is diagnosed.
    #[must_use]
    pub fn in_use(self, data: &'a InUse) -> Self {
        Self { in_use: Some(data), ..self }
    }

    /// Calls `progress` with (people done, people) after each person, from any thread.
    #[must_use]
    pub fn progress(self, progress: &'a (dyn Fn(usize, usize) + Sync)) -> Self {
        Self { progress, ..self }
    }

    /// Diagnoses a cohort.
    ///
    /// People are analysed in parallel; the result depends on `seed`, the seed of all resampling, and not on the
    /// number of threads.
    ///
    /// # Errors
    /// [`GapError::Setting`] and [`GapError::EmptyCohort`]; [`GapError::EffectTwice`] and [`GapError::EffectName`] for
    /// a library whose effects cannot be distinguished by name; [`GapError::IdenticalPeople`] for one record under two
    /// names; [`GapError::Value`] for data that cannot be;
    /// [`GapError::NobodyLeft`] if every person had to be excluded.
    pub fn run(&self, cohort: &Cohort, seed: u64) -> Result<Diagnosis, GapError> {
        let Self { library, plants, progress, .. } = *self;
        let config = self.config.clone().validated()?;
        distinct(library)?;
        if cohort.people.is_empty() {
            return Err(GapError::EmptyCohort);
        }
        let data = match self.in_use {
            Some(data) => Cow::Borrowed(data),
            None => Cow::Owned(InUse::of(cohort, &config.inclusion)?),
        };
        let done = AtomicUsize::new(0);
        let outcomes: Vec<PersonOutcome> = cohort
            .people
            .par_iter()
            .map(|person| {
                let used = data.of_person(&person.id);
                let used = used.ok_or_else(|| GapError::Unjudged { person: person.id.clone() })?;
                let outcome = analyse(person, used, plants, &config);
                progress(done.fetch_add(1, Ordering::Relaxed) + 1, cohort.people.len());
                outcome
            })
            .collect::<Result<_, _>>()?;

        let (ids, analyses): (Vec<&str>, Vec<&PersonAnalysis>) = outcomes
            .iter()
            .filter_map(|o| Some((o.summary.person_id.as_str(), o.analysis.as_ref()?)))
            .unzip();
        if analyses.is_empty() {
            return Err(nobody_left(&outcomes));
        }
        let inputs: Vec<CalibratedPerson<'_>> =
            all_calibrated(cohort, &outcomes).map(|(_, person)| person).collect();
        let posterior: &Posterior = self.posterior.unwrap_or_else(|| working_posterior());
        // One of them waits for a thread of its own; the other uses it meanwhile.
        let ((mut gaps, hourly, baseline), which) = rayon::join(
            || {
                let (rule, localisation) = (&config.free_run, &config.localisation);
                let gaps = gaps(&ids, &analyses, rule, localisation, seed);
                let days: Vec<Vec<DayCells>> = analyses.iter().map(|a| a.hourly.clone()).collect();
                let hourly = hourly_gap(&gaps, &ids, &days, localisation, derived(seed, HOURLY));
                (gaps, hourly, baseline(&analyses, rule, localisation, seed))
            },
            || {
                let free_runs = |without: Option<usize>| {
                    let kept = analyses.iter().enumerate().filter(|(k, _)| Some(*k) != without);
                    free_run_statistics(kept.map(|(_, own)| *own), &config)
                };
                let people = (&inputs[..], outcomes.len());
                which(people, library, posterior, &config.calibration, &free_runs)
            },
        );
        let (baseline, which) = (baseline?, which?);
        share_out(&mut gaps, &which.belief.answer.gaps);
        let answer = which.answer(library, &ids);
        let how_far = held_out_change(&which, &inputs, library, &config, derived(seed, HOW_FAR))?;
        let is_ode = plants.name() == Ode.name();
        let mut effects = answer.effects;
        for found in &mut effects {
            found.questioned = doubts(found, &how_far, is_ode);
        }
        // What the blind check says of diagnoses with this plant; it was asked of no other.
        let known = is_ode.then(|| TrackRecord::measured().sentence());
        Ok(Diagnosis {
            schema: <Diagnosis as contract::Document>::SCHEMA.to_owned(),
            verdict: answer.verdict,
            effects,
            candidates: answer.candidates,
            untried: answer.untried,
            ports: answer.ports,
            evidence: which.first.evidence.clone(),
            posterior: said(&which.belief, posterior),
            cells: gaps,
            hourly: Some(hourly),
            how_far,
            baseline,
            data_quality: outcomes.iter().flat_map(|o| o.findings.clone()).collect(),
            people: outcomes.into_iter().map(|o| o.summary).collect(),
            plant: plants.name().to_owned(),
            notes: known.into_iter().chain(of_own(library, posterior)).collect(),
            absorbed: None,
            seed,
            config,
        })
    }
}

/// Checks that the effects can be separated: every one has a name of its own, none that stands for something else in
/// the output, and at most one is what sensor lags show.
fn distinct(library: &[Box<dyn Effect>]) -> Result<(), GapError> {
    let mut known = BTreeSet::new();
    let mut lag = None;
    for card in library.iter().map(|effect| effect.card()) {
        if !is_free(card.id.name()) {
            return Err(GapError::EffectName { effect: card.id });
        }
        if !known.insert(card.id) {
            return Err(GapError::EffectTwice { effect: card.id });
        }
        if card.relations.shown_by == ShownBy::SensorLag
            && let Some(first) = lag.replace(card.id)
        {
            return Err(GapError::TwoLags { first, second: card.id });
        }
    }
    Ok(())
}

/// What a posterior said, as it is written.
fn said(belief: &Belief, posterior: &Posterior) -> PosteriorSaid {
    let Belief { answer, speaks_from } = belief;
    let set = |(effects, probability): &(Vec<String>, f64)| ProbableSet {
        effects: effects.clone(),
        probability: *probability,
    };
    PosteriorSaid {
        something: 1.0 - answer.nothing,
        sets: answer.sets.iter().map(set).collect(),
        speaks_from: *speaks_from,
        names_from: NAMED_FROM,
        source: posterior.card().source.clone(),
    }
}

/// What is to be said of effects that the posterior does not know.
fn of_own(library: &[Box<dyn Effect>], posterior: &Posterior) -> Vec<String> {
    let cards = library.iter().map(|effect| effect.card());
    let own = cards.filter(|card| !posterior.effects().iter().any(|e| e == card.id.name()));
    own.map(|card| {
        format!(
            "`{}` is no effect that the posterior knows. It is named where it explains more than each effect of \
             the library that is tested in the same way; how often that happens by chance was not measured.",
            card.id
        )
    })
    .collect()
}

/// What adding the named effects changes on held-out days; nothing where none was named.
fn held_out_change(
    which: &Which,
    inputs: &[CalibratedPerson<'_>],
    library: &[Box<dyn Effect>],
    config: &DiagnosisConfig,
    seed: u64,
) -> Result<HowFar, GapError> {
    let named = which.named.iter().filter_map(|named| {
        Some(NamedEffect {
            effect: library.iter().find(|effect| effect.card().id == named.effect)?.as_ref(),
            variant: commonest(&named.variants),
            amplitudes: named.personal.iter().map(|p| p.0).collect(),
        })
    });
    let named: Vec<NamedEffect<'_>> = named.collect();
    if named.is_empty() {
        return Ok(HowFar::default());
    }
    how_far(inputs, &named, config, seed)
}

fn commonest(variants: &[usize]) -> usize {
    let count = |variant: usize| variants.iter().filter(|v| **v == variant).count();
    variants.iter().copied().max_by_key(|v| (count(*v), usize::MAX - v)).unwrap_or(0)
}

/// Streams of the two families and of the baseline, so that none reuses another's draws.
const COHORT_FAMILY: u64 = 1;
const PERSON_FAMILY: u64 = 2;
const BASELINE: u64 = 3;
const HOW_FAR: u64 = 4;
const HOURLY: u64 = 5;

fn derived(seed: u64, purpose: u64) -> u64 {
    seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(purpose)
}

/// The cells, largest share of the gap first.
///
/// Two families share the error rate equally: cells of the cohort in both layers, and people.
/// Adjusted p-values are doubled accordingly (Bonferroni over the two).
fn gaps(
    ids: &[&str],
    analyses: &[&PersonAnalysis],
    free_run: &FreeRunRule,
    rule: &LocalisationRule,
    seed: u64,
) -> Vec<CellGap> {
    let half = 0.5 * rule.error_rate;
    let list = cells(free_run, rule);
    let both: Vec<Vec<DayCells>> = analyses
        .iter()
        .map(|a| a.free_runs.iter().zip(&a.innovations).map(joined).collect())
        .collect();
    let estimates = over_people(&both, rule, half, derived(seed, COHORT_FAMILY));
    let mean_squares: Vec<f64> = (0..free_run.horizons.len())
        .map(|horizon| mean_over_people(analyses, horizon, |_, all| all.squares / all.runs))
        .collect();
    let gap = |factor, level: &str, estimate: &CellEstimate, share_of_runs: f64, horizon: usize| {
        let square = mean_squares[horizon];
        let weight = if square > 0.0 { share_of_runs / square } else { 0.0 };
        CellGap {
            factor,
            level: level.to_owned(),
            mean_error_mg_dl: estimate.mean,
            lower: estimate.lower,
            upper: estimate.upper,
            p_adjusted: (2.0 * estimate.p_adjusted).min(1.0),
            share_of_gap: (weight * estimate.mean * estimate.mean).min(1.0),
            expected_mg_dl: None,
            horizon_minutes: minutes(free_run.horizons[horizon]),
            people: estimate.people,
            runs: estimate.errors,
            innovation: None,
        }
    };
    let mut gaps = Vec::new();
    for (index, cell) in list.iter().enumerate() {
        let Some(free) = &estimates[index] else { continue };
        let innovation = (index < HORIZONS).then(|| estimates[list.len() + index]).flatten();
        let innovation = innovation.map(|i| InnovationGap {
            mean_sd: i.mean,
            lower: i.lower,
            upper: i.upper,
            p_adjusted: (2.0 * i.p_adjusted).min(1.0),
        });
        let share = mean_over_people(analyses, cell.horizon, |a, all| {
            a.free_runs.iter().map(|day| day.counts[index]).sum::<f64>() / all.runs
        });
        let free = gap(cell.factor, &cell.level, free, share, cell.horizon);
        gaps.push(CellGap { innovation, ..free });
    }
    let main = main_horizon(free_run, rule);
    let alone: Vec<Vec<DayCells>> = analyses.iter().map(|a| a.free_runs.clone()).collect();
    let people = of_each_person(&alone, HORIZONS + main, rule, half, derived(seed, PERSON_FAMILY));
    for (id, estimate) in ids.iter().zip(&people) {
        let Some(estimate) = estimate else { continue };
        gaps.push(gap(CellFactor::Person, id, estimate, 1.0 / ids.len() as f64, main));
    }
    gaps.sort_by(|a, b| b.share_of_gap.total_cmp(&a.share_of_gap));
    gaps
}

/// Both layers of a day side by side.
fn joined((free, innovations): (&DayCells, &DayCells)) -> DayCells {
    DayCells {
        counts: [&free.counts[..], &innovations.counts].concat(),
        sums: [&free.sums[..], &innovations.sums].concat(),
    }
}

/// Mean over those who have a run at a horizon; 0 where nobody has.
fn mean_over_people(
    analyses: &[&PersonAnalysis],
    horizon: usize,
    value: impl Fn(&PersonAnalysis, HorizonSums) -> f64,
) -> f64 {
    let all = analyses.iter().map(|a| (a, a.total(horizon))).filter(|(_, all)| all.runs > 0.0);
    let values: Vec<f64> = all.map(|(a, all)| value(a, all)).collect();
    if values.is_empty() { 0.0 } else { values.iter().sum::<f64>() / values.len() as f64 }
}

/// Mean absolute error, root mean squared error and bias of people's days at a horizon; zeros where nobody drawn has
/// a run.
fn horizon_statistics(people: &[Vec<&HorizonSums>]) -> Vec<f64> {
    let (mut n, mut sizes, mut squares, mut errors) = (0.0, 0.0, 0.0, 0.0);
    for person in people {
        let sum = HorizonSums::total(person.iter().copied());
        if sum.runs > 0.0 {
            n += 1.0;
            sizes += sum.sizes / sum.runs;
            squares += sum.squares / sum.runs;
            errors += sum.errors / sum.runs;
        }
    }
    let n = f64::max(n, 1.0);
    vec![sizes / n, (squares / n).sqrt(), errors / n]
}

/// Errors by horizon with 95 % intervals over people and days; over days alone for a single person.
fn baseline(
    analyses: &[&PersonAnalysis],
    free_run: &FreeRunRule,
    rule: &LocalisationRule,
    seed: u64,
) -> Result<Vec<HorizonError>, GapError> {
    let plan =
        Bootstrap { replicates: rule.replicates, level: 0.95, seed: derived(seed, BASELINE) };
    let block = NonZeroUsize::new(rule.block_days).unwrap_or(NonZeroUsize::MIN);
    let mut found = Vec::new();
    for (horizon, steps) in free_run.horizons.iter().enumerate() {
        // Days without a run would make an empty statistic when drawn alone.
        let days = |a: &&PersonAnalysis| -> Vec<HorizonSums> {
            a.horizons.iter().map(|day| day[horizon]).filter(|day| day.runs > 0.0).collect()
        };
        let people: Vec<Vec<HorizonSums>> =
            analyses.iter().map(days).filter(|days| !days.is_empty()).collect();
        let matrix: ReplicateMatrix = match people.as_slice() {
            [] => continue,
            [days] if days.len() < 2 => continue,
            [days] => plan.people_matrix(days, |drawn| horizon_statistics(&[drawn.to_vec()]))?,
            people => plan.people_and_days_matrix(people, block, horizon_statistics)?,
        };
        let of = |index| -> Result<WithInterval, GapError> {
            let estimate = matrix.estimate(index, 0.95)?;
            let interval = estimate.percentile;
            Ok(WithInterval { value: estimate.value, lower: interval.lower, upper: interval.upper })
        };
        let runs: f64 = people.iter().flatten().map(|day| day.runs).sum();
        found.push(HorizonError {
            minutes: minutes(*steps),
            mae: of(0)?,
            rmse: of(1)?,
            bias: of(2)?,
            people: people.len(),
            runs: runs as usize,
        });
    }
    Ok(found)
}
