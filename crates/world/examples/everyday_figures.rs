//! Prints simple figures of the people of null worlds, by hand, as quantiles.
//!
//!     cargo run -p world --example everyday_figures -- [WORLDS] [SEED]
//!
//! Compare them with the same figures of real people: glucose, its change between readings,
//! insulin, carbohydrate and how often it is logged.

use std::error::Error;
use std::io::Write as _;

use cohort::Record;
use physiology::STEPS_PER_DAY;
use world::Generator;
use world::blind::Plan;

const NAMES: [&str; 10] = [
    "mean glucose, mg/dL",
    "CV, %",
    "in 70-180 mg/dL, %",
    "below 70 mg/dL, %",
    "SD of 5-min changes, mg/dL",
    "their autocorrelation",
    "insulin, U/day",
    "carbohydrate, g/day",
    "entries of carbohydrate a day",
    "readings present, %",
];

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let worlds = args.next().map_or(Ok(12), |n| n.parse::<usize>())?;
    let seed = args.next().map_or(Ok(1), |n| n.parse::<u64>())?;
    let mut out = std::io::stdout().lock();
    for generator in Generator::ALL {
        let plan = Plan { generators: vec![generator], ..Plan::check(0, worlds) };
        let mut people = Vec::new();
        for planned in plan.worlds(seed) {
            let cohort = planned.realise()?.cohort();
            people.extend(cohort.people.iter().map(|person| figures(&person.record)));
        }
        writeln!(out, "{}: {} people of {worlds} worlds", generator.name(), people.len())?;
        for (figure, name) in NAMES.iter().enumerate() {
            let mut values: Vec<f64> =
                people.iter().map(|p| p[figure]).filter(|v| v.is_finite()).collect();
            values.sort_by(f64::total_cmp);
            let at = |share: f64| {
                values.get((share * (values.len().max(1) - 1) as f64).round() as usize)
            };
            let at = |share| at(share).copied().unwrap_or(f64::NAN);
            let (low, middle, high) = (at(0.05), at(0.5), at(0.95));
            writeln!(out, "  {name:32} {low:8.2} {middle:8.2} {high:8.2}")?;
        }
    }
    Ok(())
}

/// The figures of one person, in the order of their names.
fn figures(record: &Record) -> [f64; 10] {
    let readings: Vec<f64> = record.cgm().iter().flatten().copied().collect();
    let n = readings.len() as f64;
    let days = record.len() as f64 / STEPS_PER_DAY as f64;
    let (mean, sd) = moments(&readings);
    let percent = |within: &dyn Fn(f64) -> bool| {
        100.0 * readings.iter().filter(|g| within(**g)).count() as f64 / n
    };
    let change = |k: usize| Some(record.cgm()[k]? - record.cgm()[k - 1]?);
    let changes: Vec<f64> = (1..record.len()).filter_map(change).collect();
    let pairs: Vec<f64> =
        (2..record.len()).filter_map(|k| Some(change(k)? * change(k - 1)?)).collect();
    let (_, change_sd) = moments(&changes);
    let sum = |channel: &[Option<f64>]| channel.iter().flatten().sum::<f64>();
    let entries = record.carbs().iter().flatten().filter(|g| **g > 0.0).count() as f64;
    [
        mean,
        100.0 * sd / mean,
        percent(&|g| (70.0..=180.0).contains(&g)),
        percent(&|g| g < 70.0),
        change_sd,
        pairs.iter().sum::<f64>() / pairs.len() as f64 / (change_sd * change_sd),
        (sum(record.basal()) / 12.0 + sum(record.bolus())) / days,
        sum(record.carbs()) / days,
        entries / days,
        100.0 * n / record.len() as f64,
    ]
}

/// Mean and standard deviation.
fn moments(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt())
}
