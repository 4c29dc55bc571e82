//! Prints what the parts of a diagnosis cost: milliseconds for a person of 14 days.
//!
//!     cargo run -p gap --example speed [-- REPEATS]
//!
//! The people are those of the embedded cohort. Each part runs `REPEATS` times (10 unless told) on one
//! thread; the mean is printed, in processor time where the system tells it (Linux), else by the clock.

use std::path::Path;
use std::time::Instant;

use gap::design::design;
use gap::filter::augmented::AugmentedModel;
use gap::filter::calibration::calibrate;
use gap::filter::kalman::filter;
use gap::{CalibratedPerson, DiagnosisConfig, Observations};
use ode_sim::OdeParameters;
use physiology::STEPS_PER_DAY;

/// Milliseconds that this thread has run.
fn now(start: Instant) -> f64 {
    let statistics = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = statistics.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| start.elapsed().as_secs_f64() * 1e3, |time| time * 1e-6)
}

/// Milliseconds of a run, and its result.
fn timed<T>(repeats: u32, mut run: impl FnMut() -> T) -> (f64, T) {
    let clock = Instant::now();
    let start = now(clock);
    let mut result = run();
    for _ in 1..repeats {
        result = run();
    }
    ((now(clock) - start) / f64::from(repeats), result)
}

#[expect(clippy::print_stdout, reason = "an example shows its result")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let repeats = std::env::args().nth(1).map_or(Ok(10), |n| n.parse())?;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/embedded/cohort");
    let cohort = cohort::read_folder(&folder)?;
    let config = DiagnosisConfig::working();
    let owned = effects::library();
    let library: Vec<&dyn effects::Effect> = owned.iter().map(AsRef::as_ref).collect();
    let mut sums = [0.0; 3];
    println!("person     filter  calibrate     design  ms of 14 days; then iterations, columns");
    for person in &cohort.people {
        let mut person = person.clone();
        let steps = person.record.len().min(14 * STEPS_PER_DAY);
        person.record = person.record.slice(0..steps).ok_or("an empty record")?;
        let share = steps as f64 / (14 * STEPS_PER_DAY) as f64;
        let record = Observations::from_person(&person)?;
        let population = AugmentedModel::new(OdeParameters::nominal(), record.weight, config.noise);
        let (calibrating, found) =
            timed(repeats, || calibrate(&population, &record, &config.calibration));
        let found = found?;
        let (filtering, run) = timed(repeats, || filter(&found.model, &record));
        run?;
        let calibrated =
            CalibratedPerson { person: &person, observations: &record, calibration: &found };
        let (designing, made) = timed(repeats, || design(&calibrated, &library));
        let made = made?;
        let times = [filtering, calibrating, designing].map(|time| time / share);
        for (sum, time) in sums.iter_mut().zip(times) {
            *sum += time / cohort.people.len() as f64;
        }
        let [filtering, calibrating, designing] = times;
        let limit = if found.converged { "" } else { ", not converged" };
        println!(
            "{:<8} {filtering:>8.2} {calibrating:>10.1} {designing:>10.1}  {}, {}{limit}",
            person.id,
            found.iterations,
            made.columns.len(),
        );
    }
    let [filtering, calibrating, designing] = sums;
    println!("mean     {filtering:>8.2} {calibrating:>10.1} {designing:>10.1}");
    Ok(())
}
