//! `records.csv` and `records.parquet`, with the same bytes for the same cohort.

use std::collections::HashSet;
use std::num::NonZeroUsize;
use std::path::Path;

use polars::prelude::{
    CsvWriter, DataFrame, DataType, IntoColumn, NamedFrom, PolarsError, SerWriter, Series, TimeUnit,
};

use super::record_table::{PERSON_ID, TIME};
use super::{PEOPLE, RecordsFormat, write_whole};
use crate::error::{CohortError, Place};
use crate::parquet_sink::write_parts;
use crate::person::{Cohort, Person, is_person_id};
use crate::range::{check_value, looks_like_mmol};
use crate::record::Channel;

/// Refuses what `read_folder` would refuse, before anything is written.
pub(super) fn check(cohort: &Cohort) -> Result<(), CohortError> {
    if cohort.people.is_empty() {
        return Err(CohortError::Empty { file: PEOPLE.into() });
    }
    let mut seen = HashSet::new();
    for person in &cohort.people {
        if !is_person_id(&person.id) {
            return Err(CohortError::Cell {
                place: Place::column(PEOPLE, PERSON_ID),
                value: person.id.clone(),
                expected: "a person's identifier; use letters, digits, '_', '-' and '.'",
            });
        }
        if !seen.insert(person.id.as_str()) {
            return Err(CohortError::DuplicatePerson {
                place: Place::column(PEOPLE, PERSON_ID),
                person: person.id.clone(),
            });
        }
        if person.record.is_empty() {
            return Err(CohortError::NoRecord {
                file: "records".into(),
                person: person.id.clone(),
            });
        }
        let differences = person.heart_rate_baseline.is_some_and(|rate| rate.0 == 0.0);
        for channel in Channel::ALL {
            for k in 0..person.record.len() {
                let Some(value) = person.finite(channel, k)? else { continue };
                check_value(channel, value, differences, || {
                    let column = channel.column();
                    Place::file(format!("person '{}', step {k}, {column}", person.id))
                })?;
            }
        }
        if let Some(median) = looks_like_mmol(person.record.cgm()) {
            return Err(CohortError::LooksLikeMmol {
                place: Place::column("records", Channel::Cgm.column()),
                person: person.id.clone(),
                median,
            });
        }
    }
    Ok(())
}

/// Writes the records. For CSV it writes one person's table at a time, so that memory stays
/// bounded.
pub(super) fn write(
    cohort: &Cohort,
    folder: &Path,
    format: RecordsFormat,
) -> Result<(), CohortError> {
    let name = format.file();
    let failed = |error: PolarsError| CohortError::not_written(name, &error);
    write_whole(folder, name, |mut file| match format {
        RecordsFormat::Csv => {
            for (i, person) in cohort.people.iter().enumerate() {
                let mut frame = frame(person).map_err(failed)?;
                let times = times_as_text(person);
                frame
                    .replace(TIME, Series::new(TIME.into(), times).into_column())
                    .map_err(failed)?;
                CsvWriter::new(&mut file)
                    .include_header(i == 0)
                    .with_batch_size(NonZeroUsize::new(4096).expect("not zero"))
                    .finish(&mut frame)
                    .map_err(failed)?;
            }
            Ok(())
        }
        RecordsFormat::Parquet => write_parts(file, &cohort.people, frame).map_err(failed),
    })
}

/// The steps that get a row: those with a value, and the ends.
fn rows(person: &Person) -> impl Iterator<Item = usize> + '_ {
    let record = &person.record;
    (0..record.len()).filter(move |&k| {
        k == 0
            || k + 1 == record.len()
            || Channel::ALL.iter().any(|channel| record.channel(*channel)[k].is_some())
    })
}

fn times_as_text(person: &Person) -> Vec<String> {
    rows(person).map(|k| person.record.time(k).format("%Y-%m-%dT%H:%M:%S").to_string()).collect()
}

fn frame(person: &Person) -> Result<DataFrame, PolarsError> {
    let steps: Vec<usize> = rows(person).collect();
    let ids = vec![person.id.as_str(); steps.len()];
    let times: Vec<i64> =
        steps.iter().map(|&k| person.record.time(k).and_utc().timestamp_millis()).collect();
    let mut columns = vec![
        Series::new(PERSON_ID.into(), ids).into_column(),
        Series::new(TIME.into(), times)
            .cast(&DataType::Datetime(TimeUnit::Milliseconds, None))?
            .into_column(),
    ];
    for channel in Channel::ALL {
        let values = person.record.channel(channel);
        let values: Vec<Option<f64>> = steps.iter().map(|&k| values[k]).collect();
        columns.push(Series::new(channel.column().into(), values).into_column());
    }
    DataFrame::new(steps.len(), columns)
}
