//! `blind-check --planted COHORT`: effects planted into real people's records, each cohort diagnosed apart.
//!
//! The labels are sealed before the first cohort is written. Cohorts stand under neutral names in a drawn
//! order, the record as it is among them; each is diagnosed by another process that is given a copy of its
//! folder. Only when every answer is written are the labels opened, compared with the seal, and scored.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};
use blind::{AnsweredCohort, NOTHING};
use cohort::{Cohort, read_folder};
use contract::Document as _;
use contract::blind_check::{
    CalibratedPeople, PlantedCheck, PlantedLabel, PlantedTotals, Share, Verdict,
};
use gap::undone;
use rand::seq::SliceRandom as _;
use rayon::prelude::*;
use world::planted::{Exactness, Happenings, Planting, Truth, plant};

use super::sealed::{SealedCheck, drawn_seed, stream};
use crate::asked::in_another_process;
use crate::diagnosed::ODE;
use crate::{Manifest, OutputFolder, note};
use ::report::count;

/// Settings of a check of effects that are planted into real records.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Cohort of real people.
    pub cohort: PathBuf,
    /// Multiples of each effect's usual size; 1 and 2 if there are none.
    pub sizes: Vec<f64>,
    /// Output folder.
    pub out: PathBuf,
    /// Seed of what is planted; a fresh one, which is said, if not given.
    pub seed: Option<u64>,
}

/// Multiples of each planting's usual size, unless others are asked for.
const TIMES: [f64; 2] = [1.0, 2.0];
/// Largest multiple: four meals in five, a gain that is gone in ten days.
const MOST_TIMES: f64 = 5.0;

/// What is planted into one cohort; `None` is the record as it is.
type What = Option<(Planting, f64)>;

/// Runs the command.
pub fn run(args: &Settings) -> Result<()> {
    let folder = args.cohort.as_path();
    let seed = args.seed.unwrap_or_else(drawn_seed);
    let times = if args.sizes.is_empty() { TIMES.to_vec() } else { args.sizes.clone() };
    for times in &times {
        ensure!(
            *times > 0.0 && *times <= MOST_TIMES,
            "--sizes {times}: a multiple of the usual size, above 0 and up to {MOST_TIMES}"
        );
    }
    let cohort = read_folder(folder).with_context(|| format!("reading '{}'", folder.display()))?;
    let people = count(cohort.people.len(), "person", "people");
    note(format!("blind-check: planted into {people} with --seed {seed}"));
    let config = config(folder, &times);
    let manifest = Manifest::new("blind-check", config, Some(seed)).with_input(folder)?;
    let output = OutputFolder::begin(&args.out, manifest)?;
    let diagnose = in_another_process;
    let sealed = SealedCheck { kind: "cohort", seed, diagnose, output: &output };
    let answered = check(&cohort, &plantings(&times), &sealed)?;
    let scored = blind::planted_check(seed, &answered).context("scoring the answers")?;
    output.write_document(&scored)?;
    let table = table(&scored);
    let place = output.finish_with_table("planted.md", &table)?;
    note(format!("blind-check: {}", place.join(PlantedCheck::FILE).display()));
    Ok(())
}

/// What the manifest says; a path need not be text.
fn config(folder: &Path, times: &[f64]) -> serde_json::Value {
    serde_json::json!({ "planted": folder.display().to_string(), "sizes": times })
}

/// The record as it is, and every planting at every size.
fn plantings(times: &[f64]) -> Vec<What> {
    let of = |planting: Planting| {
        let times = if planting.has_sizes() { times } else { &TIMES[..1] };
        times.iter().map(move |times| Some((planting, times * planting.usual_size().0)))
    };
    std::iter::once(None).chain(Planting::ALL.into_iter().flat_map(of)).collect()
}

/// Seals, writes, asks, opens. Writes `seal.json` first, then `cohorts/` and `answers/`, and `labels.json` at
/// the end.
fn check(
    cohort: &Cohort,
    plantings: &[What],
    sealed: &SealedCheck<'_>,
) -> Result<Vec<AnsweredCohort>> {
    let planted = |(planting, size)| plant(cohort, planting, size, sealed.seed);
    let mut order: Vec<(What, usize)> = plantings
        .par_iter()
        .map(|what| (*what, what.map_or(0, |what| planted(what).changed)))
        .collect();
    order.retain(|(what, changed)| match what {
        Some((planting, _)) if *changed == 0 => {
            note(format!("  {}: nothing in these records that it could change", planting.name()));
            false
        }
        _ => true,
    });
    order.shuffle(&mut stream(sealed.seed, 3, 0));
    let labels = order.iter().enumerate();
    let labels: Vec<PlantedLabel> =
        labels.map(|(index, (what, changed))| label(sealed.id(index), *what, *changed)).collect();
    let likelihoods = undone::log_likelihoods(cohort);
    sealed.answers(&labels, |index| {
        let planted = order[index].0.map(planted);
        let gains = planted.as_ref().and_then(|planted| {
            let gain = undone::gain(cohort, &likelihoods, &planted.cohort)?;
            let at_best = planted.happenings.map_or(gain, |Happenings { count, places }| {
                undone::without_knowing_where(count, places, gain)
            });
            Some((gain, at_best))
        });
        let asked = planted.map_or_else(|| cohort.clone(), |planted| planted.cohort);
        let (answer, calibrated) = sealed.answer(index, asked, (ODE, None))?;
        let (undone_nats, at_best_nats) = gains.unzip();
        let label = labels[index].clone();
        Ok(AnsweredCohort { label, answer, calibrated, undone_nats, at_best_nats })
    })
}

fn label(id: String, what: What, changed: usize) -> PlantedLabel {
    let mut label = PlantedLabel {
        id,
        planting: NOTHING.to_owned(),
        effect: None,
        evidence_lost: Vec::new(),
        size: 0.0,
        unit: String::new(),
        inexact: String::new(),
        changed,
    };
    if let Some((planting, size)) = what {
        label.planting = planting.name().to_owned();
        (label.size, label.unit) = (size, planting.usual_size().1.to_owned());
        match planting.truth() {
            Truth::Effect(name) => label.effect = Some(name.to_owned()),
            Truth::OutsideTheLibrary => {}
            Truth::EvidenceLost(names) => {
                label.evidence_lost = names.iter().map(|name| (*name).to_owned()).collect();
            }
        }
        if let Exactness::OfAnotherShape(how) = planting.exactness() {
            label.inexact = how.to_owned();
        }
    }
    label
}

/// The check in a table of Markdown.
fn table(check: &PlantedCheck) -> String {
    let mut text = String::from(
        "| planted | size | entries changed | undone, nats | at best, nats | named | evidence, nats | up by 3 | new names | ill calibrated |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    let people =
        |calibrated: &CalibratedPeople| format!("{} of {}", calibrated.ill, calibrated.people);
    let said = |verdict: Verdict, named: &[String]| match (verdict, named) {
        (Verdict::None, _) => "none".to_owned(),
        (Verdict::Unknown, _) => "unknown".to_owned(),
        (Verdict::Failed, _) => "failed".to_owned(),
        (Verdict::Effect, named) => named.join(", "),
    };
    let named: Vec<String> =
        check.as_it_is.found.iter().map(|found| found.effect.clone()).collect();
    let mut line = |cells: [String; 10]| {
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    };
    line([
        "nothing".to_owned(),
        String::new(),
        "0".to_owned(),
        String::new(),
        String::new(),
        said(check.as_it_is.verdict, &named),
        String::new(),
        String::new(),
        String::new(),
        people(&check.calibrated_as_it_is),
    ]);
    for row in &check.cohorts {
        let nats = |nats: Option<f64>| nats.map_or_else(|| "-".to_owned(), |x| format!("{x:.1}"));
        let evidence = row.evidence.iter().map(|pair| {
            let which =
                if row.evidence.len() > 1 { format!("{} ", pair.effect) } else { String::new() };
            format!("{which}{} to {}", nats(pair.before), nats(pair.after))
        });
        line([
            row.label.planting.clone(),
            format!("{} {}", short(row.label.size), row.label.unit),
            row.label.changed.to_string(),
            nats(row.undone_nats),
            nats(row.at_best_nats),
            said(row.verdict, &row.named),
            evidence.collect::<Vec<_>>().join("; "),
            if row.risen { "yes" } else { "" }.to_owned(),
            row.strangers.join(", "),
            people(&row.calibrated),
        ]);
    }
    text.push_str(
        "\n| | named | named, not so before | or in its set | up by 3 nats | another name anew | at best 6 nats |\n\
         |---|---|---|---|---|---|---|\n",
    );
    let totals = [&check.all].into_iter().chain(&check.by_size).chain(&check.by_effect);
    for totals in totals {
        let PlantedTotals { what, named, named_anew, named_or_in_set, risen, strangers, tellable } =
            totals;
        let shares = [named, named_anew, named_or_in_set, risen, strangers, tellable].map(share);
        let _ = writeln!(text, "| {what} | {} |", shares.join(" | "));
    }
    let _ = write!(
        text,
        "\nAnother name anew, whatever was planted or struck: {}\n\
         Evidence gone with what signals it: {}\n\
         People whose calibration ends at a bound or does not converge: {}; as it is {}\n\
         Failed: {}",
        share(&check.strangers),
        share(&check.evidence_gone),
        share(&check.ill_calibrated),
        people(&check.calibrated_as_it_is),
        share(&check.failed),
    );
    text
}

/// A number without digits that say nothing.
fn short(size: f64) -> String {
    format!("{size:.3}").trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn share(share: &Share) -> String {
    match share.value {
        None => "not tested".to_owned(),
        Some(_) => format!(
            "{} of {} ({:.0} to {:.0} %)",
            share.count,
            share.of,
            100.0 * share.lower,
            100.0 * share.upper
        ),
    }
}

#[cfg(test)]
mod tests {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt as _;

    use super::*;
    use crate::stages::sealed::checked;
    use cohort::Person;

    /// Five days of two people of the embedded cohort.
    fn few() -> Cohort {
        let folder = crate::workspace_root().join("fixtures/embedded/cohort");
        let people = read_folder(&folder).expect("the embedded cohort reads").people;
        let days = |person: Person| {
            let record = person.record.slice(0..5 * 288).expect("inside the record");
            Person { record, ..person }
        };
        Cohort { people: people.into_iter().take(2).map(days).collect() }
    }

    #[test]
    fn planted_cohorts_are_sealed_answered_and_scored() {
        let parent = tempfile::tempdir().expect("a folder");
        let target = parent.path().join("check");
        let manifest = Manifest::new("blind-check", serde_json::json!({}), Some(1));
        let output = OutputFolder::begin(&target, manifest).expect("new");
        let asked = [
            None,
            Some((Planting::MissedMeals, 1.0)),
            Some((Planting::SensorDrift, 0.2)),
            Some((Planting::SleepStruck, 1.0)),
            // Nobody logs the carbohydrate of a low with a share of nothing.
            Some((Planting::UnloggedRescueCarbs, 0.0)),
        ];
        let diagnose = crate::asked::in_this_process;
        let sealed = SealedCheck { kind: "cohort", seed: 1, diagnose, output: &output };
        let answered = check(&few(), &asked, &sealed).expect("answered");
        let scored = blind::planted_check(1, &answered).expect("countable");
        let target = output.finish().expect("renamed");

        assert_eq!((answered.len(), scored.cohorts.len()), (4, 3));
        assert_eq!((scored.failed.count, scored.all.named.of), (0, 2));
        assert!(answered.iter().all(|cohort| cohort.calibrated.people == 2));
        for row in &scored.cohorts {
            let (undone, at_best) = (row.undone_nats, row.at_best_nats);
            assert_eq!(undone.is_some(), at_best.is_some());
            assert!(undone.zip(at_best).is_none_or(|(gain, best)| best <= gain), "{row:?}");
            let meals = row.label.planting == Planting::MissedMeals.name();
            assert!(!meals || at_best.is_some(), "the log is what was changed");
        }
        // Neutral names, and no word of what was planted.
        checked(&target, &Planting::ALL.map(Planting::name));
        let table = table(&scored);
        assert!(table.contains("| missed_meals | 1 meals a day |"), "{table}");
    }

    #[test]
    fn a_path_that_is_no_text_is_said_too() {
        let path = Path::new(OsStr::from_bytes(b"people\xff"));
        let config = config(path, &[1.0]);
        assert!(config["planted"].as_str().is_some_and(|said| said.starts_with("people")));
    }

    #[test]
    fn every_planting_comes_at_every_size_and_channels_once() {
        let listed = plantings(&[0.5, 1.0, 3.0]);
        let sized = Planting::ALL.into_iter().filter(|planting| planting.has_sizes()).count();
        assert_eq!(listed.len(), 1 + 3 * sized + (Planting::ALL.len() - sized));
        assert!(listed.contains(&Some((Planting::SensorLag, 18.0))));
        assert_eq!((short(0.1 * 2.0), short(30.0)), ("0.2".to_owned(), "30".to_owned()));
    }
}
