//! The T1D-UOM study (doi:10.5281/zenodo.15169263): folders of irregular events, one file per
//! person and kind.
//!
//! Glucose is in mmol/L, times are `DD/MM/YYYY HH:MM`, some files begin with a byte-order mark. The
//! record of a person is the span in which glucose and insulin are both recorded. The notes count
//! what lies outside; the totals include its doses. Heart rate is not imported: the study's
//! five-minute heart rate (`UoM*sleep*.csv`) has no times that can be aligned.

use std::path::Path;

use super::files::{entries, identifier, name};
use super::report::{Account, Imported, assemble};
use super::steps::{Span, time_of};
use crate::error::{CohortError, Place};
use crate::person::{Person, Therapy};
use crate::record::{Channel, Record, check_span};
use crate::text_table::TextTable;

mod events;
mod glucose;
mod insulin;
mod nutrition;
mod watch;

use events::Events;

const FORMAT: &str = "t1d-uom";
const GLUCOSE: &str = "Glucose Data";
const BASAL: &str = "Insulin Data/Basal Data";
const BOLUS: &str = "Insulin Data/Bolus Data";
const NUTRITION: &str = "Nutrition Data";
const ACTIVITY: &str = "Activity Data";
const SLEEP: &str = "Sleep Data";

/// Reads the study's folder.
pub(super) fn import(source: &Path) -> Result<super::Import, CohortError> {
    let people = people(source)?;
    let people = people.iter().map(|id| person(source, id));
    let days_are = "the span in which glucose and insulin are both recorded";
    assemble(FORMAT, source.display(), days_are, people)
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

fn person(source: &Path, id: &str) -> Result<Imported, CohortError> {
    let glucose_file = format!("UoMGlucose{id}.csv");
    let mut account = Account::new(id, &format!("{GLUCOSE}/{glucose_file}"));
    // The name for messages includes the sub-folder.
    let table = |folder: &str, file: String| -> Result<Option<TextTable>, CohortError> {
        let path = source.join(folder).join(&file);
        if !path.exists() {
            return Ok(None);
        }
        TextTable::read(&path, &format!("{folder}/{file}"), b',').map(Some)
    };
    let Some(readings) = table(GLUCOSE, glucose_file)? else {
        return Err(CohortError::missing_file(account.file, "restore it"));
    };
    let readings = glucose::read(&readings, &mut account)?;
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

    let span = span(&readings, basal.as_ref(), bolus.as_ref(), &account)?;
    let mut record = Record::new(time_of(span.first), span.len())?;
    glucose::place(&readings, &span, &mut record, &mut account);
    let therapy = match &basal {
        Some(basal) => {
            basal.place(&span, &mut record, &mut account);
            basal.therapy(&mut account)
        }
        None => Therapy::Unknown,
    };
    if let Some(bolus) = &bolus {
        bolus.place(&span, &mut record, &mut account, Channel::Bolus, "U")?;
        insulin::silence_between(&mut record, basal.is_some());
    }
    if let Some(meals) = &meals {
        nutrition::place(meals, &span, &mut record, &mut account)?;
    }
    let worn = match &activity {
        Some(table) => watch::steps(table, &span, &mut record, &mut account)?,
        None => vec![false; span.len()],
    };
    if let Some(table) = &sleep {
        watch::sleep(table, &span, &worn, &mut record, &mut account)?;
    }
    account.note(Place::file(id), "no heart rate, set changes or weight", 1);
    let person = Person { id: id.into(), weight: None, therapy, heart_rate_baseline: None, record };
    Ok(Imported { person: Some(person), account })
}

/// Names the heart-rate files that are ignored.
fn refuse_heart_rate(source: &Path, account: &mut Account) -> Result<(), CohortError> {
    let folder = source.join(SLEEP);
    if !folder.is_dir() {
        return Ok(());
    }
    for path in entries(&folder)? {
        let name = name(&path);
        let of_person = name.contains(&account.id) && name.ends_with(".csv");
        if of_person && !name.ends_with("sleeptime.csv") {
            let place = Place::file(format!("{SLEEP}/{name}"));
            let what = "five-minute heart rate whose times are not aligned with the rest: refused";
            account.note(place, what, 1);
        }
    }
    Ok(())
}

/// The span in which glucose and insulin are both recorded; glucose alone without insulin files.
fn span(
    readings: &Events,
    basal: Option<&insulin::Basal>,
    bolus: Option<&Events>,
    account: &Account,
) -> Result<Span, CohortError> {
    let cgm = glucose::span(readings);
    // Where the pump's rates are recorded, so are its boluses. Without rates the boluses define the
    // span.
    let insulin = basal.and_then(insulin::Basal::span).or_else(|| Some(bolus?.span()));
    let insulin = insulin.unwrap_or(cgm);
    let span = Span { first: cgm.first.max(insulin.first), end: cgm.end.min(insulin.end) };
    let Account { id, file, .. } = account;
    if span.end <= span.first {
        let end = time_of(cgm.end);
        let reason =
            format!("glucose of person '{id}' ends at {end} before insulin begins, or the reverse");
        return Err(CohortError::layout(file, FORMAT, reason));
    }
    let days = (span.end - span.first) / 288;
    check_span(days, readings.events.len(), id, || Place::file(file))?;
    Ok(span)
}
