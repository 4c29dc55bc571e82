//! The CSV that Dexcom Clarity exports.
//!
//! A row an event. The first rows hold the person's name and the device's alerts, without a time;
//! none of them is read. Glucose is of the rows `EGV` (`Low` and `High` beyond 40 to 400 mg/dL),
//! in mg/dL or mmol/L as the column's name says. Logged insulin is fast- or long-acting. Times are
//! the device's own clock. The person is named after the file.

use std::path::PathBuf;

use super::table::plan::Plan;
use super::table::{Only, Role, TableOptions, read};
use crate::error::CohortError;

const FORMAT: &str = "dexcom";
const TIME: &str = "Timestamp (YYYY-MM-DDThh:mm:ss)";
const TYPE: &str = "Event Type";
const SUBTYPE: &str = "Event Subtype";
const COLUMNS: [(Role, &str); 6] = [
    (Role::Time, TIME),
    (Role::Glucose, "Glucose Value (mg/dL)"),
    (Role::Glucose, "Glucose Value (mmol/L)"),
    (Role::Bolus, "Insulin Value (u)"),
    (Role::LongActing, "Insulin Value (u)"),
    (Role::Carbs, "Carb Value (grams)"),
];
const ROWS: [(Role, &str, &str); 6] = [
    (Role::Glucose, TYPE, "EGV"),
    (Role::Bolus, TYPE, "Insulin"),
    (Role::Bolus, SUBTYPE, "Fast-Acting"),
    (Role::LongActing, TYPE, "Insulin"),
    (Role::LongActing, SUBTYPE, "Long-Acting"),
    (Role::Carbs, TYPE, "Carbs"),
];

/// Reads exports, one or more a person.
pub(super) fn import(
    sources: &[PathBuf],
    options: &TableOptions,
) -> Result<super::Import, CohortError> {
    let mut options = options.clone();
    options.refuse_columns(FORMAT)?;
    options.columns = COLUMNS.map(|(role, column)| (role, column.to_owned())).to_vec();
    options.only = ROWS
        .map(|(role, column, value)| Only {
            role,
            column: column.into(),
            values: vec![value.into()],
        })
        .to_vec();
    let plan = Plan {
        format: FORMAT,
        options,
        numbering: &["Index"],
        bolus_parts: &[],
        counted: &[(
            "Duration (hh:mm:ss)",
            "durations of exercise: not read, a record has no column for them",
        )],
    };
    read(sources, &plan)
}
