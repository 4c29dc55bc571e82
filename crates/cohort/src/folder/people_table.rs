//! `people.csv`: one row per person.

use std::collections::HashSet;
use std::path::Path;

use chrono::DateTime;
use physiology::{BeatsPerMinute, Kilograms};
use polars::prelude::{Column, CsvWriter, DataFrame, IntoColumn, NamedFrom, SerWriter, Series};

use super::{PEOPLE, columns, write_whole};
use crate::error::CohortError;
use crate::faults::Faults;
use crate::person::{Cohort, Person, Therapy, WEIGHTS, is_person_id};
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
        return Err(CohortError::MissingFile {
            file: PEOPLE.into(),
            remedy: format!(
                "{} is not a cohort folder; if it is a study's own data, import it",
                folder.display()
            ),
        });
    }
    let table = TextTable::check(&path, PEOPLE, b',', faults)?;
    columns::check_names(PEOPLE, table.header(), &COLUMNS, faults)?;
    let ids = table.column(PERSON_ID)?;
    let weights = table.optional(WEIGHT)?;
    let therapies = table.optional(THERAPY)?;
    let baselines = table.optional(HEART_RATE_BASELINE)?;
    let mut seen = HashSet::new();
    let mut people = Vec::with_capacity(table.height());
    for i in 0..table.height() {
        let Some(id) = faults.pass(person_id(&ids, i))? else { continue };
        if !seen.insert(id) {
            faults.add(CohortError::DuplicatePerson { place: ids.place(i), person: id.into() })?;
            continue;
        }
        let weight = faults
            .pass(bounded(weights.as_ref(), i, *WEIGHTS.start(), *WEIGHTS.end(), "kg"))?
            .flatten();
        let baseline = faults.pass(bounded(baselines.as_ref(), i, 0.0, 250.0, "1/min"))?.flatten();
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

/// The identifier in row `i`.
pub(super) fn person_id<'a>(column: &'a TextColumn<'_>, i: usize) -> Result<&'a str, CohortError> {
    column.text(i).filter(|id| is_person_id(id)).ok_or_else(|| {
        column.wrong(i, "a person's identifier; use letters, digits, '_', '-' and '.'")
    })
}

fn bounded(
    column: Option<&TextColumn<'_>>,
    i: usize,
    low: f64,
    high: f64,
    unit: &'static str,
) -> Result<Option<f64>, CohortError> {
    let Some(column) = column else { return Ok(None) };
    match column.number(i)? {
        Some(value) if !(low..=high).contains(&value) => Err(CohortError::OutOfRange {
            place: column.place(i),
            value,
            low,
            high,
            unit,
            remedy: "correct it or leave the cell empty",
        }),
        value => Ok(value),
    }
}

/// Writes the people.
pub(super) fn write(cohort: &Cohort, folder: &Path) -> Result<(), CohortError> {
    let people = &cohort.people;
    let column = |name: &str, values: Vec<Option<f64>>| -> Column {
        Series::new(name.into(), values).into_column()
    };
    let ids: Vec<&str> = people.iter().map(|person| person.id.as_str()).collect();
    let therapies: Vec<&str> = people.iter().map(|person| person.therapy.name()).collect();
    let failed = |error: polars::prelude::PolarsError| CohortError::not_written(PEOPLE, &error);
    let mut frame = DataFrame::new(
        people.len(),
        vec![
            Series::new(PERSON_ID.into(), ids).into_column(),
            column(WEIGHT, people.iter().map(|person| person.weight.map(|w| w.0)).collect()),
            Series::new(THERAPY.into(), therapies).into_column(),
            column(
                HEART_RATE_BASELINE,
                people.iter().map(|person| person.heart_rate_baseline.map(|b| b.0)).collect(),
            ),
        ],
    )
    .map_err(failed)?;
    write_whole(folder, PEOPLE, |file| CsvWriter::new(file).finish(&mut frame).map_err(failed))
}
