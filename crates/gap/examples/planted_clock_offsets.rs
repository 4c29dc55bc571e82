//! Moves the clocks of people's doses and counts how often the data-quality checks find it.
//!
//! `cargo run -p gap --example planted_clock_offsets -- COHORT_FOLDER...` reads cohort folders; without
//! arguments the open records of the reference folder and the embedded cohort. Records are cut into
//! stretches of 14 days or, at the end, up to 21.

use std::time::Instant;

use cohort::{Channel, Cohort, ImportFormat, Person, import};
use gap::Observations;
use gap::quality::{Finding, findings};

/// What the clock of a pump stamps.
const INSULIN: [Channel; 2] = [Channel::Basal, Channel::Bolus];
/// What the clock of a log stamps.
const MEALS: [Channel; 1] = [Channel::Carbs];

/// The person with some channels recorded `steps` later than they are, from step `from` on.
fn late(person: &Person, channels: &[Channel], steps: isize, since: usize) -> Person {
    let mut moved = person.clone();
    for channel in channels {
        let old = person.record.channel(*channel);
        for (k, value) in moved.record.channel_mut(*channel).iter_mut().enumerate() {
            if k < since {
                continue;
            }
            let from = k.checked_add_signed(-steps).filter(|from| *from < old.len());
            *value = match from {
                Some(from) => old[from],
                None if *channel == Channel::Basal => old[k],
                None => old[k].map(|_| 0.0),
            };
        }
    }
    moved
}

/// Stretches of 14 days in which every dose channel of the record is recorded.
fn stretches(person: &Person) -> Vec<Person> {
    let record = &person.record;
    let meals = record.carbs().iter().any(Option::is_some);
    let recorded =
        |k: usize| record.bolus()[k].is_some() && (!meals || record.carbs()[k].is_some());
    let first = (0..record.len()).find(|k| recorded(*k)).unwrap_or(record.len());
    let last = (0..record.len()).rfind(|k| recorded(*k)).map_or(first, |k| k + 1);
    let mut found = Vec::new();
    let mut start = first;
    while last - start >= 7 * 288 {
        let end = if last - start < 21 * 288 { last } else { start + 14 * 288 };
        if let Some(record) = record.slice(start..end) {
            let id = format!("{}/{}", person.id, start / 288);
            found.push(Person { id, record, ..person.clone() });
        }
        start = end;
    }
    found
}

fn clock_findings(person: &Person) -> Vec<Finding> {
    let Ok(observations) = Observations::from_person(person) else { return Vec::new() };
    let found = findings(person, &observations);
    found.into_iter().filter(|f| f.reported.check.ends_with("clock_offset")).collect()
}

/// What came of one planted offset.
#[derive(Default, Clone, Copy)]
struct Tally {
    planted: usize,
    named: usize,
    either: usize,
    misnamed: usize,
    missed: usize,
    within_10: usize,
    covered: usize,
}

#[expect(clippy::print_stdout, reason = "an example shows its result")]
fn judge(tally: &mut Tally, found: &[Finding], planted: &[(&str, f64)], verbose: &str) {
    tally.planted += 1;
    let of = |check: &str| found.iter().find(|f| f.reported.check == check);
    let right: Vec<_> =
        planted.iter().filter_map(|(check, min)| Some((of(check)?, *min))).collect();
    let checks: std::collections::BTreeSet<&str> =
        found.iter().map(|f| f.reported.check.as_str()).collect();
    if found.is_empty() {
        tally.missed += 1;
    } else if right.len() < planted.len() {
        tally.misnamed += 1;
    } else if checks.len() > planted.len() {
        tally.either += 1;
    } else {
        tally.named += 1;
    }
    let estimates: Vec<_> =
        right.iter().filter_map(|(f, min)| Some((f.reported.estimate.clone()?, *min))).collect();
    if right.len() == planted.len() {
        tally.within_10 +=
            usize::from(estimates.iter().all(|(e, min)| (e.value - min).abs() <= 10.0));
        tally.covered +=
            usize::from(estimates.iter().all(|(e, min)| (e.lower..=e.upper).contains(min)));
    }
    if !verbose.is_empty() {
        println!("   {verbose}");
        for f in found {
            let e = f.reported.estimate.as_ref();
            println!("      {} {:?}", f.reported.check, e.map(|e| (e.value, e.lower, e.upper)));
        }
    }
}

#[expect(clippy::print_stdout, reason = "an example shows its result")]
fn report(name: &str, people: &[Person], verbose: bool) {
    let stretches: Vec<Person> = people.iter().flat_map(stretches).collect();
    let clock = Instant::now();
    let clean: Vec<Vec<Finding>> = stretches.iter().map(clock_findings).collect();
    let seconds = clock.elapsed().as_secs_f64();
    let days: usize = stretches.iter().map(|p| p.record.len() / 288).sum();
    println!(
        "{name}: {} stretches, {days} days, {:.1} ms per 14 days",
        stretches.len(),
        1000.0 * seconds * 14.0 / days.max(1) as f64
    );
    let alarms = clean.iter().filter(|found| !found.is_empty()).count();
    println!("  clean: {alarms} with a finding");
    for (person, found) in stretches.iter().zip(&clean) {
        for f in found {
            println!("    {}: {} {:?}", person.id, f.reported.finding, f.reported.estimate);
        }
    }
    let both = [Channel::Basal, Channel::Bolus, Channel::Carbs];
    for (what, channels, half) in [
        ("insulin", &INSULIN[..], false),
        ("meals", &MEALS, false),
        ("both", &both, false),
        ("insulin from the middle on", &INSULIN, true),
        ("meals from the middle on", &MEALS, true),
    ] {
        for minutes in [30_isize, 60, 90, 120] {
            let mut tally = Tally::default();
            for person in &stretches {
                if person.record.carbs().iter().all(Option::is_none) && channels != INSULIN {
                    continue;
                }
                for sign in [1, -1] {
                    let planted = sign * minutes;
                    let since = if half { person.record.len() / 2 } else { 0 };
                    let found = clock_findings(&late(person, channels, planted / 5, since));
                    let planted = planted as f64;
                    let checks: &[(&str, f64)] = match what.split(' ').next().unwrap_or(what) {
                        "insulin" => &[("insulin_clock_offset", planted)],
                        "meals" => &[("meal_clock_offset", planted)],
                        _ => &[("insulin_clock_offset", planted), ("meal_clock_offset", planted)],
                    };
                    let label = if verbose {
                        format!("{} {what} {planted}", person.id)
                    } else {
                        String::new()
                    };
                    judge(&mut tally, &found, checks, &label);
                }
            }
            let Tally { planted, named, either, misnamed, missed, within_10, covered } = tally;
            println!(
                "  {what} {minutes:>3} min: {planted} planted, {named} named, {either} as either clock, \
                 {misnamed} misnamed, {missed} missed; {within_10} within 10 min, {covered} covered"
            );
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut folders: Vec<String> = std::env::args().skip(1).collect();
    let verbose = folders.iter().any(|f| f == "-v");
    folders.retain(|f| f != "-v");
    if folders.is_empty() {
        for (format, name) in
            [(ImportFormat::HupaUcm, "hupa_ucm"), (ImportFormat::T1dUom, "t1d_uom")]
        {
            if let Some(folder) = reference_data::find(name, "planted clock offsets") {
                report(name, &import(format, &folder)?.cohort.people, verbose);
            }
        }
        let embedded = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/embedded/cohort");
        folders.push(embedded.to_owned());
    }
    for folder in folders {
        let Cohort { people } = cohort::read_folder(folder.as_ref())?;
        report(&folder, &people, verbose);
    }
    Ok(())
}
