//! One table a person like the results of simglucose: `CHO` in g/min and `insulin` in U/min, basal
//! and boluses together, from a row's `Time` to the next one.
//!
//! `BG` and the risks are empty, because nobody measured them. A last row ends the last sample.

use std::path::Path;

use super::csv::{Cell, Csv};
use crate::error::CohortError;
use crate::person::Cohort;

const HEADER: [&str; 8] = ["Time", "BG", "CGM", "CHO", "insulin", "LBGI", "HBGI", "Risk"];
/// Minutes of a step.
const MINUTES: f64 = 5.0;

pub(super) fn write(cohort: &Cohort, folder: &Path) -> Result<(), CohortError> {
    for person in &cohort.people {
        let mut csv = Csv::new(folder, &format!("{}.csv", person.id), &HEADER)?;
        let record = &person.record;
        let at = |channel: &[Option<f64>], k: usize| channel.get(k).copied().flatten();
        for k in 0..=record.len() {
            let time = record.time(k).format("%Y-%m-%d %H:%M:%S").to_string();
            let basal = at(record.basal(), k).map(|u_h| u_h / 60.0);
            let bolus = at(record.bolus(), k).map(|units| units / MINUTES);
            csv.row([
                Cell::Text(&time),
                Cell::Number(None),
                Cell::Number(at(record.cgm(), k)),
                Cell::Number(at(record.carbs(), k).map(|grams| grams / MINUTES)),
                Cell::Number(basal.zip(bolus).map(|(basal, bolus)| basal + bolus)),
                Cell::Number(None),
                Cell::Number(None),
                Cell::Number(None),
            ])?;
        }
        csv.finish()?;
    }
    Ok(())
}
