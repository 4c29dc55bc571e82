//! What free runs show of a cohort, cell by cell and by horizon, as numbers by name.

use std::collections::BTreeMap;

use crate::config::DiagnosisConfig;
use crate::localisation::DayCells;
use crate::person::{HorizonSums, PersonAnalysis, cells};
use crate::person_statistics::mean_and_sd;
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
        if biases.is_empty() {
            continue;
        }
        let (mean, sd) = mean_and_sd(&biases);
        let factor = if cell.factor == CellFactor::Horizon { "horizon" } else { "cell" };
        found.insert(format!("free runs/{factor} {}/bias", cell.level), mean);
        found.insert(format!("free runs/{factor} {}/people differ", cell.level), sd);
    }
    let horizons = 0..config.free_run.horizons.len();
    let sizes: Vec<Vec<Option<f64>>> = people
        .map(|person| horizons.clone().map(|index| log_size(person.total(index))).collect())
        .collect();
    for (index, steps) in config.free_run.horizons.iter().enumerate() {
        let grown: Vec<f64> = sizes.iter().filter_map(|own| growth(own, index)).collect();
        if !grown.is_empty() {
            let (mean, sd) = mean_and_sd(&grown);
            found.insert(format!("free runs/growth to {} min/mean", 5 * steps), mean);
            found.insert(format!("free runs/growth to {} min/SD", 5 * steps), sd);
        }
    }
    found
}

/// Mean error of a cell over the root mean squared error of all runs at its horizon.
fn bias(person: &PersonAnalysis, cell: usize, horizon: usize) -> Option<f64> {
    let of_days = |of: fn(&DayCells) -> &Vec<f64>| {
        person.free_runs.iter().map(|day| of(day)[cell]).sum::<f64>()
    };
    let count = of_days(|day| &day.counts);
    let rms = person.total(horizon).rms();
    (count >= FEWEST && rms > 0.0).then(|| of_days(|day| &day.sums) / count / rms)
}

/// Logarithm of the root mean squared error of some runs, mg/dL; `None` where there is no run or no error.
fn log_size(sums: HorizonSums) -> Option<f64> {
    let rms = sums.rms();
    (rms > 0.0).then(|| rms.ln())
}

/// How much the logarithm grows to a horizon from the one before; the first is given as it is.
fn growth(sizes: &[Option<f64>], horizon: usize) -> Option<f64> {
    let before = horizon.checked_sub(1).map_or(Some(0.0), |before| sizes[before])?;
    Some(sizes[horizon]? - before)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_no_run_is_long_enough_nothing_is_said_of_growth() {
        let runs = |squares: f64| HorizonSums { runs: 4.0, squares, ..HorizonSums::default() };
        let sizes = [runs(400.0), runs(1600.0), HorizonSums::default()].map(log_size);
        assert_eq!(growth(&sizes, 0), Some(10f64.ln()));
        assert!((growth(&sizes, 1).expect("runs at both") - 2f64.ln()).abs() < 1e-12);
        assert_eq!(growth(&sizes, 2), None);
    }
}
