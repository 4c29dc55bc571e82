//! A cohort in the formats that other programs read.
//!
//! Text cells that a spreadsheet would take for a formula get an apostrophe before them.

use std::path::Path;

use crate::error::CohortError;
use crate::person::Cohort;

mod csv;
mod metabonet;

use self::csv::Cell::{Number, Text};
pub use self::csv::{Cell as CsvCell, Csv};

/// Minutes of a step.
const MINUTES: f64 = 5.0;

named::named! {
    /// A format of other programs.
    ExportFormat {
        /// `iglu.csv` with `id,time,gl`, as the R package iglu reads it.
        Iglu: "iglu",
        /// One table a person, as ReplayBG reads it.
        Replaybg: "replaybg",
        /// One table a person, like the results of simglucose.
        Simglucose: "simglucose",
        /// `metabonet.parquet` with the columns of MetaboNet.
        Metabonet: "metabonet",
    }
}

/// Writes a cohort into a folder that exists, in another format.
///
/// # Errors
/// If a file cannot be written.
pub fn export(cohort: &Cohort, format: ExportFormat, folder: &Path) -> Result<(), CohortError> {
    match format {
        ExportFormat::Iglu => iglu(cohort, folder),
        ExportFormat::Replaybg => replaybg(cohort, folder),
        ExportFormat::Simglucose => simglucose(cohort, folder),
        ExportFormat::Metabonet => metabonet::write(cohort, folder),
    }
}

/// `id,time,gl` for the R package iglu: a row a reading, mg/dL.
fn iglu(cohort: &Cohort, folder: &Path) -> Result<(), CohortError> {
    let mut csv = Csv::new(folder, "iglu.csv", &["id", "time", "gl"])?;
    for person in &cohort.people {
        let readings = person.record.cgm().iter().enumerate();
        for (k, glucose) in readings.filter(|(_, glucose)| glucose.is_some()) {
            let time = person.record.time(k).format("%Y-%m-%d %H:%M:%S").to_string();
            csv.row([Text(&person.id), Text(&time), Number(*glucose)])?;
        }
    }
    csv.finish()
}

/// One table a person for ReplayBG: `glucose` in mg/dL, `cho` in g/min, `bolus` and `basal` in
/// U/min, each over the five minutes from `t`.
///
/// ReplayBG wants to know which meal it is. The hour decides: breakfast from 4, lunch from 11,
/// dinner from 17 to 23; at other hours it is a snack.
fn replaybg(cohort: &Cohort, folder: &Path) -> Result<(), CohortError> {
    let header = ["t", "glucose", "cho", "bolus", "basal", "cho_label", "bolus_label", "exercise"];
    for person in &cohort.people {
        let mut csv = Csv::new(folder, &format!("{}.csv", person.id), &header)?;
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
                Text(&time),
                Number(record.cgm()[k]),
                Number(carbs.map(|grams| grams / MINUTES)),
                Number(bolus.map(|units| units / MINUTES)),
                Number(record.basal()[k].map(|u_h| u_h / 60.0)),
                Text(label(carbs)),
                Text(label(bolus)),
                Number(Some(0.0)),
            ])?;
        }
        csv.finish()?;
    }
    Ok(())
}

/// One table a person like the results of simglucose: `CHO` in g/min and `insulin` in U/min, basal
/// and boluses together, from a row's `Time` to the next one.
///
/// `BG` and the risks are empty, because nobody measured them. A last row ends the last sample.
fn simglucose(cohort: &Cohort, folder: &Path) -> Result<(), CohortError> {
    let header = ["Time", "BG", "CGM", "CHO", "insulin", "LBGI", "HBGI", "Risk"];
    for person in &cohort.people {
        let mut csv = Csv::new(folder, &format!("{}.csv", person.id), &header)?;
        let record = &person.record;
        let at = |channel: &[Option<f64>], k: usize| channel.get(k).copied().flatten();
        for k in 0..=record.len() {
            let time = record.time(k).format("%Y-%m-%d %H:%M:%S").to_string();
            let basal = at(record.basal(), k).map(|u_h| u_h / 60.0);
            let bolus = at(record.bolus(), k).map(|units| units / MINUTES);
            csv.row([
                Text(&time),
                Number(None),
                Number(at(record.cgm(), k)),
                Number(at(record.carbs(), k).map(|grams| grams / MINUTES)),
                Number(basal.zip(bolus).map(|(basal, bolus)| basal + bolus)),
                Number(None),
                Number(None),
                Number(None),
            ])?;
        }
        csv.finish()?;
    }
    Ok(())
}
