//! `effect-twins`: twins whose plant has the effects that the diagnosis names, beside twins that must
//! absorb them.
//!
//! The diagnosis sees the training days alone. Amplitudes are its own, person by person; which variant of an
//! effect acts is chosen on the training windows. Every kind of twin is then trained on these and judged on
//! the days after.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context as _, Result, ensure};
use contract::effect_twins::{InputEffect, KindComparison, KindRow};
use contract::{Document as _, EffectTwins};
use gap::{Diagnoser, Diagnosis, DiagnosisConfig};
use rayon::prelude::*;
use stats::{Bootstrap, Outcome, Outcomes, compare_outcomes, paired, summary};
use twins::SteadyStates;

use crate::files::read_population;
use crate::people::People;
use crate::stages::twin;
use crate::{Manifest, OutputFolder, Profile, Progress, note};
use ::report::count;
use plants::effect_twins::{Judged, KINDS, Subject, acting, resting_as_in_training, training_days};
use plants::{Acting, check_wiring};

/// Settings of `effect-twins`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Cohort folder.
    pub cohort: PathBuf,
    /// Population model.
    pub model: PathBuf,
    /// How much to compute.
    pub profile: Profile,
    /// Output folder.
    pub out: PathBuf,
    /// Seed of weights, order, folds and bootstrap.
    pub seed: u64,
}

/// Fewest people over whom methods are compared.
const FEWEST_PEOPLE: usize = 2;

/// Level of the one-sided tests.
const LEVEL: f64 = 0.05;

/// Which kinds differ by the effect alone.
const PAIRS: [(usize, usize); 3] = [(1, 0), (3, 2), (5, 4)];

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    let config = serde_json::json!({ "profile": args.profile });
    let manifest = Manifest::new("effect-twins", config, Some(args.seed))
        .with_input(&args.cohort)?
        .with_model(&args.model)?;
    let in_use = People::read(&args.cohort)?;
    let (protocol, plan) = twin::protocol(args.profile, None);
    let cohort = resting_as_in_training(&in_use.used(), &protocol);
    let population = Arc::new(read_population(&args.model)?);
    check_wiring(&population)
        .with_context(|| format!("'{}' cannot take effects as inputs", args.model.display()))?;
    let output = OutputFolder::begin(&args.out, manifest)?;
    in_use.write(&output)?;

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
        "people with complete windows in both parts: {}; a comparison needs {FEWEST_PEOPLE}",
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
    let found = found(&judged, &acting, left_out, &diagnosis, args.seed)?;
    let text = text(&found);
    output.write_document(&found)?;
    let place = output.finish_with_table("effect_twins.txt", &text)?;
    let people = count(judged.len(), "person", "people");
    progress.finish(&format!("{people}, {}", place.display()));
    Ok(())
}

fn found(
    judged: &[Judged],
    acting: &[Acting],
    left_out: BTreeMap<String, String>,
    diagnosis: &Diagnosis,
    seed: u64,
) -> Result<EffectTwins> {
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
            name: kind.name.to_owned(),
            rmse_5h: summary(&rmse(index))?,
            rows: compare_outcomes(&actual, &simulated, LEVEL)?,
        });
    }
    let bootstrap = Bootstrap { replicates: 2000, level: 0.9, seed };
    let mut comparisons = Vec::new();
    for (with, without) in PAIRS {
        let found = paired::compare(&rmse(with), &rmse(without), &bootstrap)?;
        let interval = found.difference.bca.unwrap_or(found.difference.percentile);
        comparisons.push(KindComparison {
            with: KINDS[with].name.to_owned(),
            without: KINDS[without].name.to_owned(),
            value: found.difference.value,
            lower: interval.lower,
            upper: interval.upper,
            p: found.signed_rank.p,
        });
    }
    Ok(EffectTwins {
        schema: EffectTwins::SCHEMA.to_owned(),
        effects: effects.collect(),
        left_out,
        people: judged.len(),
        windows: judged.iter().map(|judged| judged.windows).sum(),
        kinds,
        comparisons,
    })
}

fn text(of: &EffectTwins) -> String {
    let mut text = format!(
        "{}, {}\n",
        count(of.people, "person", "people"),
        count(of.windows, "held-out window", "held-out windows")
    );
    for effect in &of.effects {
        let _ = writeln!(
            text,
            "input: {} (variant {}, mean amplitude {:.2}, {:.1} nats on the training days)",
            effect.effect, effect.variant, effect.mean_amplitude, effect.gain_nats
        );
    }
    for kind in &of.kinds {
        let sd = kind.rmse_5h.sd.unwrap_or(0.0);
        let _ = write!(text, "{:<30} RMSE {:5.1} \u{b1} {sd:4.1} ", kind.name, kind.rmse_5h.mean);
        for row in &kind.rows {
            let mark = if row.equivalent { "*" } else { "" };
            let _ = write!(
                text,
                " {} {:+.1} ({:.3}{mark})",
                outcome_name(&row.metric),
                row.difference.value,
                row.p
            );
        }
        text.push('\n');
    }
    for row in &of.comparisons {
        let _ = writeln!(
            text,
            "{} minus {}: {:+.2} mg/dL ({:.2} to {:.2}), signed-rank p {:.3}",
            row.with, row.without, row.value, row.lower, row.upper, row.p
        );
    }
    text
}

/// The field's abbreviation of an outcome.
fn outcome_name(key: &str) -> &str {
    Outcome::ALL
        .into_iter()
        .find(|outcome| outcome.key() == key)
        .map_or(key, |outcome| outcome.name())
}
