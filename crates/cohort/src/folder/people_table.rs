//! `people.csv`: one row per person.

use std::collections::HashSet;
use std::ops::RangeInclusive;
use std::path::Path;

use chrono::DateTime;
use physiology::{BeatsPerMinute, Kilograms};
use polars::prelude::{
    CsvWriter, DataFrame, IntoColumn, NamedFrom, PolarsError, SerWriter, Series,
};

use super::{PEOPLE, columns, write_whole};
use crate::error::CohortError;
use crate::faults::Faults;
use crate::person::{Cohort, ID_EXPECTED, Person, Therapy, WEIGHTS, is_person_id};
use crate::record::Record;
use crate::text_table::{TextColumn, TextTable};

const PERSON_ID: &str = "person_id";
const WEIGHT: &str = "weight_kg";
const THERAPY: &str = "therapy";
const HEART_RATE_BASELINE: &str = "heart_rate_baseline_bpm";

/// Columns of the file; only the first must be there.
pub(super) const COLUMNS: [&str; 4] = [PERSON_ID, WEIGHT, THERAPY, HEART_RATE_BASELINE];

/// The people, with empty records. A row whose identifier cannot be used gives none.
pub(super) fn read(folder: &Path, faults: &mut Faults) -> Result<Vec<Person>, CohortError> {
    let path = folder.join(PEOPLE);
    if !path.exists() {
        let is_none = "is not a cohort folder; if it is a study's own data, import it";
        let remedy = format!("{} {is_none}", folder.display());
        return Err(CohortError::missing_file(PEOPLE, remedy));
    }
    let table = TextTable::check(&path, PEOPLE, b',', faults)?;
    columns::check_names(PEOPLE, table.header(), &COLUMNS, faults)?;
    let ids = table.column(PERSON_ID)?;
    let [weights, therapies, baselines] =
        [WEIGHT, THERAPY, HEART_RATE_BASELINE].map(|name| table.optional(name));
    let mut seen = HashSet::new();
    let mut people = Vec::with_capacity(table.height());
    for i in 0..table.height() {
        let id = ids.text(i).filter(|id| is_person_id(id));
        let id = id.ok_or_else(|| ids.wrong(i, ID_EXPECTED));
        let Some(id) = faults.pass(id)? else { continue };
        if !seen.insert(id) {
            faults.add(CohortError::DuplicatePerson { place: ids.place(i), person: id.into() })?;
            continue;
        }
        let weight = faults.pass(bounded(weights.as_ref(), i, WEIGHTS, "kg"))?.flatten();
        let baseline = bounded(baselines.as_ref(), i, 0.0..=250.0, "1/min");
        let baseline = faults.pass(baseline)?.flatten();
        people.push(Person {
            id: id.into(),
            weight: weight.map(Kilograms),
            therapy: faults.pass(therapy(therapies.as_ref(), i))?.unwrap_or(Therapy::Unknown),
            heart_rate_baseline: baseline.map(BeatsPerMinute),
            record: Record::new(DateTime::UNIX_EPOCH.naive_utc(), 0)?,
        });
    }
    Ok(people)
}

/// The therapy in row `i`; an absent column or an empty cell is unknown.
fn therapy(column: Option<&TextColumn<'_>>, i: usize) -> Result<Therapy, CohortError> {
    let Some((column, word)) = column.and_then(|column| Some((column, column.text(i)?))) else {
        return Ok(Therapy::Unknown);
    };
    Therapy::from_name(word)
        .ok_or_else(|| column.wrong(i, "open_loop_pump, aid, mdi or unknown; write one of them"))
}

fn bounded(
    column: Option<&TextColumn<'_>>,
    i: usize,
    range: RangeInclusive<f64>,
    unit: &'static str,
) -> Result<Option<f64>, CohortError> {
    let Some(column) = column else { return Ok(None) };
    let value = column.number(i)?;
    let Some(value) = value.filter(|value| !range.contains(value)) else { return Ok(value) };
    let (place, low, high) = (column.place(i), *range.start(), *range.end());
    let remedy = "correct it or leave the cell empty";
    Err(CohortError::OutOfRange { place, value, low, high, unit, remedy })
}

/// Writes the people.
pub(super) fn write(cohort: &Cohort, folder: &Path) -> Result<(), CohortError> {
    let people = &cohort.people;
    let text = |name: &str, of: fn(&Person) -> &str| {
        Series::new(name.into(), people.iter().map(of).collect::<Vec<&str>>()).into_column()
    };
    let number = |name: &str, of: fn(&Person) -> Option<f64>| {
        Series::new(name.into(), people.iter().map(of).collect::<Vec<Option<f64>>>()).into_column()
    };
    let columns = vec![
        text(PERSON_ID, |person| person.id.as_str()),
        number(WEIGHT, |person| person.weight.map(|weight| weight.0)),
        text(THERAPY, |person| person.therapy.name()),
        number(HEART_RATE_BASELINE, |person| person.heart_rate_baseline.map(|rate| rate.0)),
    ];
    let failed = |error: PolarsError| CohortError::not_written(PEOPLE, &error);
    let mut frame = DataFrame::new(people.len(), columns).map_err(failed)?;
    write_whole(folder, PEOPLE, |file| CsvWriter::new(file).finish(&mut frame).map_err(failed))
}
