//! What free runs show of a cohort, cell by cell and by horizon, as numbers by name.

use std::collections::BTreeMap;

use crate::config::DiagnosisConfig;
use crate::person::{HorizonSums, PersonAnalysis, cells};
use contract::diagnosis::CellFactor;

/// Fewest errors of a person in a cell.
const FEWEST: f64 = 10.0;

/// Means of errors by cell over the person's root mean squared error at that horizon, how people differ in them, and
/// how errors grow with the horizon. What no record shows is absent.
pub(crate) fn free_run_statistics<'a>(
    people: impl Iterator<Item = &'a PersonAnalysis> + Clone,
    config: &DiagnosisConfig,
) -> BTreeMap<String, f64> {
    let mut found = BTreeMap::new();
    for (index, cell) in cells(&config.free_run, &config.localisation).iter().enumerate() {
        let biases: Vec<f64> =
            people.clone().filter_map(|person| bias(person, index, cell.horizon)).collect();
        let Some((mean, sd)) = mean_and_sd(&biases) else { continue };
        let factor = match cell.factor {
            CellFactor::Horizon => "horizon",
            _ => "cell",
        };
        found.insert(format!("free runs/{factor} {}/bias", cell.level), mean);
        found.insert(format!("free runs/{factor} {}/people differ", cell.level), sd);
    }
    let mut before: Option<Vec<f64>> = None;
    for (index, steps) in config.free_run.horizons.iter().enumerate() {
        let sizes: Vec<f64> =
            people.clone().map(|person| total(person, index).rms().max(1e-3).ln()).collect();
        let grown = match &before {
            Some(last) => sizes.iter().zip(last).map(|(now, last)| now - last).collect(),
            None => sizes.clone(),
        };
        if let Some((mean, sd)) = mean_and_sd(&grown) {
            found.insert(format!("free runs/growth to {} min/mean", 5 * steps), mean);
            found.insert(format!("free runs/growth to {} min/SD", 5 * steps), sd);
        }
        before = Some(sizes);
    }
    found
}

/// Mean error of a cell over the root mean squared error of all runs at its horizon.
fn bias(person: &PersonAnalysis, cell: usize, horizon: usize) -> Option<f64> {
    let of_days = |of: fn(&crate::localisation::DayCells) -> &Vec<f64>| {
        person.free_runs.iter().map(|day| of(day)[cell]).sum::<f64>()
    };
    let count = of_days(|day| &day.counts);
    let rms = total(person, horizon).rms();
    (count >= FEWEST && rms > 0.0).then(|| of_days(|day| &day.sums) / count / rms)
}

fn total(person: &PersonAnalysis, horizon: usize) -> HorizonSums {
    HorizonSums::total(person.horizons.iter(), horizon)
}

fn mean_and_sd(values: &[f64]) -> Option<(f64, f64)> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / n;
    mean.is_finite().then(|| (mean, variance.sqrt()))
}
