//! One table a person for ReplayBG: `glucose` in mg/dL, `cho` in g/min, `bolus` and `basal` in
//! U/min, each over the five minutes from `t`.
//!
//! ReplayBG wants to know which meal it is. The hour decides: breakfast from 4, lunch from 11,
//! dinner from 17 to 23; at other hours it is a snack.

use std::path::Path;

use super::csv::{Cell, Csv};
use crate::error::CohortError;
use crate::person::Cohort;

const HEADER: [&str; 8] =
    ["t", "glucose", "cho", "bolus", "basal", "cho_label", "bolus_label", "exercise"];
/// Minutes of a step.
const MINUTES: f64 = 5.0;

pub(super) fn write(cohort: &Cohort, folder: &Path) -> Result<(), CohortError> {
    for person in &cohort.people {
        let mut csv = Csv::new(folder, &format!("{}.csv", person.id), &HEADER)?;
        let record = &person.record;
        for k in 0..record.len() {
            let time = record.time(k).format("%d-%b-%Y %H:%M:%S").to_string();
            let label = |amount: Option<f64>| match (amount, record.hour(k)) {
                (None | Some(0.0), _) => "",
                (_, 4..=10) => "B",
                (_, 11..=16) => "L",
                (_, 17..=22) => "D",
                _ => "S",
            };
            let (carbs, bolus) = (record.carbs()[k], record.bolus()[k]);
            csv.row([
                Cell::Text(&time),
                Cell::Number(record.cgm()[k]),
                Cell::Number(carbs.map(|grams| grams / MINUTES)),
                Cell::Number(bolus.map(|units| units / MINUTES)),
                Cell::Number(record.basal()[k].map(|u_h| u_h / 60.0)),
                Cell::Text(label(carbs)),
                Cell::Text(label(bolus)),
                Cell::Number(Some(0.0)),
            ])?;
        }
        csv.finish()?;
    }
    Ok(())
}
