//! The filter's noise settings of highest likelihood over people.
//!
//!     cargo run -p gap --example noise -- [--fix NAME=VALUE,...] [--without ID,...] [--sweeps N] FOLDER...
//!
//! Each folder is a cohort and counts as much as any other, whatever its number of readings. People are
//! calibrated under the present settings; with their factors held, settings are moved one at a time to where
//! the innovations are likeliest (Huber's loss beyond 2.5 standard deviations), with steps that shrink. Then
//! everything is done once more from there. Prints the settings, the log likelihood in nats a reading for each folder
//! before and after, and how each folder alone would move single settings.

use std::path::Path;

use gap::filter::augmented::AugmentedModel;
use gap::filter::calibration::calibrate;
use gap::filter::kalman::filter;
use gap::filter::whitening::{HUBER_THRESHOLD, huber_loss, robust_scale};
use gap::{DiagnosisConfig, NoiseModel, Observations};
use ode_sim::OdeParameters;
use rayon::prelude::*;

/// A person with calibrated parameters.
struct Subject {
    group: usize,
    record: Observations,
    parameters: OdeParameters,
    burn_in: usize,
    scored: Vec<bool>,
}

/// How a setting is moved: its index in a list of logarithms or, for a correlation, of Fisher's z.
#[derive(Clone, Copy)]
struct Setting {
    name: &'static str,
    get: fn(&NoiseModel) -> f64,
    set: fn(&mut NoiseModel, f64),
    correlation: bool,
}

macro_rules! setting {
    ($field:ident, $correlation:expr) => {
        Setting {
            name: stringify!($field),
            get: |n| n.$field,
            set: |n, v| n.$field = v,
            correlation: $correlation,
        }
    };
}

const SETTINGS: [Setting; 11] = [
    setting!(flux_sd, false),
    setting!(flux_time, false),
    setting!(carb_count_cv, false),
    setting!(insulin_cv, false),
    setting!(effect_cv, false),
    setting!(glucose_sd, false),
    setting!(interstitial_lag, false),
    setting!(sensor_sd, false),
    setting!(sensor_correlation, true),
    setting!(sensor_partial_correlation, true),
    setting!(reading_sd, false),
];

impl Setting {
    fn moved(self, noise: &NoiseModel, by: f64) -> NoiseModel {
        let here = (self.get)(noise);
        let there = if self.correlation { (here.atanh() + by).tanh() } else { here * by.exp() };
        let mut moved = *noise;
        (self.set)(&mut moved, there);
        moved
    }
}

/// Log likelihood of a person's scored innovations, nats, up to a constant, and their number. The person has a
/// scale of their own, as in the diagnosis, at which it is largest.
fn of_subject(subject: &Subject, noise: &NoiseModel) -> (f64, f64) {
    let model = AugmentedModel::new(subject.parameters, subject.record.weight, *noise);
    let Ok(run) = filter(&model, &subject.record) else { return (f64::NEG_INFINITY, 1.0) };
    let scored = run.innovations.iter().zip(&subject.scored).skip(subject.burn_in);
    let all: Vec<_> = scored.filter(|(_, scored)| **scored).filter_map(|(i, _)| *i).collect();
    let n = all.len() as f64;
    let loss = |scale: f64| -> f64 {
        n * scale.ln() + all.iter().map(|i| huber_loss(i.normalised() / scale, 1.0)).sum::<f64>()
    };
    // By sections: the loss has one minimum in the logarithm of the scale.
    let (mut low, mut high) = (-1.5_f64, 1.5_f64);
    for _ in 0..20 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if loss(a.exp()) < loss(b.exp()) { high = b } else { low = a }
    }
    let logs: f64 = all.iter().map(|i| 0.5 * i.variance.ln()).sum();
    (-logs - loss((0.5 * (low + high)).exp()), n)
}

/// Nats a reading of each group.
fn of_groups(people: &[Subject], groups: usize, noise: &NoiseModel) -> Vec<f64> {
    let each: Vec<(usize, (f64, f64))> =
        people.par_iter().map(|s| (s.group, of_subject(s, noise))).collect();
    let mut sums = vec![(0.0, 0.0); groups];
    for (group, (sum, n)) in each {
        sums[group].0 += sum;
        sums[group].1 += n;
    }
    sums.iter().map(|(sum, n)| sum / n.max(1.0)).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[expect(clippy::print_stdout, reason = "an example shows its result")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let config = DiagnosisConfig::working();
    let mut noise = config.noise;
    let (mut folders, mut fixed, mut sweeps) = (Vec::new(), Vec::new(), 12usize);
    let mut without: Vec<String> = Vec::new();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--fix" => {
                for pair in arguments.next().ok_or("--fix NAME=VALUE,...")?.split(',') {
                    let (name, value) = pair.split_once('=').ok_or("--fix NAME=VALUE")?;
                    let setting =
                        SETTINGS.iter().find(|s| s.name == name).ok_or("no such setting")?;
                    (setting.set)(&mut noise, value.parse()?);
                    fixed.push(setting.name);
                }
            }
            "--without" => {
                let ids = arguments.next().ok_or("--without ID,...")?;
                without.extend(ids.split(',').map(str::to_owned));
            }
            "--sweeps" => sweeps = arguments.next().ok_or("--sweeps N")?.parse()?,
            _ => folders.push(argument),
        }
    }
    for round in 0..2 {
        let mut people = Vec::new();
        for (group, folder) in folders.iter().enumerate() {
            let cohort = cohort::read_folder(Path::new(folder))?;
            let calibrated: Vec<Option<Subject>> = cohort
                .people
                .par_iter()
                .filter(|person| !without.contains(&person.id))
                .map(|person| {
                    let record = Observations::from_person(person).ok()?;
                    let rule = &config.calibration;
                    let population = OdeParameters::nominal();
                    let model = AugmentedModel::new(population, record.weight, noise);
                    let found = calibrate(&model, &record, rule).ok()?;
                    let z: Vec<Option<f64>> =
                        found.filtered.innovations.iter().map(|i| i.map(|i| i.normalised())).collect();
                    println!(
                        "{folder} {}: scale {:.2} before whitening {:.2}, autoregression {:.2} {:.2}",
                        person.id, found.scale, robust_scale(&z), found.autoregression.a1, found.autoregression.a2
                    );
                    let parameters = found.factors.applied_to(&population);
                    let scored = found.whitened.iter().map(Option::is_some).collect();
                    Some(Subject { group, record, parameters, burn_in: rule.burn_in, scored })
                })
                .collect();
            people.extend(calibrated.into_iter().flatten());
        }
        let groups = folders.len();
        let mut best = of_groups(&people, groups, &noise);
        println!("round {round}: {} people, Huber beyond {HUBER_THRESHOLD}", people.len());
        println!("before {best:.4?} mean {:.5}", mean(&best));
        let mut steps = [0.3; SETTINGS.len()];
        for _ in 0..sweeps {
            for (setting, step) in SETTINGS.iter().zip(&mut steps) {
                if fixed.contains(&setting.name) {
                    continue;
                }
                let mut improved = false;
                for sign in [1.0, -1.0] {
                    let moved = setting.moved(&noise, sign * *step);
                    let found = of_groups(&people, groups, &moved);
                    if mean(&found) > mean(&best) {
                        (noise, best, improved) = (moved, found, true);
                        break;
                    }
                }
                *step *= if improved { 1.3 } else { 0.5 };
            }
        }
        println!("after  {best:.4?} mean {:.5}", mean(&best));
        for setting in SETTINGS {
            let here = (setting.get)(&noise);
            let slopes: Vec<f64> = [0.1, -0.1]
                .map(|by| of_groups(&people, groups, &setting.moved(&noise, by)))
                .into_iter()
                .reduce(|up, down| up.iter().zip(down).map(|(u, d)| 5.0 * (u - d)).collect())
                .unwrap_or_default();
            println!("{:<28}{here:>10.5}   slopes by folder {slopes:.4?}", setting.name);
        }
    }
    Ok(())
}
