//! `id,time,gl` for the R package iglu: a row a reading, mg/dL.

use std::path::Path;

use super::csv::{Cell, Csv};
use crate::error::CohortError;
use crate::person::Cohort;

pub(super) fn write(cohort: &Cohort, folder: &Path) -> Result<(), CohortError> {
    let mut csv = Csv::new(folder, "iglu.csv", &["id", "time", "gl"])?;
    for person in &cohort.people {
        let record = &person.record;
        for (k, glucose) in record.cgm().iter().enumerate().filter(|(_, glucose)| glucose.is_some())
        {
            let time = record.time(k).format("%Y-%m-%d %H:%M:%S").to_string();
            csv.row([Cell::Text(&person.id), Cell::Text(&time), Cell::Number(*glucose)])?;
        }
    }
    csv.finish()
}
