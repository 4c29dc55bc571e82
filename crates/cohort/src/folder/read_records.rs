//! Puts the rows of a table of records on each person's grid.

use std::collections::HashMap;

use chrono::{Datelike, NaiveDateTime};

use super::record_table::{RecordTable, TIME};
use crate::error::{CohortError, Place};
use crate::person::Person;
use crate::range::{check_value, looks_like_mmol};
use crate::record::{Channel, MAX_DAYS, Record, on_grid};

/// Fills the records of `people` from the rows of `table`.
pub(super) fn fill(people: &mut [Person], table: &RecordTable) -> Result<(), CohortError> {
    let spans = spans(people, table)?;
    for (person, rows) in people.iter_mut().zip(&spans) {
        let (Some(first), Some(last)) = (rows.first(), rows.last()) else {
            return Err(CohortError::NoRecord {
                file: table.file().into(),
                person: person.id.clone(),
            });
        };
        let steps = last.1.signed_duration_since(first.1).num_minutes() / 5;
        let len = usize::try_from(steps).expect("rows ascend in time") + 1;
        person.record = Record::new(first.1, len)?;
    }
    for channel in Channel::ALL {
        let Some(cells) = table.channel(channel)? else { continue };
        for (person, rows) in people.iter_mut().zip(&spans) {
            let differences = person.heart_rate_baseline.is_some_and(|rate| rate.0 == 0.0);
            let start = person.record.start();
            let values = person.record.channel_mut(channel);
            for &(row, time) in rows {
                let Some(value) = cells(row as usize)? else { continue };
                check_value(channel, value, differences)
                    .map_err(|range| range.at(table.cell(row as usize, channel.column())))?;
                let k = time.signed_duration_since(start).num_minutes() / 5;
                values[usize::try_from(k).expect("rows ascend in time")] = Some(value);
            }
        }
    }
    for person in people.iter() {
        if let Some(median) = looks_like_mmol(person.record.cgm()) {
            return Err(CohortError::LooksLikeMmol {
                place: Place::column(table.file(), Channel::Cgm.column()),
                person: person.id.clone(),
                median,
            });
        }
    }
    Ok(())
}

/// Each person's rows with their times, checked for grid and order.
fn spans(
    people: &[Person],
    table: &RecordTable,
) -> Result<Vec<Vec<(u32, NaiveDateTime)>>, CohortError> {
    let index: HashMap<&str, usize> =
        people.iter().enumerate().map(|(i, person)| (person.id.as_str(), i)).collect();
    if u32::try_from(table.height()).is_err() {
        return Err(CohortError::Table {
            file: table.file().into(),
            reason: format!("{} rows; split the cohort into folders", table.height()),
        });
    }
    let mut spans: Vec<Vec<(u32, NaiveDateTime)>> = vec![Vec::new(); people.len()];
    table.rows(|i, person, time| {
        let Some(&p) = index.get(person) else {
            return Err(CohortError::UnknownPerson {
                place: table.place(i),
                person: person.into(),
            });
        };
        let place = || table.cell(i, TIME);
        if !on_grid(time) {
            return Err(CohortError::OffGrid { place: place(), time });
        }
        if !(1900..2200).contains(&time.year()) {
            return Err(CohortError::Cell {
                place: place(),
                value: time.to_string(),
                expected: "a time within the years 1900 to 2199",
            });
        }
        let rows = &mut spans[p];
        if let (Some(&(_, first)), Some(&(_, previous))) = (rows.first(), rows.last()) {
            if time == previous {
                return Err(CohortError::DuplicateStep {
                    place: place(),
                    person: person.into(),
                    time,
                });
            }
            if time < previous {
                // A repeated time is the clearer finding where rows are also out of order.
                let repeated = rows.binary_search_by_key(&time, |row| row.1).is_ok();
                let (place, person) = (place(), person.to_owned());
                return Err(if repeated {
                    CohortError::DuplicateStep { place, person, time }
                } else {
                    CohortError::OutOfOrder { place, person, time, previous }
                });
            }
            let days = time.signed_duration_since(first).num_days();
            if days >= MAX_DAYS {
                return Err(CohortError::TooLong {
                    place: place(),
                    person: person.into(),
                    days,
                    limit: MAX_DAYS,
                });
            }
        }
        rows.push((u32::try_from(i).expect("checked above"), time));
        Ok(())
    })?;
    Ok(spans)
}
