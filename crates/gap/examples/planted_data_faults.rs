//! Plants wrong units, flags and mixed-up sensors in people's records and counts what the
//! data-quality checks find.
//!
//! `cargo run -p gap --example planted_data_faults -- COHORT_FOLDER...` reads cohort folders; without
//! arguments the open records of the reference folder and the embedded cohort.

use std::time::Instant;

use cohort::{Channel, Cohort, ImportFormat, Person, import};
use gap::Observations;
use gap::quality::{Consequence, Finding, findings};

/// A fault: its name, the check that must find it, and what it does to a record.
type Fault = (&'static str, &'static str, fn(&mut Person));

fn change(person: &mut Person, channel: Channel, new: impl Fn(usize, f64) -> f64) {
    for (k, value) in person.record.channel_mut(channel).iter_mut().enumerate() {
        *value = value.map(|value| new(k, value));
    }
}

fn scale(person: &mut Person, channel: Channel, factor: f64) {
    change(person, channel, |_, value| value * factor);
}

/// Keeps every third CGM value and draws lines between.
fn draw_over_15_minutes(person: &mut Person) {
    let old = person.record.cgm().to_vec();
    for (k, value) in person.record.channel_mut(Channel::Cgm).iter_mut().enumerate() {
        let (before, part) = (k / 3 * 3, (k % 3) as f64 / 3.0);
        let ends = old[before].zip(old.get(before + 3).copied().flatten());
        *value = ends.map(|(from, to)| from + part * (to - from));
    }
}

const FAULTS: [Fault; 16] =
    [
        ("carbohydrate in servings of 10 g", "carb_unit", |p| scale(p, Channel::Carbs, 0.1)),
        ("carbohydrate in servings of 12 g", "carb_unit", |p| scale(p, Channel::Carbs, 1.0 / 12.0)),
        ("carbohydrate in servings of 15 g", "carb_unit", |p| scale(p, Channel::Carbs, 1.0 / 15.0)),
        ("carbohydrate in mg", "carb_unit", |p| scale(p, Channel::Carbs, 1000.0)),
        ("boluses as flags", "dose_is_flag", |p| {
            change(p, Channel::Bolus, |_, dose| f64::from(u8::from(dose > 0.0)));
        }),
        ("meals as flags", "dose_is_flag", |p| {
            change(p, Channel::Carbs, |_, dose| f64::from(u8::from(dose > 0.0)));
        }),
        ("basal in U per 5 min", "basal_unit", |p| scale(p, Channel::Basal, 1.0 / 12.0)),
        ("basal twelve times too high", "basal_unit", |p| scale(p, Channel::Basal, 12.0)),
        ("basal in U per 5 min from day 5 on", "basal_unit", |p| {
            let days = p.record.len() / 288;
            let from = days.min(10) / 2 * 288;
            change(p, Channel::Basal, |k, rate| if k >= from { rate / 12.0 } else { rate });
        }),
        ("boluses in mU", "plausible_day", |p| scale(p, Channel::Bolus, 1000.0)),
        ("all insulin in mU", "plausible_day", |p| {
            scale(p, Channel::Bolus, 1000.0);
            scale(p, Channel::Basal, 1000.0);
        }),
        ("two sensors, 20 mg/dL apart, on 4 days", "interleaved_cgm", |p| {
            change(p, Channel::Cgm, |k, glucose| {
                if k < 4 * 288 && k % 2 == 1 { glucose + 20.0 } else { glucose }
            });
        }),
        ("two sensors of 15 min, 60 mg/dL apart, on 4 days", "interleaved_cgm", |p| {
            change(p, Channel::Cgm, |k, glucose| {
                if k < 4 * 288 && (k / 3) % 2 == 1 { glucose + 60.0 } else { glucose }
            });
            draw_over_15_minutes(p);
        }),
        ("finger sticks at boluses", "capillary_in_cgm", |p| {
            let doses = p.record.bolus().to_vec();
            change(p, Channel::Cgm, |k, glucose| {
                let before = &doses[k.saturating_sub(12)..k];
                let first = before.iter().flatten().all(|dose| *dose <= 0.3);
                let dosed = doses[k].is_some_and(|dose| dose > 0.3);
                if first && dosed { glucose + 70.0 } else { glucose }
            });
        }),
        ("heart rate of other hours", "heart_rate_alignment", |p| {
            let old = p.record.heart_rate().to_vec();
            let n = old.len().max(1);
            for (k, value) in p.record.channel_mut(Channel::HeartRate).iter_mut().enumerate() {
                *value = old[(k * 7919) % n];
            }
        }),
        ("heart rate two hours late", "heart_rate_alignment", |p| {
            p.record.channel_mut(Channel::HeartRate).rotate_right(24);
        }),
    ];

fn quality(person: &Person) -> Vec<Finding> {
    let Ok(observations) = Observations::from_person(person) else { return Vec::new() };
    findings(person, &observations)
}

/// Findings that are not about what was never recorded, or was drawn by the source.
fn doubts(person: &Person) -> Vec<Finding> {
    let known = ["missing_channel", "interpolated_cgm"];
    let mut found = quality(person);
    found.retain(|finding| !known.contains(&finding.reported.check.as_str()));
    found
}

#[expect(clippy::print_stdout, reason = "an example shows its result")]
fn report(name: &str, people: &[Person], verbose: bool) {
    let clock = Instant::now();
    let clean: Vec<Vec<Finding>> = people.iter().map(doubts).collect();
    let days: usize = people.iter().map(|p| p.record.len() / 288).sum();
    let pace = 1000.0 * clock.elapsed().as_secs_f64() * 14.0 / days.max(1) as f64;
    println!("{name}: {} people, {days} days, {pace:.1} ms per 14 days", people.len());
    for found in clean.iter().flatten() {
        let Finding { reported, consequence } = found;
        println!(
            "  clean {}, {consequence:?}: {}: {}",
            reported.person_id, reported.check, reported.finding
        );
    }
    for (fault, check, plant) in FAULTS {
        let (mut planted, mut found, mut other, mut excluded) = (0, 0, 0, 0);
        for person in people {
            let mut faulty = person.clone();
            plant(&mut faulty);
            if faulty == *person {
                continue;
            }
            planted += 1;
            let doubts = doubts(&faulty);
            let named = doubts.iter().any(|f| f.reported.check == check);
            found += usize::from(named);
            other += usize::from(!named && !doubts.is_empty());
            excluded += usize::from(doubts.iter().any(|f| f.consequence != Consequence::Note));
            if verbose || !named {
                for f in &doubts {
                    println!(
                        "    {fault}, {}: {}: {}",
                        person.id, f.reported.check, f.reported.finding
                    );
                }
            }
            if !named {
                println!("    {fault}, {}: not found by {check}", person.id);
            }
        }
        println!(
            "  {fault}: {planted} planted, {found} found by {check}, {other} by another check alone, {excluded} left out"
        );
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
            if let Some(folder) = reference_data::find(name, "planted data faults") {
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
