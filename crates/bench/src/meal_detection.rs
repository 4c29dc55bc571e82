//! `bench --what meals`: how well meals are detected and logs reconciled where the truth is known.
//!
//! People of both generators live two weeks each: without any effect, with meals left out of the log,
//! with miscounted carbohydrate, and with every effect of the library at once. The truth is what they ate
//! and drank against lows; what was eaten within half an hour is one meal. Thresholds were chosen with
//! the seed 90210 (decision 0020) and are measured with others.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context as _, Result};
use chrono::NaiveDate;
use cohort::Person;
use contract::Document as _;
use contract::bench::{Condition, MealRow, MealsBench};
use meals::reconcile::{ReconcileSettings, Rule, reconcile};
use meals::score::{Eaten, Tally, Tolerance, sittings};
use meals::{Detected, Detector, GridSettings, PlantSettings};
use rayon::prelude::*;
use world::{Amplitudes, Calendar, Effect, Generator, Regime, VirtualPerson};

use pipeline::{Manifest, OutputFolder, Progress};

/// People of each world, and their days.
const PEOPLE: usize = 16;
const DAYS: usize = 14;
/// Amplitude of missed meals: three times the published one, 21 % of meals.
const MISSED: f64 = 3.0;
/// Thresholds of the detector on the plant that are compared, nats.
const THRESHOLDS: [f64; 7] = [2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0];

/// What acts in the worlds of each generator.
const CONDITIONS: [Condition; 4] =
    [Condition::NoEffect, Condition::MissedMeals, Condition::CarbMiscount, Condition::EveryEffect];

const fn name(condition: Condition) -> &'static str {
    match condition {
        Condition::NoEffect => "no effect",
        Condition::MissedMeals => "missed meals",
        Condition::CarbMiscount => "carb miscount",
        Condition::EveryEffect => "every effect",
    }
}

/// The amplitudes of a person whose own, where everything acts, are `own`.
fn amplitudes(condition: Condition, own: Amplitudes) -> Amplitudes {
    match condition {
        Condition::NoEffect => Amplitudes::NONE,
        Condition::MissedMeals => Amplitudes::NONE.with(Effect::MissedMeals, MISSED),
        Condition::CarbMiscount => Amplitudes::NONE.with(Effect::CarbMiscount, 1.0),
        Condition::EveryEffect => own,
    }
}

/// A person and what they truly ate.
struct Lived {
    person: Person,
    truth: Vec<Eaten>,
}

/// Scores detectors and rules and writes `bench.json` and `bench.txt` into the folder `out`.
pub fn run(out: &Path, seed: u64) -> Result<()> {
    let plant = PlantSettings::working();
    let config = serde_json::json!({
        "what": "meals", "people": PEOPLE, "days": DAYS, "missed_meals": MISSED,
        "plant": format!("{plant:?}"), "grid": format!("{:?}", GridSettings::published()),
        "tolerance_steps": [Tolerance::usual().early, Tolerance::usual().late],
    });
    let output = OutputFolder::begin(out, Manifest::new("bench", config, Some(seed)))?;
    let (mut detectors, mut logs, mut thresholds) = (Vec::new(), Vec::new(), Vec::new());
    let progress = Progress::begin("bench", Generator::ALL.len() * CONDITIONS.len());
    for generator in Generator::ALL {
        let mut at_threshold = THRESHOLDS.map(|_| Tally::default());
        for condition in CONDITIONS {
            let people = people(generator, condition, seed)?;
            let row = |what: &str, found: Tally| MealRow {
                generator: generator.name().to_owned(),
                condition: Some(condition),
                what: what.to_owned(),
                score: found.score(),
            };
            let by_grid = detect(&people, &Detector::Grid(GridSettings::published()))?;
            let by_plant = detect(&people, &Detector::Plant(plant))?;
            detectors.push(row("grid", tally(&people, &claims(&by_grid))));
            detectors.push(row("plant", tally(&people, &claims(&by_plant))));
            for (threshold, sum) in THRESHOLDS.into_iter().zip(&mut at_threshold) {
                let found =
                    detect(&people, &Detector::Plant(PlantSettings { threshold, ..plant }))?;
                *sum = std::mem::take(sum).merge(tally(&people, &claims(&found)));
            }
            let logged: Vec<Vec<Eaten>> = people.iter().map(|lived| log(&lived.person)).collect();
            logs.push(row("as logged", tally(&people, &logged)));
            for (what, rule, found) in [
                ("published, grid", Rule::Published, &by_grid),
                ("published, plant", Rule::Published, &by_plant),
                ("additive, plant", Rule::Additive, &by_plant),
            ] {
                logs.push(row(what, tally(&people, &reconciled(&people, found, rule)?)));
            }
            progress.advance(&format!("{} {}", generator.name(), name(condition)));
        }
        thresholds.extend(THRESHOLDS.into_iter().zip(at_threshold).map(|(nats, sum)| MealRow {
            generator: generator.name().to_owned(),
            condition: None,
            what: format!("plant at {nats} nats"),
            score: sum.score(),
        }));
    }
    let text = format!(
        "Meals found, {PEOPLE} people of {DAYS} days a world:\n{}\n\nLogs against what was eaten:\n{}\n\n\
         Thresholds of the detector on the plant:\n{}\n",
        detector_text(&detectors),
        log_text(&logs),
        detector_text(&thresholds)
    );
    output.write_document(&MealsBench {
        days: DAYS,
        detectors,
        logs,
        people: PEOPLE,
        schema: MealsBench::SCHEMA.to_owned(),
        thresholds,
        what: "meals".to_owned(),
    })?;
    let place = output.finish_with_table("bench.txt", &text)?;
    progress.finish(&place.join(MealsBench::FILE).display().to_string());
    Ok(())
}

/// The people of a world, both regimes in turns; bodies that fail are passed over.
fn people(generator: Generator, condition: Condition, seed: u64) -> Result<Vec<Lived>> {
    let start = NaiveDate::from_ymd_opt(2024, 1, 8).context("a date")?;
    let calendar = Calendar::new(start, DAYS);
    let lived = |index: usize| -> Option<Lived> {
        let regime = if index.is_multiple_of(2) { Regime::Aid } else { Regime::OpenLoopPump };
        let person = VirtualPerson::sample_from(generator, seed, index, regime).ok()?;
        let amplitudes = amplitudes(condition, person.amplitudes);
        let days = VirtualPerson { amplitudes, ..person }.live(calendar).ok()?;
        let eaten = days.inputs.iter().map(|input| input.carbs.0 + input.rescue.amount.0);
        Some(Lived { truth: sittings(eaten), person: days.recorded })
    };
    let people: Vec<Lived> = (0..PEOPLE).into_par_iter().filter_map(lived).collect();
    anyhow::ensure!(
        2 * people.len() > PEOPLE,
        "only {} of {PEOPLE} bodies can live in the world '{}' of {}; use another --seed",
        people.len(),
        name(condition),
        generator.name()
    );
    Ok(people)
}

fn detect(people: &[Lived], detector: &Detector) -> Result<Vec<Detected>> {
    let found = people.par_iter().map(|lived| detector.detect(&lived.person));
    Ok(found.collect::<Result<_, _>>()?)
}

fn reconciled(people: &[Lived], found: &[Detected], rule: Rule) -> Result<Vec<Vec<Eaten>>> {
    let settings = ReconcileSettings::new(rule);
    let one = |(lived, found): (&Lived, &Detected)| -> Result<Vec<Eaten>> {
        Ok(log(&reconcile(&lived.person, found, &settings)?.person))
    };
    people.iter().zip(found).map(one).collect()
}

/// What a person's log says was eaten.
fn log(person: &Person) -> Vec<Eaten> {
    sittings(person.record.carbs().iter().map(|carbs| carbs.unwrap_or(0.0)))
}

fn claims(found: &[Detected]) -> Vec<Vec<Eaten>> {
    let of_one = |found: &Detected| {
        found.meals.iter().map(|m| Eaten { step: m.step, carbs: m.carbs }).collect()
    };
    found.iter().map(of_one).collect()
}

fn tally(people: &[Lived], claimed: &[Vec<Eaten>]) -> Tally {
    let tallies = people.iter().zip(claimed).map(|(lived, claimed)| {
        Tally::of(&lived.truth, claimed, lived.person.record.len(), Tolerance::usual())
    });
    tallies.fold(Tally::default(), Tally::merge)
}

/// A share in per cent.
fn percent(share: Option<f64>) -> String {
    share.map_or_else(|| "-".to_owned(), |share| format!("{:.0}", 100.0 * share))
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
}

fn label(row: &MealRow) -> String {
    let condition = row.condition.map_or("all", name);
    format!("{:<8} {:<14} {:<17}", row.generator, condition, row.what)
}

fn detector_text(rows: &[MealRow]) -> String {
    let mut text = format!(
        "{:<41} found %  of <20 g  20-40  40-70  70+   right %  false/day  min late (quartiles)  \
         bias g  error g   %  on board g",
        ""
    );
    for row in rows {
        let s = &row.score;
        let of = |place: usize| percent(s.classes.get(place).and_then(|class| class.sensitivity));
        let (time, size) = (s.time, s.size);
        let quartiles = time.map_or_else(
            || "-".to_owned(),
            |t| format!("{:.0} ({:.0} to {:.0})", t.median, t.lower_quartile, t.upper_quartile),
        );
        let _ = write!(
            text,
            "\n{} {:>7} {:>9} {:>6} {:>6} {:>4} {:>9} {:>10} {:>21} {:>7} {:>8} {:>3} {:>11}",
            label(row),
            percent(s.sensitivity),
            of(0),
            of(1),
            of(2),
            of(3),
            percent(s.precision),
            number(s.false_per_day, 2),
            quartiles,
            number(size.map(|size| size.bias_g), 1),
            number(size.map(|size| size.mean_absolute_g), 1),
            number(size.map(|size| size.mean_absolute_percent), 0),
            size.map_or_else(|| "-".to_owned(), |_| number(s.on_board_error_g, 2)),
        );
    }
    text
}

fn log_text(rows: &[MealRow]) -> String {
    let mut text = format!(
        "{:<41} in the log %  carbs explained %  invented %  |min off|  bias g  error g  on board g",
        ""
    );
    for row in rows {
        let (s, size) = (&row.score, row.score.size);
        let _ = write!(
            text,
            "\n{} {:>12} {:>18} {:>11} {:>10} {:>7} {:>8} {:>11}",
            label(row),
            percent(s.sensitivity),
            percent(s.explained),
            percent(s.invented),
            number(s.time.map(|time| time.median_absolute), 0),
            number(size.map(|size| size.bias_g), 1),
            number(size.map(|size| size.mean_absolute_g), 1),
            number(s.on_board_error_g, 2),
        );
    }
    text
}
