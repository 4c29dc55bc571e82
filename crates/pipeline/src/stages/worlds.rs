//! `worlds`: cohorts with known effects, with their labels beside them.
//!
//! For experiments and for tuning: nothing here is blind.

use std::path::PathBuf;

use anyhow::{Context as _, Result, ensure};
use cohort::{RecordsFormat, write_folder};
use contract::Document as _;
use contract::blind_check::{Label, Labels};
pub use world::Generator;
use world::Regime;
use world::blind::{Nuisances, Plan, PlannedEffect, PlannedWorld};

use crate::bounds;
use crate::labels::label;
use crate::{Manifest, OutputFolder, Progress};

/// How basal insulin is decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RegimeName {
    /// A pump that follows its programme.
    OpenLoop,
    /// Automated insulin delivery.
    ClosedLoop,
}

/// Settings of `worlds`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// What acts: an effect, two of them joined by `+`, or `none`.
    pub effect: String,
    /// Mean absolute shift of glucose that each effect is to cause, mg/dL.
    pub shift: f64,
    /// Generator of the bodies; all in turns if not given.
    pub generator: Option<Generator>,
    /// How basal insulin is decided; drawn if not given.
    pub regime: Option<RegimeName>,
    /// People in each world.
    pub people: usize,
    /// Days of each.
    pub days: usize,
    /// Missing heart rates, gaps, uneven days and unlogged set changes as in a blind check.
    pub nuisances: bool,
    /// Worlds.
    pub count: usize,
    /// In place of one effect: this many worlds with effects, mixed as in a blind check.
    pub mixture: Option<usize>,
    /// With `mixture`: worlds without an effect.
    pub nulls: usize,
    /// Output folder.
    pub out: PathBuf,
    /// Seed of the worlds.
    pub seed: u64,
}

/// Most worlds of one run.
const MOST_WORLDS: usize = 10_000;
/// Most people and days of a world.
const MOST_PEOPLE: usize = 1_000;
const MOST_DAYS: usize = 366;

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    let planned = plan(args)?;
    let config = serde_json::json!({
        "effect": args.effect,
        "shift_mg_dl": args.shift,
        "generator": args.generator.map(Generator::name),
        "regime": args.regime,
        "people": args.people,
        "days": args.days,
        "nuisances": args.nuisances,
        "mixture": args.mixture,
        "nulls": args.nulls,
        "count": args.count,
    });
    let manifest = Manifest::new("worlds", config, Some(args.seed));
    let output = OutputFolder::begin(&args.out, manifest)?;
    let progress = Progress::begin("worlds", planned.len());
    let labels = progress.each(planned.len(), |place| {
        let id = format!("{:03}", place + 1);
        let lived = planned[place].realise().with_context(|| format!("world {id}"))?;
        let folder = output.path().join(&id).join("cohort");
        write_folder(&lived.cohort(), &folder, RecordsFormat::Parquet)
            .with_context(|| format!("world {id}"))?;
        let label = label(&id, &lived)?;
        output.write_document_as(&format!("{id}/{}", Label::FILE), &label)?;
        Ok(label)
    })?;
    output.write_document(&Labels(labels))?;
    let place = output.finish()?;
    progress.finish(&format!("{} worlds in {}", planned.len(), place.display()));
    Ok(())
}

/// The worlds that were asked for.
fn plan(args: &Settings) -> Result<Vec<PlannedWorld>> {
    ensure!((0.1..=100.0).contains(&args.shift), "--shift {} must be from 0.1 to 100", args.shift);
    for (name, value, most) in [
        ("--count", args.count, MOST_WORLDS),
        ("--people", args.people, MOST_PEOPLE),
        ("--days", args.days, MOST_DAYS),
    ] {
        bounds::within(name, value, 1, most)?;
    }
    if let Some(worlds) = args.mixture {
        bounds::worlds(("--mixture", worlds), ("--nulls", args.nulls), MOST_WORLDS)?;
        let mut plan = Plan::check(worlds, args.nulls);
        if let Some(generator) = args.generator {
            plan.generators = vec![generator];
        }
        return Ok(plan.worlds(args.seed));
    }
    let effects = effects(&args.effect, args.shift)?;
    // A plan draws seeds, dates and therapy.
    let plan = Plan { nulls: args.count, ..Plan::check(0, 0) };
    let worlds =
        plan.worlds_with(&effects, args.seed).into_iter().enumerate().map(|(index, drawn)| {
            PlannedWorld {
                generator: args.generator.unwrap_or(Generator::ALL[index % Generator::ALL.len()]),
                regime: args.regime.map_or(drawn.regime, |regime| match regime {
                    RegimeName::OpenLoop => Regime::OpenLoopPump,
                    RegimeName::ClosedLoop => Regime::Aid,
                }),
                people: args.people,
                days: args.days,
                nuisances: if args.nuisances { drawn.nuisances } else { Nuisances::default() },
                ..drawn
            }
        });
    Ok(worlds.collect())
}

/// The effects of `NAME`, `NAME+NAME` or `none`.
fn effects(names: &str, shift: f64) -> Result<Vec<(PlannedEffect, f64)>> {
    if names == "none" {
        return Ok(Vec::new());
    }
    let split: Vec<&str> = names.split('+').collect();
    ensure!(
        split.len() <= 2 && (split.len() < 2 || split[0] != split[1]),
        "--effect {names}: give one effect, or two that differ"
    );
    split
        .into_iter()
        .map(|name| {
            let effect = PlannedEffect::from_name(name).with_context(|| {
                let known: Vec<&str> = PlannedEffect::all().map(PlannedEffect::name).collect();
                let known = known.join(", ");
                format!("--effect: there is no effect '{name}'; give none or one of {known}")
            })?;
            Ok((effect, shift))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effects_are_named_alone_and_together() {
        assert_eq!(effects("none", 5.0).expect("known"), []);
        let two = effects("dawn+illness", 5.0).expect("known");
        assert_eq!(two.iter().map(|(e, _)| e.name()).collect::<Vec<_>>(), ["dawn", "illness"]);
        let error = effects("dusk", 5.0).expect_err("unknown").to_string();
        assert!(error.contains("'dusk'") && error.contains("compression_lows"), "{error}");
    }
}
