//! Puts the rows of a table of records on each person's grid.

use std::collections::HashMap;

use chrono::{Datelike, NaiveDateTime};

use super::record_table::{PERSON_ID, RecordTable, TIME};
use crate::error::{CohortError, Place};
use crate::faults::Faults;
use crate::person::Person;
use crate::range::{check_unit, check_value};
use crate::record::{Channel, GridSteps, MAX_DAYS, Record, follows, on_grid};

/// Fills the records of `people` from the rows of `table`.
pub(super) fn fill(
    people: &mut [Person],
    table: &RecordTable,
    faults: &mut Faults,
) -> Result<(), CohortError> {
    let spans = spans(people, table, faults)?;
    let lengths: Vec<usize> = spans.iter().map(|rows| length(rows)).collect();
    let mut steps = GridSteps::default();
    lengths.iter().try_for_each(|length| steps.add(*length, table.file()))?;
    for (person, (rows, length)) in people.iter_mut().zip(spans.iter().zip(lengths)) {
        match rows.first() {
            Some(first) => person.record = Record::new(first.1, length)?,
            None => faults.add(CohortError::NoRecord {
                file: table.file().into(),
                person: person.id.clone(),
            })?,
        }
    }
    for channel in Channel::ALL {
        for (person, rows) in people.iter_mut().zip(&spans) {
            let differences = person.heart_rate_baseline.is_some_and(|rate| rate.0 == 0.0);
            let start = person.record.start();
            let values = person.record.channel_mut(channel);
            for &(row, time) in rows {
                let row = row as usize;
                let Some(Some(value)) = faults.pass(table.number(row, channel))? else { continue };
                let place = || table.cell(row, channel.name());
                if faults.pass(check_value(channel, value, differences, place))?.is_some() {
                    let k = time.signed_duration_since(start).num_minutes() / 5;
                    values[usize::try_from(k).expect("rows ascend in time")] = Some(value);
                }
            }
        }
    }
    let place = || Place::column(table.file(), Channel::Cgm.name());
    for person in people.iter() {
        faults.pass(check_unit(person.record.cgm(), &person.id, place))?;
    }
    Ok(())
}

/// Steps from the first to the last row.
fn length(rows: &[(u32, NaiveDateTime)]) -> usize {
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else { return 0 };
    let minutes = last.1.signed_duration_since(first.1).num_minutes();
    usize::try_from(minutes / 5).expect("rows ascend in time") + 1
}

/// Each person's rows with their times, checked for grid and order.
fn spans(
    people: &[Person],
    table: &RecordTable,
    faults: &mut Faults,
) -> Result<Vec<Vec<(u32, NaiveDateTime)>>, CohortError> {
    let index: HashMap<&str, usize> =
        people.iter().enumerate().map(|(i, person)| (person.id.as_str(), i)).collect();
    if u32::try_from(table.height()).is_err() {
        let (rows, remedy) = (table.height(), "split the cohort into folders");
        return Err(CohortError::too_large(table.file(), format!("{rows} rows"), remedy));
    }
    let mut spans: Vec<Vec<(u32, NaiveDateTime)>> = vec![Vec::new(); people.len()];
    for i in 0..table.height() {
        // Of a row with several faults the first is told; the row is then left out.
        let Some((p, time)) = faults.pass(row(table, i, &index, &spans))? else { continue };
        spans[p].push((u32::try_from(i).expect("checked above"), time));
    }
    Ok(spans)
}

/// Person and time of row `i`, which follows the rows in `spans`.
fn row(
    table: &RecordTable,
    i: usize,
    index: &HashMap<&str, usize>,
    spans: &[Vec<(u32, NaiveDateTime)>],
) -> Result<(usize, NaiveDateTime), CohortError> {
    let (person, time) = table.row(i)?;
    let Some(&p) = index.get(person) else {
        let place = table.cell(i, PERSON_ID);
        return Err(CohortError::UnknownPerson { place, person: person.into() });
    };
    let place = || table.cell(i, TIME);
    if !on_grid(time) {
        return Err(CohortError::OffGrid { place: place(), time });
    }
    if !(1900..2200).contains(&time.year()) {
        let expected = "a time within the years 1900 to 2199";
        return Err(CohortError::cell(place(), &time.to_string(), expected));
    }
    let rows = &spans[p];
    let (Some(&(_, first)), Some(&(_, previous))) = (rows.first(), rows.last()) else {
        return Ok((p, time));
    };
    // A repeated time is the clearer finding where rows are also out of order.
    let repeated = time < previous && rows.binary_search_by_key(&time, |row| row.1).is_ok();
    follows(time, Some(if repeated { time } else { previous }), person, place)?;
    let days = time.signed_duration_since(first).num_days();
    if days >= MAX_DAYS {
        let person = person.into();
        return Err(CohortError::TooLong { place: place(), person, days, limit: MAX_DAYS });
    }
    Ok((p, time))
}
