//! `effect-twins`: twins whose plant has the effects that the diagnosis names, beside twins that must
//! absorb them.
//!
//! The diagnosis sees the training days alone. Amplitudes are its own, person by person; which variant of an
//! effect acts is chosen on the training windows. Every kind of twin is then trained on these and judged on
//! the days after.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;

use anyhow::{Context as _, Result, ensure};
use cohort::{Cohort, Person, Window};
use effects::{Course, find};
use gap::{Diagnoser, Diagnosis, DiagnosisConfig};
use nn_statespace::{PopulationModel, ScaledStates};
use physiology::{Kilograms, MgPerDl, STEPS_PER_DAY};
use rayon::prelude::*;
use serde::Serialize;
use stats::{Bootstrap, Outcomes, Summary, compare_outcomes, paired};
use twins::{
    HeartRateScaler, InputSet, PersonWindows, PreparedWindow, Protocol, ResidualNetwork,
    SteadyStates, TrainingPlan, TwinLoss, inputs_within, measured, train, window_courses,
    window_loss, window_starts_with,
};

use crate::cli::EffectTwinsArgs;
use crate::manifest::Manifest;
use crate::models::read_population;
use crate::output::OutputFolder;
use crate::progress::{Progress, note};
use crate::stages::twin::{self, read_cohort};
use plants::check_wiring;
use plants::{Acting, Active, ModulatedNetwork, cannot_be_input, course_of};

/// Fewest people over whom methods are compared.
const FEWEST_PEOPLE: usize = 2;
/// A sensor's range, mg/dL.
const SENSOR: (f64, f64) = (40.0, 400.0);

/// What is compared. The residual network sees everything or the states alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Kind {
    name: &'static str,
    effect: bool,
    residual: Option<InputSet>,
}

/// Effect absent or an input, by what the residual network sees.
const KINDS: [Kind; 6] = [
    Kind { name: "population", effect: false, residual: None },
    Kind { name: "population + effect", effect: true, residual: None },
    Kind { name: "twin", effect: false, residual: Some(InputSet::All) },
    Kind { name: "twin + effect", effect: true, residual: Some(InputSet::All) },
    Kind { name: "twin, states only", effect: false, residual: Some(InputSet::None) },
    Kind { name: "twin, states only, + effect", effect: true, residual: Some(InputSet::None) },
];
/// Which kinds differ by the effect alone.
const PAIRS: [(usize, usize); 3] = [(1, 0), (3, 2), (5, 4)];

/// `effect_twins.json`.
#[derive(Debug, Serialize)]
struct Found {
    schema: &'static str,
    /// Effects that are inputs, with the variant in use and the mean amplitude over people.
    effects: Vec<InputEffect>,
    /// Effects that were named and cannot be inputs, with the reason.
    left_out: BTreeMap<String, String>,
    people: usize,
    windows: usize,
    kinds: Vec<KindRow>,
    comparisons: Vec<ComparisonRow>,
}

#[derive(Debug, Serialize)]
struct InputEffect {
    effect: String,
    variant: usize,
    mean_amplitude: f64,
    gain_nats: f64,
}

#[derive(Debug, Serialize)]
struct KindRow {
    name: &'static str,
    rmse_5h: Summary,
    rows: Vec<stats::OutcomeEquivalence>,
}

/// With the effect minus without it, over people.
#[derive(Debug, Serialize)]
struct ComparisonRow {
    with: &'static str,
    without: &'static str,
    value: f64,
    lower: f64,
    upper: f64,
    p: f64,
}

/// The manifest of a run with these arguments.
pub(crate) fn manifest(args: &EffectTwinsArgs) -> Result<Manifest> {
    let config = serde_json::json!({ "profile": args.profile });
    Manifest::new("effect-twins", config, Some(args.seed))
        .with_input(&args.cohort)?
        .with_input(&args.model)
}

/// Runs the command.
pub(crate) fn run(args: &EffectTwinsArgs) -> Result<()> {
    let manifest = manifest(args)?;
    let cohort = read_cohort(&args.cohort)?;
    let population = Arc::new(read_population(&args.model)?);
    check_wiring(&population)
        .with_context(|| format!("'{}' cannot take effects as inputs", args.model.display()))?;
    let (protocol, plan) = twin::protocol(args.profile, None);
    let output = OutputFolder::begin(&args.out, manifest)?;

    let (library, config) = (effects::library(), DiagnosisConfig::working());
    let diagnosis = Diagnoser::new(&library, &config)
        .run(&training_days(&cohort, &protocol), args.seed)
        .context("the diagnosis of the training days")?;
    let steady = SteadyStates::new(&*population);
    let mut people = Vec::new();
    for (index, person) in cohort.people.iter().enumerate() {
        match Subject::new(index, person, &protocol, &steady)? {
            Ok(subject) => people.push(subject),
            Err(reason) => note(format!("effect-twins: {} left out: {reason}", person.id)),
        }
    }
    ensure!(
        people.len() >= FEWEST_PEOPLE,
        "{} people have complete windows in both parts; a comparison needs {FEWEST_PEOPLE}",
        people.len()
    );
    let (acting, left_out) = acting(&diagnosis, &people, &population)?;
    for (effect, reason) in &left_out {
        note(format!("effect-twins: {effect} is named and no input: {reason}"));
    }
    if acting.is_empty() {
        note(
            "effect-twins: nothing is named that could be an input; with and without are the same",
        );
    }
    let progress = Progress::begin("effect-twins", people.len());
    let judged: Vec<Judged> = people
        .par_iter()
        .map(|subject| {
            let judged = subject
                .judged(&population, &acting, &diagnosis, &plan, args.seed)
                .with_context(|| format!("person '{}'", subject.person.id))?;
            progress.advance(&subject.person.id);
            Ok(judged)
        })
        .collect::<Result<_>>()?;
    let found = Found::new(&judged, &acting, left_out, &diagnosis, args.seed)?;
    let text = found.text();
    output.write_json("effect_twins.json", &found)?;
    output.write("effect_twins.txt", text.as_bytes())?;
    let place = output.finish()?;
    note(text);
    progress.finish(&format!("{} people, {}", judged.len(), place.display()));
    Ok(())
}

/// Everybody's training days alone.
fn training_days(cohort: &Cohort, protocol: &Protocol) -> Cohort {
    let people = cohort.people.iter().filter_map(|person| {
        let steps = protocol.training_days_of(&person.record) * STEPS_PER_DAY;
        Some(Person { record: person.record.slice(0..steps)?, ..person.clone() })
    });
    Cohort { people: people.collect() }
}

/// The named effects that can be inputs, and the others with the reason.
fn acting(
    diagnosis: &Diagnosis,
    people: &[Subject<'_>],
    population: &Arc<PopulationModel>,
) -> Result<(Vec<Acting>, BTreeMap<String, String>)> {
    let courses: Vec<Course> = people.iter().map(|subject| subject.course.clone()).collect();
    let (mut acting, mut left_out) = (Vec::new(), BTreeMap::new());
    for named in &diagnosis.effects {
        let Some(effect) = find(&named.effect) else {
            left_out.insert(named.effect.clone(), "it is not in the library".to_owned());
            continue;
        };
        if let Some(reason) = cannot_be_input(effect.as_ref(), &courses) {
            left_out.insert(named.effect.clone(), reason.to_owned());
            continue;
        }
        let mut best = (f64::INFINITY, 0);
        for variant in 0..effect.variants() {
            let losses: Vec<f64> = people
                .par_iter()
                .map(|subject| {
                    let amplitude = amplitude(diagnosis, &named.effect, &subject.person.id);
                    let acting = [(effect.as_ref(), variant, amplitude)];
                    subject.loss_under(population, &Active::new(&subject.course, acting))
                })
                .collect::<Result<_>>()?;
            let loss = losses.iter().sum::<f64>();
            if loss < best.0 {
                best = (loss, variant);
            }
        }
        acting.push(Acting { effect, variant: best.1 });
    }
    Ok((acting, left_out))
}

/// A person's amplitude of an effect; 0 for somebody whom the diagnosis left out.
fn amplitude(diagnosis: &Diagnosis, effect: &str, person: &str) -> f64 {
    let named = diagnosis.effects.iter().find(|found| found.effect == effect);
    let of = named.and_then(|found| found.people.iter().find(|p| p.person_id == person));
    of.map_or(0.0, |found| found.amplitude.max(0.0))
}

/// A person with windows and starts.
struct Subject<'a> {
    index: usize,
    person: &'a Person,
    cut: PersonWindows,
    course: Course,
    heart_rate: Option<HeartRateScaler>,
    train: Vec<ScaledStates>,
    test: Vec<ScaledStates>,
}

/// Measured outcomes of a person, and outcomes and error by kind.
struct Judged {
    windows: usize,
    actual: Outcomes,
    kinds: Vec<(Outcomes, f64)>,
}

impl<'a> Subject<'a> {
    fn new(
        index: usize,
        person: &'a Person,
        protocol: &Protocol,
        steady: &SteadyStates<'_, PopulationModel>,
    ) -> Result<Result<Self, String>> {
        let cut = PersonWindows::new(index, person, protocol)?;
        if let Some(reason) = cut.excluded {
            return Ok(Err(reason.to_string()));
        }
        let starts = |windows: &[Window]| -> Result<Vec<ScaledStates>> {
            let steps: Vec<usize> = windows.iter().map(|window| window.start).collect();
            let (inputs, start) = (&cut.inputs, protocol.start);
            let found = window_starts_with(steady, person, inputs, &steps, start, cut.mean_basal)?;
            Ok(found.states)
        };
        let (train, test) = (starts(&cut.train)?, starts(&cut.test)?);
        let rates = cut.train.iter().flat_map(|window| inputs_within(&cut.inputs, window));
        let heart_rate =
            HeartRateScaler::fit(rates.filter_map(|i| i.context.heart_rate_over_baseline))?;
        let course = course_of(person);
        Ok(Ok(Self { index, person, cut, course, heart_rate, train, test }))
    }

    fn network<'p>(&self, population: &'p Arc<PopulationModel>) -> ModulatedNetwork<'p> {
        let average = Kilograms(ode_sim::population::MEAN_WEIGHT);
        ModulatedNetwork::new(population, self.person.weight.unwrap_or(average))
    }

    /// Windows with the effects as inputs.
    fn prepared(
        &self,
        population: &Arc<PopulationModel>,
        windows: &[Window],
        starts: &[ScaledStates],
        active: &Active<'_>,
        inputs: InputSet,
    ) -> Result<Vec<PreparedWindow>> {
        let network = self.network(population);
        let each = windows.iter().zip(starts);
        each.map(|(window, start)| {
            let steps = inputs_within(&self.cut.inputs, window);
            Ok(PreparedWindow::under(
                population,
                steps.to_vec(),
                &measured(self.person, window)?,
                active.known(&network, start, window, steps)?,
                self.heart_rate.as_ref(),
                inputs,
            )?)
        })
        .collect()
    }

    /// Loss of the population network under effects on the training windows.
    fn loss_under(&self, population: &Arc<PopulationModel>, active: &Active<'_>) -> Result<f64> {
        let windows =
            self.prepared(population, &self.cut.train, &self.train, active, InputSet::None)?;
        Ok(window_loss(population, &ResidualNetwork::zeros(), &windows, TwinLoss::PAPER)?)
    }

    /// Trains and judges every kind.
    fn judged(
        &self,
        population: &Arc<PopulationModel>,
        acting: &[Acting],
        diagnosis: &Diagnosis,
        plan: &TrainingPlan,
        seed: u64,
    ) -> Result<Judged> {
        let amplitude =
            |acting: &Acting| amplitude(diagnosis, acting.effect.card().id.name(), &self.person.id);
        let effects = acting.iter().map(|a| (a.effect.as_ref(), a.variant, amplitude(a)));
        let (under, nothing) = (Active::new(&self.course, effects), Active::new(&self.course, []));
        let glucose: Result<Vec<Vec<f64>>, _> =
            self.cut.test.iter().map(|window| measured(self.person, window)).collect();
        let glucose = glucose?;
        let outcomes = |course: &[f64]| {
            let after = course[1..].iter();
            Outcomes::of(after.map(|g| MgPerDl(g.clamp(SENSOR.0, SENSOR.1))))
        };
        let actual: Result<Vec<Outcomes>, _> = glucose.iter().map(|g| outcomes(g)).collect();
        let mut kinds = Vec::with_capacity(KINDS.len());
        for kind in KINDS {
            let active = if kind.effect { &under } else { &nothing };
            let inputs = kind.residual.unwrap_or(InputSet::None);
            let network = match kind.residual {
                None => ResidualNetwork::zeros(),
                Some(_) => {
                    let windows =
                        self.prepared(population, &self.cut.train, &self.train, active, inputs)?;
                    // The same start and order for all kinds of a person.
                    let seed = seed.wrapping_mul(1_000_003).wrapping_add(self.index as u64);
                    let start = ResidualNetwork::untrained(seed);
                    train(population, start, &windows, &[], plan, seed)?.network
                }
            };
            let windows = self.prepared(population, &self.cut.test, &self.test, active, inputs)?;
            let courses = window_courses(population, &network, &windows)?;
            let (mut found, mut squares, mut samples) = (Vec::new(), 0.0, 0.0);
            for (course, glucose) in courses.iter().zip(&glucose) {
                let course: Vec<f64> =
                    course.iter().map(|g| g.0.clamp(SENSOR.0, SENSOR.1)).collect();
                found.push(outcomes(&course)?);
                for (simulated, measured) in course.iter().zip(glucose).skip(1) {
                    squares += (simulated - measured).powi(2);
                    samples += 1.0;
                }
            }
            kinds.push((Outcomes::average(&found)?, f64::sqrt(squares / samples)));
        }
        let windows = self.cut.test.len();
        Ok(Judged { windows, actual: Outcomes::average(&actual?)?, kinds })
    }
}

impl Found {
    fn new(
        judged: &[Judged],
        acting: &[Acting],
        left_out: BTreeMap<String, String>,
        diagnosis: &Diagnosis,
        seed: u64,
    ) -> Result<Self> {
        let effects = acting.iter().map(|acting| {
            let name = acting.effect.card().id.name();
            let found = diagnosis.effects.iter().find(|found| found.effect == name);
            let amplitudes: Vec<f64> =
                found.map_or_else(Vec::new, |f| f.people.iter().map(|p| p.amplitude).collect());
            InputEffect {
                effect: name.to_owned(),
                variant: acting.variant,
                mean_amplitude: amplitudes.iter().sum::<f64>() / (amplitudes.len().max(1)) as f64,
                gain_nats: found.map_or(0.0, |found| found.gain_nats),
            }
        });
        let actual: Vec<Outcomes> = judged.iter().map(|judged| judged.actual).collect();
        let rmse = |kind: usize| -> Vec<f64> { judged.iter().map(|j| j.kinds[kind].1).collect() };
        let mut kinds = Vec::with_capacity(KINDS.len());
        for (index, kind) in KINDS.iter().enumerate() {
            let simulated: Vec<Outcomes> = judged.iter().map(|j| j.kinds[index].0).collect();
            kinds.push(KindRow {
                name: kind.name,
                rmse_5h: Summary::of(&rmse(index))?,
                rows: compare_outcomes(&actual, &simulated, 0.05)?,
            });
        }
        let bootstrap = Bootstrap { replicates: 2000, level: 0.9, seed };
        let mut comparisons = Vec::new();
        for (with, without) in PAIRS {
            let found = paired::compare(&rmse(with), &rmse(without), &bootstrap)?;
            let interval = found.difference.bca.unwrap_or(found.difference.percentile);
            comparisons.push(ComparisonRow {
                with: KINDS[with].name,
                without: KINDS[without].name,
                value: found.difference.value,
                lower: interval.lower,
                upper: interval.upper,
                p: found.signed_rank.p,
            });
        }
        Ok(Self {
            schema: "effect-twins/1",
            effects: effects.collect(),
            left_out,
            people: judged.len(),
            windows: judged.iter().map(|judged| judged.windows).sum(),
            kinds,
            comparisons,
        })
    }

    fn text(&self) -> String {
        let mut text = format!("{} people, {} held-out windows\n", self.people, self.windows);
        for effect in &self.effects {
            let _ = writeln!(
                text,
                "input: {} (variant {}, mean amplitude {:.2}, {:.1} nats on the training days)",
                effect.effect, effect.variant, effect.mean_amplitude, effect.gain_nats
            );
        }
        for kind in &self.kinds {
            let sd = kind.rmse_5h.sd.unwrap_or(0.0);
            let _ =
                write!(text, "{:<30} RMSE {:5.1} \u{b1} {sd:4.1} ", kind.name, kind.rmse_5h.mean);
            for row in &kind.rows {
                let mark = if row.equivalent { "*" } else { "" };
                let _ = write!(
                    text,
                    " {} {:+.1} ({:.3}{mark})",
                    row.metric.name(),
                    row.difference.value,
                    row.p
                );
            }
            text.push('\n');
        }
        for row in &self.comparisons {
            let _ = writeln!(
                text,
                "{} minus {}: {:+.2} mg/dL ({:.2} to {:.2}), signed-rank p {:.3}",
                row.with, row.without, row.value, row.lower, row.upper, row.p
            );
        }
        text
    }
}
