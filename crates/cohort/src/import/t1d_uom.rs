//! The T1D-UOM study (doi:10.5281/zenodo.15169263): folders of irregular events, one file per
//! person and kind.
//!
//! Glucose is in mmol/L, times are `DD/MM/YYYY HH:MM`, some files begin with a byte-order mark. The
//! record of a person is the span in which glucose and insulin are both recorded. The notes count
//! what lies outside; the totals include its doses. Heart rate is not imported: the study's
//! five-minute heart rate (`UoM*sleep*.csv`) has no times that can be aligned.

use std::path::{Path, PathBuf};

use contract::import_report::Inference;
use rayon::prelude::*;

use super::files::{entries, identifier, name};
use super::report::{Imported, Notes, assemble, inference};
use super::steps::{Span, time_of};
use crate::error::{CohortError, Place};
use crate::person::{Person, Therapy};
use crate::record::{Channel, Record, longest};
use crate::text_table::TextTable;

mod events;
mod glucose;
mod insulin;
mod nutrition;
mod watch;

const FORMAT: &str = "t1d-uom";
const GLUCOSE: &str = "Glucose Data";
const BASAL: &str = "Insulin Data/Basal Data";
const BOLUS: &str = "Insulin Data/Bolus Data";
const NUTRITION: &str = "Nutrition Data";
const ACTIVITY: &str = "Activity Data";
const SLEEP: &str = "Sleep Data";

/// Reads the study's folder.
pub(super) fn import(source: &Path) -> Result<super::Import, CohortError> {
    // Collected before the first error is taken, so the error is that of the first person for any
    // number of threads.
    let people: Vec<_> = people(source)?.par_iter().map(|id| person(source, id)).collect();
    let days_are = "the span in which glucose and insulin are both recorded";
    assemble(FORMAT, days_are, people)
}

/// The people who have a glucose file, in order.
fn people(source: &Path) -> Result<Vec<String>, CohortError> {
    let folder = source.join(GLUCOSE);
    if !folder.is_dir() {
        let reason = format!("no folder '{GLUCOSE}'");
        return Err(CohortError::layout(source.display(), FORMAT, reason));
    }
    let mut people = Vec::new();
    for path in entries(&folder)? {
        let name = name(&path);
        let id = name.strip_prefix("UoMGlucose").and_then(|rest| rest.strip_suffix(".csv"));
        let Some(id) = id else { continue };
        let what = "what follows UoMGlucose in the file's name";
        let remedy = "rename the file, or move it elsewhere";
        identifier(id, &format!("{GLUCOSE}/{name}"), FORMAT, what, remedy)?;
        people.push(id.to_owned());
    }
    people.sort();
    if people.is_empty() {
        let reason = "no file named UoMGlucose*.csv";
        return Err(CohortError::layout(folder.display(), FORMAT, reason));
    }
    Ok(people)
}

/// The notes and inferences of one person while their files are read.
pub(super) struct Account<'a> {
    id: &'a str,
    notes: Notes,
    inferences: Vec<Inference>,
}

impl Account<'_> {
    fn note(&mut self, place: Place, what: &str, count: usize) {
        self.notes.add_many(self.id, place, what, count);
    }

    fn infer(&mut self, place: Place, conclusion: &str, evidence: String) {
        self.inferences.push(inference(self.id, place, conclusion, evidence));
    }
}

fn person(source: &Path, id: &str) -> Result<Imported, CohortError> {
    let mut account = Account { id, notes: Notes::default(), inferences: Vec::new() };
    // The name for messages includes the sub-folder.
    let table = |folder: &str, file: String| -> Result<Option<TextTable>, CohortError> {
        let path: PathBuf = source.join(folder).join(&file);
        if !path.exists() {
            return Ok(None);
        }
        TextTable::read(&path, &format!("{folder}/{file}"), b',').map(Some)
    };
    let readings = match table(GLUCOSE, format!("UoMGlucose{id}.csv"))? {
        Some(table) => glucose::read(&table, &mut account)?,
        None => {
            return Err(CohortError::MissingFile {
                file: format!("{GLUCOSE}/UoMGlucose{id}.csv"),
                remedy: "restore it".into(),
            });
        }
    };
    let basal = table(BASAL, format!("UoMBasal{id}.csv"))?;
    let basal = basal.map(|table| insulin::basal(&table, &mut account)).transpose()?;
    let bolus = table(BOLUS, format!("UoMBolus{id}.csv"))?;
    let bolus = bolus.map(|table| insulin::bolus(&table, &mut account)).transpose()?;
    let meals = table(NUTRITION, format!("UoMNutrition{id}.csv"))?;
    let meals = meals.map(|table| nutrition::read(&table, &mut account)).transpose()?;
    let activity = table(ACTIVITY, format!("UoMActivity{id}.csv"))?;
    let sleep = table(SLEEP, format!("UoM{id}sleeptime.csv"))?;
    for (folder, missing, what) in [
        (BASAL, basal.is_none(), "no basal file: basal_u_h is missing"),
        (BOLUS, bolus.is_none(), "no bolus file: bolus_u is missing"),
        (NUTRITION, meals.is_none(), "no nutrition file: carbs_g is missing"),
        (ACTIVITY, activity.is_none(), "no activity file: steps is missing"),
        (SLEEP, sleep.is_none(), "no sleep file: sleep_efficiency is missing"),
    ] {
        account.note(Place::file(folder), what, usize::from(missing));
    }
    refuse_heart_rate(source, &mut account)?;

    let span = span(&readings, basal.as_ref(), bolus.as_ref(), &mut account)?;
    let mut record = Record::new(time_of(span.first), span.len())?;
    let mut totals = Vec::new();
    readings.place(&span, &mut record, &mut account);
    let therapy = match &basal {
        Some(basal) => {
            totals.push(basal.place(&span, &mut record, &mut account));
            basal.therapy(&mut account)
        }
        None => Therapy::Unknown,
    };
    if let Some(bolus) = &bolus {
        totals.push(bolus.place(&span, &mut record, &mut account, Channel::Bolus, "U")?);
        insulin::silence_between(&mut record, basal.is_some());
    }
    if let Some(meals) = &meals {
        totals.push(nutrition::place(meals, &span, &mut record, &mut account)?);
    }
    let worn = match &activity {
        Some(table) => watch::steps(table, &span, &mut record, &mut account)?,
        None => vec![false; span.len()],
    };
    if let Some(table) = &sleep {
        watch::sleep(table, &span, &worn, &mut record, &mut account)?;
    }
    account.note(Place::file(id), "no heart rate, set changes or weight", 1);
    let Account { notes, inferences, .. } = account;
    let person = Person { id: id.into(), weight: None, therapy, heart_rate_baseline: None, record };
    let file = format!("{GLUCOSE}/UoMGlucose{id}.csv");
    Ok(Imported { person, file, totals, inferences, notes })
}

/// Names the heart-rate files that are ignored.
fn refuse_heart_rate(source: &Path, account: &mut Account<'_>) -> Result<(), CohortError> {
    let folder = source.join(SLEEP);
    if !folder.is_dir() {
        return Ok(());
    }
    for path in entries(&folder)? {
        let name = name(&path);
        let of_person = name.contains(account.id) && name.ends_with(".csv");
        if of_person && !name.ends_with("sleeptime.csv") {
            account.note(
                Place::file(format!("{SLEEP}/{name}")),
                "five-minute heart rate whose times are not aligned with the rest: refused",
                1,
            );
        }
    }
    Ok(())
}

/// The span in which glucose and insulin are both recorded; glucose alone without insulin files.
fn span(
    readings: &glucose::Readings,
    basal: Option<&insulin::Basal>,
    bolus: Option<&events::Events>,
    account: &mut Account<'_>,
) -> Result<Span, CohortError> {
    let cgm = readings.span();
    // Where the pump's rates are recorded, so are its boluses. Without rates the boluses define the
    // span.
    let insulin = basal.and_then(insulin::Basal::span).or_else(|| bolus?.span());
    let span = match insulin {
        Some(insulin) => {
            Span { first: cgm.first.max(insulin.first), end: cgm.end.min(insulin.end) }
        }
        None => cgm,
    };
    if span.end <= span.first {
        let reason = format!(
            "glucose of person '{}' ends at {} before insulin begins, or the reverse",
            account.id,
            time_of(cgm.end)
        );
        let file = format!("{GLUCOSE}/UoMGlucose{}.csv", account.id);
        return Err(CohortError::layout(file, FORMAT, reason));
    }
    let days = (span.end - span.first) / 288;
    let limit = longest(readings.len());
    if days >= limit {
        let place = Place::file(format!("{GLUCOSE}/UoMGlucose{}.csv", account.id));
        return Err(CohortError::TooLong { place, person: account.id.into(), days, limit });
    }
    Ok(span)
}
