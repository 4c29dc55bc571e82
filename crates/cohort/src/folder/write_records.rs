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
use crate::person::{Cohort, ID_EXPECTED, Person, is_person_id};
use crate::range::{check_unit, check_value};
use crate::record::Channel;

/// Refuses what `read_folder` would refuse, before anything is written.
pub(super) fn check(cohort: &Cohort) -> Result<(), CohortError> {
    if cohort.people.is_empty() {
        return Err(CohortError::empty(PEOPLE));
    }
    let mut seen = HashSet::new();
    for person in &cohort.people {
        let (place, id) = (|| Place::column(PEOPLE, PERSON_ID), || person.id.clone());
        if !is_person_id(&person.id) {
            return Err(CohortError::Cell { place: place(), value: id(), expected: ID_EXPECTED });
        }
        if !seen.insert(person.id.as_str()) {
            return Err(CohortError::DuplicatePerson { place: place(), person: id() });
        }
        if person.record.is_empty() {
            return Err(CohortError::NoRecord { file: "records".into(), person: id() });
        }
        let differences = person.heart_rate_baseline.is_some_and(|rate| rate.0 == 0.0);
        for channel in Channel::ALL {
            for k in 0..person.record.len() {
                let Some(value) = person.finite(channel, k)? else { continue };
                check_value(channel, value, differences, || {
                    let column = channel.name();
                    Place::file(format!("person '{}', step {k}, {column}", person.id))
                })?;
            }
        }
        let place = || Place::column("records", Channel::Cgm.name());
        check_unit(person.record.cgm(), &person.id, place)?;
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
    write_whole(folder, name, |mut file| {
        let written = match format {
            RecordsFormat::Csv => cohort.people.iter().enumerate().try_for_each(|(i, person)| {
                let text = |k| person.record.time(k).format("%Y-%m-%dT%H:%M:%S").to_string();
                let times: Vec<String> = rows(person).map(text).collect();
                let mut frame = frame(person)?;
                frame.replace(TIME, Series::new(TIME.into(), times).into_column())?;
                CsvWriter::new(&mut file)
                    .include_header(i == 0)
                    .with_batch_size(NonZeroUsize::new(4096).expect("not zero"))
                    .finish(&mut frame)
            }),
            RecordsFormat::Parquet => write_parts(file, &cohort.people, frame),
        };
        written.map_err(|error| CohortError::not_written(name, &error))
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
        columns.push(Series::new(channel.name().into(), values).into_column());
    }
    DataFrame::new(steps.len(), columns)
}
