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
use crate::free_run::FreeRunRule;
use crate::free_run_statistics::free_run_statistics;
use crate::hourly::hourly_gap;
use crate::how_far::{NamedEffect, Settings, how_far};
use crate::localisation::{CellEstimate, DayCells, LocalisationRule, of_each_person, over_people};
use crate::one_person::others;
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

        let included: Vec<(&str, &PersonAnalysis)> = outcomes
            .iter()
            .filter_map(|o| Some((o.summary.person_id.as_str(), o.analysis.as_ref()?)))
            .collect();
        if included.is_empty() {
            return Err(nobody_left(&outcomes));
        }
        let inputs: Vec<CalibratedPerson<'_>> =
            all_calibrated(cohort, &outcomes).map(|(_, person)| person).collect();
        let posterior: &Posterior = self.posterior.unwrap_or_else(|| working_posterior());
        // One of them waits for a thread of its own; the other uses it meanwhile.
        let ((mut gaps, hourly, baseline), which) = rayon::join(
            || {
                let (rule, localisation) = (&config.free_run, &config.localisation);
                let gaps = gaps(&included, rule, localisation, seed);
                let days = included.iter().map(|(id, a)| (*id, a.hourly.as_slice()));
                let days: Vec<_> = days.collect();
                let hourly = hourly_gap(&gaps, &days, localisation, derived(seed, HOURLY));
                (gaps, hourly, baseline(&included, rule, localisation, seed))
            },
            || {
                let analyses: Vec<&PersonAnalysis> = included.iter().map(|(_, own)| *own).collect();
                let free_runs = |without: Option<usize>| match without {
                    Some(person) => {
                        free_run_statistics(others(&analyses, person).copied(), &config)
                    }
                    None => free_run_statistics(analyses.iter().copied(), &config),
                };
                let people = (&inputs[..], outcomes.len());
                which(people, library, posterior, &config.calibration, &free_runs)
            },
        );
        let (baseline, which) = (baseline?, which?);
        share_out(&mut gaps, &which.belief.answer.gaps);
        let ids: Vec<&str> = included.iter().map(|(id, _)| *id).collect();
        let answer = which.answer(library, &ids);
        let settings = Settings {
            calibration: &config.calibration,
            free_run: &config.free_run,
            resampling: &config.localisation,
        };
        let how_far = held_out_change(&which, &inputs, library, settings, derived(seed, HOW_FAR))?;
        let mut effects = answer.effects;
        for found in &mut effects {
            found.questioned = doubts(found, &how_far, plants.name() == Ode.name());
        }
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
            notes: known(plants).into_iter().chain(of_own(library, posterior)).collect(),
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
    PosteriorSaid {
        something: 1.0 - answer.nothing,
        sets: answer
            .sets
            .iter()
            .map(|(effects, probability)| ProbableSet {
                effects: effects.clone(),
                probability: *probability,
            })
            .collect(),
        speaks_from: *speaks_from,
        names_from: NAMED_FROM,
        source: posterior.card().source.clone(),
    }
}

/// What the blind check says of diagnoses with this plant; nothing where it was never asked.
fn known(plants: &dyn Plants) -> Option<String> {
    (plants.name() == Ode.name()).then(|| TrackRecord::measured().sentence())
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
    settings: Settings<'_>,
    seed: u64,
) -> Result<HowFar, GapError> {
    let named: Vec<NamedEffect<'_>> = which
        .named
        .iter()
        .filter_map(|named| {
            let id = named.effect;
            Some(NamedEffect {
                effect: library.iter().find(|effect| effect.card().id == id)?.as_ref(),
                variant: commonest(&named.variants),
                amplitudes: named.personal.iter().map(|p| p.0).collect(),
            })
        })
        .collect();
    if named.is_empty() {
        return Ok(HowFar::default());
    }
    how_far(inputs, &named, settings, seed)
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
    included: &[(&str, &PersonAnalysis)],
    free_run: &FreeRunRule,
    rule: &LocalisationRule,
    seed: u64,
) -> Vec<CellGap> {
    let half = 0.5 * rule.error_rate;
    let list = cells(free_run, rule);
    let both: Vec<Vec<DayCells>> = included
        .iter()
        .map(|(_, a)| a.free_runs.iter().zip(&a.innovations).map(joined).collect())
        .collect();
    let estimates = over_people(&both, rule, half, derived(seed, COHORT_FAMILY));
    let minutes =
        |horizon: usize| u32::try_from(5 * free_run.horizons[horizon]).unwrap_or(u32::MAX);
    let shares = Shares::of(included, free_run);
    let mut gaps = Vec::new();
    for (index, cell) in list.iter().enumerate() {
        let Some(free) = &estimates[index] else { continue };
        let innovation =
            (index < HORIZONS).then(|| estimates[list.len() + index]).flatten().map(|i| {
                InnovationGap {
                    mean_sd: i.mean,
                    lower: i.lower,
                    upper: i.upper,
                    p_adjusted: (2.0 * i.p_adjusted).min(1.0),
                }
            });
        let weight = shares.of_cell(included, index, cell.horizon);
        gaps.push(CellGap {
            innovation,
            ..gap(cell.factor, cell.level.clone(), free, weight, minutes(cell.horizon))
        });
    }
    let main = main_horizon(free_run, rule);
    let alone: Vec<Vec<DayCells>> = included.iter().map(|(_, a)| a.free_runs.clone()).collect();
    let people = of_each_person(&alone, HORIZONS + main, rule, half, derived(seed, PERSON_FAMILY));
    for ((id, _), estimate) in included.iter().zip(&people) {
        let Some(estimate) = estimate else { continue };
        let weight = shares.of_person(included.len(), main);
        gaps.push(gap(CellFactor::Person, (*id).to_owned(), estimate, weight, minutes(main)));
    }
    gaps.sort_by(|a, b| b.share_of_gap.total_cmp(&a.share_of_gap));
    gaps
}

/// `weight` is the cell's share of runs over the mean squared error.
fn gap(
    factor: CellFactor,
    level: String,
    estimate: &CellEstimate,
    weight: f64,
    horizon_minutes: u32,
) -> CellGap {
    CellGap {
        factor,
        level,
        mean_error_mg_dl: estimate.mean,
        lower: estimate.lower,
        upper: estimate.upper,
        p_adjusted: (2.0 * estimate.p_adjusted).min(1.0),
        share_of_gap: (weight * estimate.mean * estimate.mean).min(1.0),
        expected_mg_dl: None,
        horizon_minutes,
        people: estimate.people,
        runs: estimate.errors,
        innovation: None,
    }
}

/// Both layers of a day side by side.
fn joined((free, innovations): (&DayCells, &DayCells)) -> DayCells {
    let join = |a: &[f64], b: &[f64]| a.iter().chain(b).copied().collect();
    DayCells {
        counts: join(&free.counts, &innovations.counts),
        sums: join(&free.sums, &innovations.sums),
    }
}

/// Mean squared errors by horizon, from which shares of the gap are taken.
struct Shares {
    mean_squares: Vec<f64>,
}

impl Shares {
    fn of(included: &[(&str, &PersonAnalysis)], free_run: &FreeRunRule) -> Self {
        let mean_squares = (0..free_run.horizons.len())
            .map(|horizon| {
                mean_over_people(included, |a| {
                    let total = HorizonSums::total(a.horizons.iter(), horizon);
                    (total.runs > 0.0).then(|| total.squares / total.runs)
                })
            })
            .collect();
        Self { mean_squares }
    }

    fn over(&self, share: f64, horizon: usize) -> f64 {
        if self.mean_squares[horizon] > 0.0 { share / self.mean_squares[horizon] } else { 0.0 }
    }

    fn of_cell(&self, included: &[(&str, &PersonAnalysis)], index: usize, horizon: usize) -> f64 {
        let share = mean_over_people(included, |a| {
            let all = HorizonSums::total(a.horizons.iter(), horizon).runs;
            let inside: f64 = a.free_runs.iter().map(|day| day.counts[index]).sum();
            (all > 0.0).then(|| inside / all)
        });
        self.over(share, horizon)
    }

    fn of_person(&self, people: usize, horizon: usize) -> f64 {
        self.over(1.0 / people as f64, horizon)
    }
}

fn mean_over_people(
    included: &[(&str, &PersonAnalysis)],
    value: impl Fn(&PersonAnalysis) -> Option<f64>,
) -> f64 {
    let values: Vec<f64> = included.iter().filter_map(|(_, a)| value(a)).collect();
    if values.is_empty() { 0.0 } else { values.iter().sum::<f64>() / values.len() as f64 }
}

/// Mean absolute error, root mean squared error and bias of a horizon; zeros where nobody drawn has
/// a run.
fn horizon_statistics(people: &[Vec<&Vec<HorizonSums>>], horizon: usize) -> Vec<f64> {
    let (mut n, mut sizes, mut squares, mut errors) = (0.0, 0.0, 0.0, 0.0);
    for person in people {
        let sum = HorizonSums::total(person.iter().copied(), horizon);
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
    included: &[(&str, &PersonAnalysis)],
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
        let people: Vec<Vec<Vec<HorizonSums>>> = included
            .iter()
            .map(|(_, a)| a.horizons.iter().filter(|d| d[horizon].runs > 0.0).cloned().collect())
            .filter(|days: &Vec<_>| !days.is_empty())
            .collect();
        let matrix: ReplicateMatrix = match people.as_slice() {
            [] => continue,
            [days] if days.len() < 2 => continue,
            [days] => {
                plan.people_matrix(days, |drawn| horizon_statistics(&[drawn.to_vec()], horizon))?
            }
            people => plan.people_and_days_matrix(people, block, |drawn| {
                horizon_statistics(drawn, horizon)
            })?,
        };
        let of = |index| -> Result<WithInterval, GapError> {
            let estimate = matrix.estimate(index, 0.95)?;
            let interval = estimate.percentile;
            Ok(WithInterval { value: estimate.value, lower: interval.lower, upper: interval.upper })
        };
        let runs: f64 = people.iter().flatten().map(|day| day[horizon].runs).sum();
        found.push(HorizonError {
            minutes: u32::try_from(5 * steps).unwrap_or(u32::MAX),
            mae: of(0)?,
            rmse: of(1)?,
            bias: of(2)?,
            people: people.len(),
            runs: runs as usize,
        });
    }
    Ok(found)
}
