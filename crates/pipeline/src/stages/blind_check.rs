//! `blind-check`: a diagnosis is asked for what it cannot know, and scored.
//!
//! Worlds are drawn and their labels sealed: the hashes are on disk before the first cohort. Each
//! cohort is then diagnosed by another process that is given a copy of its folder and nothing else.
//! Only when every answer is written are the labels opened, compared with the seal, and scored.

mod ceiling;
mod tables;

use std::path::PathBuf;

use anyhow::{Context as _, Result, bail};
use blind::ScoredWorld;
use contract::blind_check::{BlindCheck, Bound, Label};
use world::blind::{Plan, PlannedWorld, RealisedWorld};

use crate::asked::in_another_process;
use crate::bounds;
use crate::diagnosed::{Diagnosed, ODE};
use crate::labels::label;
use crate::stages::report;
use crate::stages::sealed::{SealedCheck, drawn_seed};
use crate::{Manifest, OutputFolder, Progress, note, table as print_table};

/// Settings of `blind-check`.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Worlds with one effect, two effects, or one outside the library; 28 if not
    /// given, 252 if `full`.
    pub worlds: Option<usize>,
    /// Worlds without an effect; 12 if not given, 150 if `full`.
    pub nulls: Option<usize>,
    /// As many worlds as it takes to test every target.
    pub full: bool,
    /// The plant that is asked: `ode`, or the file of a population model.
    pub model: String,
    /// Output folder.
    pub out: PathBuf,
    /// Seed of the worlds; a fresh one, which is said, if not given.
    pub seed: Option<u64>,
}

/// Worlds with an effect and without, of a check that takes minutes.
const QUICK: (usize, usize) = (28, 12);
/// The same of a whole check: each effect meets each shift twice, from two of the four hands, and no
/// more than six false alarms keep their upper limit below 8 %.
const FULL: (usize, usize) = (252, 150);
/// Most worlds of one check.
const MOST_WORLDS: usize = 10_000;

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    let (with_effects, without) = if args.full { FULL } else { QUICK };
    let worlds = args.worlds.unwrap_or(with_effects);
    let nulls = args.nulls.unwrap_or(without);
    bounds::worlds(("--worlds", worlds), ("--nulls", nulls), MOST_WORLDS)?;
    let seed = args.seed.unwrap_or_else(drawn_seed);
    let model = if args.model == ODE {
        args.model.clone()
    } else {
        // Whoever answers works in a folder of its own.
        if matches!(Diagnosed::read(&args.model, None)?, Diagnosed::Twins(..)) {
            bail!(
                "'{}' holds twins of people; made people have none: --model takes a population model",
                args.model
            );
        }
        std::path::absolute(&args.model)?.display().to_string()
    };
    note(format!("blind-check: {} worlds from --seed {seed}", worlds + nulls));
    let plan = Plan::check(worlds, nulls);
    let config = serde_json::json!({ "worlds": worlds, "nulls": nulls, "model": args.model });
    let manifest = Manifest::new("blind-check", config, Some(seed))
        .with_inputs((model != ODE).then_some(&args.model))?;
    let output = OutputFolder::begin(&args.out, manifest)?;
    let diagnose = in_another_process;
    let sealed = SealedCheck { kind: "world", seed, diagnose, output: &output };
    let (answered, worlds) = check(plan.worlds(seed), &model, &sealed)?;
    let mut scored = blind::score(seed, &answered).context("scoring the answers")?;
    // Exact courses go through the filter on the ODE: they are no ceiling of another plant.
    if model == ODE {
        scored = blind::with_ceiling(scored, ceiling::exact_courses(&sealed, &worlds)?)?;
    }
    write_scored(&scored, output)
}

/// Writes scores, tables and report of a check, finishes its folder, and says what was promised and found.
pub(super) fn write_scored(scored: &BlindCheck, output: OutputFolder) -> Result<()> {
    output.write_document(scored)?;
    output.write("tables.txt", tables::tables(scored).join("\n").as_bytes())?;
    report::write_into(output.path(), &output.manifest)?;
    let place = output.finish()?;
    say(scored);
    note(format!("blind-check: {}", place.join("report.html").display()));
    Ok(())
}

/// Seals the labels of the worlds, asks for an answer to each, and opens the labels. Returns both, and the worlds, in the
/// order of the check.
///
/// Writes `seal.json` before anything else, `cohorts/` and `answers/`, and at the end `labels.json`.
fn check(
    planned: Vec<PlannedWorld>,
    model: &str,
    sealed: &SealedCheck<'_>,
) -> Result<(Vec<ScoredWorld>, Vec<RealisedWorld>)> {
    let progress = Progress::begin("worlds", planned.len());
    let drawn = progress.each(planned.len(), |index| {
        let id = sealed.id(index);
        let lived = planned[index].realise().with_context(|| format!("world {id}"))?;
        // The days take too much memory to be kept; they are lived again where they are asked for.
        Ok((label(&id, &lived)?, lived.world))
    })?;
    let (labels, worlds): (Vec<Label>, Vec<RealisedWorld>) = drawn.into_iter().unzip();
    progress.finish(&format!("{} drawn", worlds.len()));

    let answers = sealed.answers(&labels, |index| {
        let world = &worlds[index];
        let lived = world.clone().live();
        let cohort = lived.with_context(|| format!("world {}", sealed.id(index)))?.cohort();
        // Nothing that answers a world has seen the hand that made it.
        let hand = world.planned.generator.name();
        Ok(sealed.answer(index, cohort, (model, Some(hand)))?.0)
    })?;
    let answered = labels.into_iter().zip(answers);
    Ok((answered.map(|(label, answer)| ScoredWorld { label, answer }).collect(), worlds))
}

/// The figures that were promised, a line each.
fn say(check: &BlindCheck) {
    for target in &check.targets {
        let sign = match target.bound {
            Bound::AtLeast => "at least",
            Bound::AtMost => "at most",
        };
        let percent = |x: f64| format!("{:.1} %", 100.0 * x);
        let value = target.value.map_or_else(|| "not tested".to_owned(), percent);
        let ends = match (target.lower, target.upper) {
            (Some(lower), Some(upper)) => format!(" ({} to {})", percent(lower), percent(upper)),
            _ => String::new(),
        };
        let met = if target.met == Some(false) { ": FALLS SHORT" } else { "" };
        let limit = percent(target.target);
        print_table(format!("  {}: {value}{ends}, {sign} {limit}{met}", target.says));
    }
    tables::tables(check).into_iter().for_each(print_table);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stages::checks_together;
    use crate::stages::sealed::checked;
    use world::blind::PlannedEffect;
    use world::{Effect, Generator, OutsideEffect};

    /// Four small worlds: none, one effect, two, and one outside the library.
    fn planned() -> Vec<PlannedWorld> {
        let named = |effect| (PlannedEffect::Named(effect), 10.0);
        let truths = [
            vec![named(Effect::Dawn)],
            Vec::new(),
            vec![(PlannedEffect::Outside(OutsideEffect::Stress), 10.0)],
            vec![named(Effect::SetAgeing), named(Effect::SlowMeals)],
        ];
        let drawn = Plan { nulls: 4, ..Plan::check(0, 0) }.worlds(1);
        let worlds = drawn.into_iter().zip(truths).map(|(drawn, effects)| PlannedWorld {
            effects,
            generator: Generator::Hovorka,
            people: 3,
            days: 7,
            ..drawn
        });
        worlds.collect()
    }

    #[test]
    fn answers_are_given_on_sealed_worlds_and_scored() {
        let parent = tempfile::tempdir().expect("a folder");
        let target = parent.path().join("check");
        let config = serde_json::json!({ "model": ODE });
        let manifest = Manifest::new("blind-check", config, Some(1));
        let output = OutputFolder::begin(&target, manifest).expect("new");
        let diagnose = crate::asked::in_this_process;
        let sealed = SealedCheck { kind: "world", seed: 1, diagnose, output: &output };
        let (answered, worlds) = check(planned(), ODE, &sealed).expect("answered");
        let courses = ceiling::exact_courses(&sealed, &worlds).expect("courses");
        let scored = blind::score(1, &answered).expect("countable");
        let scored = blind::with_ceiling(scored, courses).expect("countable");
        write_scored(&scored, output).expect("renamed");
        let again = checks_together::read(&target).expect("finished");
        let answers = |worlds: &[ScoredWorld]| -> Vec<_> {
            worlds.iter().map(|world| world.answer.clone()).collect()
        };
        assert_eq!(answers(&again.worlds), answers(&answered));
        assert_eq!(again.worlds[0].label.id, "1/world_0001");
        let rescored = blind::score(1, &again.worlds).expect("countable");
        let courses = again.courses.expect("of the ceiling");
        let rescored = blind::with_ceiling(rescored, courses).expect("countable");
        assert_eq!(tables::tables(&rescored), tables::tables(&scored));
        assert_eq!(rescored.targets, scored.targets);

        assert_eq!(scored.worlds.len(), 4);
        assert_eq!(scored.failed.count, 0, "{:?}", scored.worlds);
        assert_eq!(
            (scored.false_alarms.of, scored.pairs.worlds, scored.unknown.recalled.of),
            (1, 1, 1)
        );
        // Dawn has a morning; the pair and the effect outside the library have a truth of "where" too.
        let found = scored.localisation.as_ref().expect("a score");
        assert_eq!(found.context.iter().map(|c| c.comparable.of).collect::<Vec<_>>(), [3, 3, 3]);
        let found = scored.ceiling.as_ref().expect("a score");
        assert_eq!((found.named.of, found.false_alarms.of > 0), (1, true));
        assert!(
            tables::tables(&scored).iter().any(|line| line.contains("course at the true port"))
        );
        // What a diagnosis is given: two files, and no word of what acts. The schema names a channel
        // after what changes sets, and no effect.
        let words: Vec<&str> = PlannedEffect::all().map(PlannedEffect::name).collect();
        let labels = checked(&target, &words);
        let truth: Label = serde_json::from_str(&labels[0].label).expect("a label");
        assert_eq!((truth.id.as_str(), truth.has("dawn")), ("world_0001", true));
    }
}
