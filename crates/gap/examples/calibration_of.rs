//! Prints the personal calibration of everybody in some cohorts, and how it stands up to a changed record.
//!
//!     cargo run -p gap --example calibration_of -- [--strikes N] [--seed N] [--days N] [--halves] COHORT...
//!
//! A cohort is a folder, or `hupa-ucm:FOLDER` or `t1d-uom:FOLDER` for the files of a study as they are
//! published. For each person who has insulin and carbohydrate on record: the logarithms of the six factors with their
//! posterior standard deviations, whether the calibration converged and which factors are beyond what bodies are,
//! then how far each factor moves, in its own posterior standard deviations, when one meal in twenty is
//! struck from the log (`--strikes` times, 5 unless told, each with other meals; the largest move is shown). With
//! `--halves` the two halves of the record are calibrated on their own as well; their difference in standard deviations of
//! a difference is about 1 where posterior standard deviations are honest. `--days` takes that much of each record.

use std::fmt::Write as _;
use std::path::Path;

use cohort::{Channel, Cohort, ImportFormat, Person, import};
use gap::filter::augmented::AugmentedModel;
use gap::filter::calibration::{Calibration, FACTORS, Factor, calibrate};
use gap::quality::{exclusion, findings};
use gap::{DiagnosisConfig, GapError, Observations};
use ode_sim::OdeParameters;
use physiology::STEPS_PER_DAY;
use rand::seq::index::sample;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// One meal in this many is struck from a log.
const ONE_IN: usize = 20;

struct Request {
    strikes: u64,
    seed: u64,
    days: Option<usize>,
    halves: bool,
    folders: Vec<String>,
}

impl Request {
    fn of_arguments() -> Result<Self, Box<dyn std::error::Error>> {
        let mut request =
            Self { strikes: 5, seed: 1, days: None, halves: false, folders: Vec::new() };
        let mut arguments = std::env::args().skip(1);
        while let Some(argument) = arguments.next() {
            let mut number = || arguments.next().ok_or("a number is missing");
            match argument.as_str() {
                "--strikes" => request.strikes = number()?.parse()?,
                "--seed" => request.seed = number()?.parse()?,
                "--days" => request.days = Some(number()?.parse()?),
                "--halves" => request.halves = true,
                _ => request.folders.push(argument),
            }
        }
        Ok(request)
    }
}

/// What is printed of a person, and what is summed over people.
struct Row {
    text: String,
    at_bound: bool,
    converged: bool,
    /// Each factor's largest move over strikes, posterior standard deviations.
    moves: Vec<f64>,
    /// Each factor's difference between halves, standard deviations of a difference.
    halves: Option<[f64; FACTORS]>,
}

fn cohort_of(name: &str) -> Result<Cohort, cohort::CohortError> {
    let study = |format, folder: &str| import(format, Path::new(folder)).map(|found| found.cohort);
    match name.split_once(':') {
        Some(("hupa-ucm", folder)) => study(ImportFormat::HupaUcm, folder),
        Some(("t1d-uom", folder)) => study(ImportFormat::T1dUom, folder),
        _ => cohort::read_folder(Path::new(name)),
    }
}

fn calibrated(person: &Person) -> Result<Calibration, GapError> {
    let config = DiagnosisConfig::working();
    let record = Observations::from_person(person)?;
    let population = AugmentedModel::new(OdeParameters::nominal(), record.weight, config.noise);
    calibrate(&population, &record, &config.calibration)
}

/// The person without one logged meal in twenty, at least one.
fn struck(person: &Person, meals: &[usize], rng: &mut ChaCha8Rng) -> Person {
    let mut struck = person.clone();
    let carbs = struck.record.channel_mut(Channel::Carbs);
    let count = ((meals.len() + ONE_IN / 2) / ONE_IN).clamp(1, meals.len());
    for index in sample(rng, meals.len(), count) {
        carbs[meals[index]] = Some(0.0);
    }
    struck
}

fn halves(person: &Person) -> Option<[Person; 2]> {
    let steps = person.record.len();
    let middle = steps / (2 * STEPS_PER_DAY) * STEPS_PER_DAY;
    let part = |range| Some(Person { record: person.record.slice(range)?, ..person.clone() });
    Some([part(0..middle)?, part(middle..steps)?])
}

fn row(person: &Person, request: &Request, index: usize) -> Result<Option<Row>, GapError> {
    let mut person = person.clone();
    if let Some(part) = request
        .days
        .and_then(|days| person.record.slice(0..person.record.len().min(days * STEPS_PER_DAY)))
    {
        person.record = part;
    }
    let doses = |channel| -> Vec<usize> {
        let given = person.record.channel(channel).iter().enumerate();
        given
            .filter(|(_, dose)| dose.is_some_and(|dose| dose > 0.0))
            .map(|(step, _)| step)
            .collect()
    };
    let meals = doses(Channel::Carbs);
    if meals.is_empty() || doses(Channel::Bolus).is_empty() && doses(Channel::Basal).is_empty() {
        return Ok(None);
    }
    let quality = findings(&person, &Observations::from_person(&person)?);
    let found = calibrated(&person)?;
    let mut moves = vec![0.0_f64; FACTORS];
    let mut unsettled = 0;
    for strike in 0..request.strikes {
        let mut rng = ChaCha8Rng::seed_from_u64(request.seed);
        rng.set_stream((index as u64) << 32 | strike);
        let _: u64 = rng.random();
        let again = calibrated(&struck(&person, &meals, &mut rng))?;
        unsettled += usize::from(!again.converged);
        for (k, largest) in moves.iter_mut().enumerate() {
            *largest = largest.max((again.factors.0[k] - found.factors.0[k]).abs() / found.sd[k]);
        }
    }
    let mut text = format!(
        "{} ({} days, {} meals): {}converged in {}, scale {:.2}{}{}\n",
        person.id,
        person.record.len() / STEPS_PER_DAY,
        meals.len(),
        if found.converged { "" } else { "NOT " },
        found.iterations,
        found.scale,
        if unsettled > 0 { format!(", {unsettled} strikes not converged") } else { String::new() },
        exclusion(&quality).map(|reason| format!(", excluded: {reason}")).unwrap_or_default(),
    );
    let mut line = |name: &str, value: &dyn Fn(usize) -> String| {
        let _ = write!(text, "  {name:<12}");
        for k in 0..FACTORS {
            let _ = write!(text, "{:>9}", value(k));
        }
        text.push('\n');
    };
    line("log factor", &|k| {
        let bound = if found.at_bound.contains(&Factor::ALL[k]) { "!" } else { "" };
        format!("{:.2}{bound}", found.factors.0[k])
    });
    line("SD", &|k| format!("{:.3}", found.sd[k]));
    if request.strikes > 0 {
        line("move, SD", &|k| format!("{:.2}", moves[k]));
    }
    let apart = if request.halves {
        halves(&person)
            .map(|[first, second]| -> Result<[f64; FACTORS], GapError> {
                let (a, b) = (calibrated(&first)?, calibrated(&second)?);
                Ok(std::array::from_fn(|k| {
                    (a.factors.0[k] - b.factors.0[k]) / a.sd[k].hypot(b.sd[k])
                }))
            })
            .transpose()?
    } else {
        None
    };
    if let Some(apart) = apart {
        line("halves, SD", &|k| format!("{:.2}", apart[k]));
    }
    Ok(Some(Row {
        text,
        at_bound: !found.at_bound.is_empty(),
        converged: found.converged,
        moves,
        halves: apart,
    }))
}

#[expect(clippy::print_stdout, reason = "an example shows its result")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let request = Request::of_arguments()?;
    let mut people = Vec::new();
    for folder in &request.folders {
        people.extend(cohort_of(folder)?.people);
    }
    let rows: Vec<Option<Row>> = people
        .par_iter()
        .enumerate()
        .map(|(index, person)| row(person, &request, index))
        .collect::<Result<_, _>>()?;
    let rows: Vec<Row> = rows.into_iter().flatten().collect();
    let names: String = Factor::ALL.iter().map(|f| format!("{:>9}", format!("{f:?}"))).collect();
    println!("{:<14}{names}", "");
    for row in &rows {
        print!("{}", row.text);
    }
    let count = |of: &dyn Fn(&Row) -> bool| rows.iter().filter(|row| of(row)).count();
    println!(
        "{} people: {} at a bound, {} not converged, {} with a move above 1 SD (largest {:.2})",
        rows.len(),
        count(&|row| row.at_bound),
        count(&|row| !row.converged),
        count(&|row| row.moves.iter().any(|m| *m > 1.0)),
        rows.iter().flat_map(|row| row.moves.iter().copied()).fold(0.0, f64::max),
    );
    let apart: Vec<[f64; FACTORS]> = rows.iter().filter_map(|row| row.halves).collect();
    if !apart.is_empty() {
        let rms = |k: usize| {
            (apart.iter().map(|z| z[k].powi(2)).sum::<f64>() / apart.len() as f64).sqrt()
        };
        let all: String = (0..FACTORS).map(|k| format!("{:>9.2}", rms(k))).collect();
        println!("{:<14}{all}", "halves, RMS");
    }
    Ok(())
}
