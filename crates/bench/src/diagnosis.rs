//! `bench --what diagnosis`: how fast a diagnosis is, and how time and memory grow with the cohort.
//!
//! Virtual people are made first, which is not counted. Cohorts of a quarter, a half and all of them are
//! then diagnosed as `diagnose` does it, from the quality checks to the verdict and what adding the named
//! effects changes. Times are of the clock: they hold for the machine and the load of the moment.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::hint::black_box;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context as _, Result, ensure};
use chrono::NaiveDate;
use cohort::{Cohort, Person};
use contract::Document as _;
use contract::bench::{DiagnosisBench, DiagnosisRow, Part};
use gap::design::design;
use gap::filter::augmented::AugmentedModel;
use gap::filter::calibration::calibrate;
use gap::filter::kalman::filter;
use gap::{CalibratedPerson, Diagnoser, DiagnosisConfig, Observations, quality, which};
use ode_sim::OdeParameters;
use rayon::prelude::*;
use world::blind::PlannedEffect;
use world::{Amplitudes, Calendar, Generator, Regime, VirtualPerson};

use pipeline::bounds::within;
use pipeline::usage::{peak_mib, processor_seconds};
use pipeline::{Manifest, OutputFolder, Progress, note};

/// Whom to diagnose.
#[derive(Debug, Clone)]
pub struct Settings {
    /// People of the largest cohort; a quarter and half of them are diagnosed before.
    pub people: usize,
    /// Days of each.
    pub days: usize,
    /// What acts in everybody: an effect, or `none`. Every effect that is named costs another round.
    pub effect: String,
    /// Its amplitude; 1 is the published size.
    pub amplitude: f64,
    /// Output folder.
    pub out: PathBuf,
    /// Seed of the people and of the bootstrap.
    pub seed: u64,
}

/// Most people and days.
const MOST_PEOPLE: usize = 20_000;
const MOST_DAYS: usize = 366;
/// Largest amplitude: beyond, few bodies can live with an effect.
const LARGEST_AMPLITUDE: f64 = 6.0;
/// People whose parts are timed one by one.
const TIMED: usize = 8;
/// Fewest days of a record that is diagnosed.
const FEWEST_DAYS: usize = 4;
/// The speed that is aimed at: 1,000 people of 14 days in a minute on two cores, per core.
const TARGET_PERSON_DAYS_PER_CORE_SECOND: f64 = 1000.0 * 14.0 / 60.0 / 2.0;

/// Times diagnoses and writes `bench.json` and `bench.txt`.
pub fn run(args: &Settings) -> Result<()> {
    within("--people", args.people, 1, MOST_PEOPLE)?;
    within("--days", args.days, FEWEST_DAYS, MOST_DAYS)?;
    ensure!(
        (0.0..=LARGEST_AMPLITUDE).contains(&args.amplitude),
        "--amplitude {} must be from 0 to {LARGEST_AMPLITUDE}",
        args.amplitude
    );
    let amplitudes = amplitudes(&args.effect, args.amplitude)?;
    let threads = rayon::current_num_threads();
    let config = serde_json::json!({
        "people": args.people,
        "days": args.days,
        "effect": args.effect,
        "amplitude": args.amplitude,
        "threads": threads,
        "diagnosis": DiagnosisConfig::working(),
    });
    let output = OutputFolder::begin(&args.out, Manifest::new("bench", config, Some(args.seed)))?;
    let mut cohort = Cohort { people: people(args, amplitudes)? };
    // One person after the other on one thread.
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let parts = one.install(|| parts(&cohort.people[..TIMED.min(args.people)]))?;
    pipeline::table(parts_text(&parts));
    let mut others = cohort.people.split_off(0).into_iter();
    let mut rows: Vec<DiagnosisRow> = Vec::new();
    for size in sizes(args.people) {
        let more = size - cohort.people.len();
        cohort.people.extend(others.by_ref().take(more));
        rows.push(row(&cohort, args.seed)?);
    }
    let table = rows_text(&rows, args.days, threads);
    output.write("bench.txt", format!("{}\n{table}\n", parts_text(&parts)).as_bytes())?;
    output.write_document(&DiagnosisBench {
        days: args.days,
        effect: args.effect.clone(),
        parts,
        rows,
        schema: DiagnosisBench::SCHEMA.to_owned(),
        threads,
    })?;
    let place = output.finish()?;
    pipeline::table(table);
    note(format!("bench: {}", place.join(DiagnosisBench::FILE).display()));
    Ok(())
}

/// A quarter, a half and all of the people.
fn sizes(people: usize) -> Vec<usize> {
    [people / 4, people / 2, people].into_iter().filter(|size| *size > 0).collect()
}

/// What acts in everybody.
fn amplitudes(name: &str, amplitude: f64) -> Result<Amplitudes> {
    if name == "none" {
        return Ok(Amplitudes::NONE);
    }
    let effect = PlannedEffect::from_name(name).with_context(|| {
        format!("--effect: there is no effect '{name}'; give none or the name of one")
    })?;
    Ok(effect.set(Amplitudes::NONE, amplitude))
}

/// People of both generators and both regimes in turns; bodies that fail are passed over.
fn people(args: &Settings, amplitudes: Amplitudes) -> Result<Vec<Person>> {
    let start = NaiveDate::from_ymd_opt(2024, 1, 8).context("a date")?;
    let calendar = Calendar::new(start, args.days);
    let progress = Progress::begin("bench", args.people);
    let lived = |index: usize| -> Option<Person> {
        let generator = Generator::ALL[index % 2];
        let regime = if (index / 2).is_multiple_of(2) { Regime::Aid } else { Regime::OpenLoopPump };
        let person = VirtualPerson::sample_from(generator, args.seed, index, regime).ok()?;
        let days = VirtualPerson { amplitudes, ..person }.live(calendar).ok()?;
        progress.advance("people made");
        Some(days.recorded)
    };
    let mut people: Vec<Person> = (0..args.people).into_par_iter().filter_map(lived).collect();
    let spare = (args.people..args.people * 2).filter_map(lived);
    let missing = args.people - people.len();
    people.extend(spare.take(missing));
    ensure!(
        people.len() == args.people,
        "too few bodies can live with this; use a lower --amplitude"
    );
    progress.finish(&format!("{} people of {} days made", people.len(), args.days));
    Ok(people)
}

fn row(cohort: &Cohort, seed: u64) -> Result<DiagnosisRow> {
    let people = cohort.people.len();
    let progress = Progress::begin("bench", people);
    let (clock, before) = (Instant::now(), processor_seconds());
    let (library, config) = (effects::library(), DiagnosisConfig::working());
    let advance = |_, _| progress.advance("people calibrated");
    let diagnosis = Diagnoser::new(&library, &config)
        .progress(&advance)
        .run(cohort, seed)
        .context("the diagnosis")?;
    let seconds = clock.elapsed().as_secs_f64();
    let row = DiagnosisRow {
        people,
        seconds,
        people_per_second: people as f64 / seconds,
        processor_seconds: processor_seconds().zip(before).map(|(after, before)| after - before),
        peak_mib: peak_mib(),
        verdict: diagnosis.verdict,
        effects: diagnosis.effects.into_iter().map(|found| found.effect).collect(),
        excluded: diagnosis.people.iter().filter(|person| person.excluded.is_some()).count(),
    };
    progress.finish(&format!("{people} people diagnosed"));
    Ok(row)
}

/// What the parts of a diagnosis cost.
fn parts(people: &[Person]) -> Result<Vec<Part>> {
    let config = DiagnosisConfig::working();
    let library = effects::library();
    let every: Vec<_> = library.iter().map(AsRef::as_ref).collect();
    let mut parts = Vec::new();
    let mut clock = Instant::now();
    let mut done = |part: &str| {
        let milliseconds_per_person = clock.elapsed().as_secs_f64() * 1e3 / people.len() as f64;
        parts.push(Part { part: part.to_owned(), milliseconds_per_person });
        clock = Instant::now();
    };
    let records = people
        .iter()
        .map(|person| {
            let observations = Observations::from_person(person)?;
            black_box(quality::findings(person, &observations));
            Ok(observations)
        })
        .collect::<Result<Vec<_>>>()?;
    done("quality");
    let calibrated = records
        .iter()
        .map(|record| {
            let nominal = OdeParameters::nominal();
            let population = AugmentedModel::new(nominal, record.weight, config.noise);
            Ok(calibrate(&population, record, &config.calibration)?)
        })
        .collect::<Result<Vec<_>>>()?;
    done("calibration");
    for (record, found) in records.iter().zip(&calibrated) {
        filter(&found.model, record)?;
    }
    done("filter");
    let input = |((person, observations), calibration)| CalibratedPerson {
        person,
        observations,
        calibration,
    };
    let inputs: Vec<CalibratedPerson<'_>> =
        people.iter().zip(&records).zip(&calibrated).map(input).collect();
    for person in &inputs {
        design(person, &every)?;
    }
    done("design");
    let asked = (&*inputs, inputs.len());
    which(asked, &library, gap::working_posterior(), &config.calibration, &|_| BTreeMap::new())?;
    done("which, with a design for each round");
    Ok(parts)
}

fn parts_text(parts: &[Part]) -> String {
    let mut text = String::from("One person on one thread, ms:");
    for part in parts {
        let _ = write!(text, "\n  {:<36} {:>9.1}", part.part, part.milliseconds_per_person);
    }
    text
}

fn rows_text(rows: &[DiagnosisRow], days: usize, threads: usize) -> String {
    let mut text = format!("Diagnoses of people of {days} days on {threads} threads:\n");
    text.push_str("  people   seconds  people/s  CPU s/person  peak MiB  MiB/person  answer");
    for row in rows {
        let (people, peak) = (row.people as f64, row.peak_mib.unwrap_or(f64::NAN));
        let processor = row.processor_seconds.unwrap_or(f64::NAN) / people;
        let answer = if row.effects.is_empty() {
            format!("{:?}", row.verdict).to_lowercase()
        } else {
            row.effects.join(", ")
        };
        let _ = write!(
            text,
            "\n{:>8} {:>9.1} {:>9.2} {processor:>13.4} {peak:>9.0} {:>11.2}  {answer}",
            row.people,
            row.seconds,
            row.people_per_second,
            peak / people,
        );
    }
    if let Some(last) = rows.last() {
        let speed = last.people_per_second * days as f64 / threads as f64;
        let _ = write!(
            text,
            "\n{speed:.1} person-days a second and thread; the target is {TARGET_PERSON_DAYS_PER_CORE_SECOND:.1}",
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cohorts_double() {
        assert_eq!(sizes(1000), [250, 500, 1000]);
        assert_eq!(sizes(3), [1, 3]);
        assert_eq!(sizes(1), [1]);
    }

    #[test]
    fn effects_are_known_by_name() {
        assert_eq!(amplitudes("none", 1.0).expect("known"), Amplitudes::NONE);
        let dawn = amplitudes("dawn", 1.5).expect("known");
        assert_eq!(dawn.acting().collect::<Vec<_>>(), [("dawn", 1.5)]);
        assert!(amplitudes("dusk", 1.0).is_err());
    }
}
