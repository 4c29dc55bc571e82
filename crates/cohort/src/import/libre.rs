//! The CSV that LibreView exports.
//!
//! One line about the export stands above the header. Times are the device's own clock, day or
//! month first as the account's country has it; glucose is in mg/dL or mmol/L as the column's name
//! says. The record takes the historic readings (record type 0); scans (type 1) are the same
//! sensor's readings before smoothing, and finger-sticks (type 2) are none of a sensor. Both are
//! counted and left out. The person is named after the file.

use std::path::PathBuf;

use super::table::plan::Plan;
use super::table::{Only, Role, TableOptions, read};
use crate::error::CohortError;

const FORMAT: &str = "libre";
const TYPE: &str = "Record Type";
const HISTORIC: &str = "0";
const COLUMNS: [(Role, &str); 6] = [
    (Role::Time, "Device Timestamp"),
    (Role::Glucose, "Historic Glucose mg/dL"),
    (Role::Glucose, "Historic Glucose mmol/L"),
    (Role::Bolus, "Rapid-Acting Insulin (units)"),
    (Role::LongActing, "Long-Acting Insulin (units)"),
    (Role::Carbs, "Carbohydrates (grams)"),
];
/// What the calculator proposed and the user changed: the dose where no other is written.
const CALCULATED: [&str; 3] =
    ["Meal Insulin (units)", "Correction Insulin (units)", "User Change Insulin (units)"];
const SERVINGS: &str = "Carbohydrates (servings)";
const COUNTED: [(&str, &str); 8] = [
    ("Scan Glucose mg/dL", "scans: left out, the historic readings are the sensor's record"),
    ("Scan Glucose mmol/L", "scans: left out, the historic readings are the sensor's record"),
    ("Strip Glucose mg/dL", "finger-stick readings: left out, they are none of the sensor"),
    ("Strip Glucose mmol/L", "finger-stick readings: left out, they are none of the sensor"),
    ("Non-numeric Rapid-Acting Insulin", "fast-acting insulin without an amount: left out"),
    ("Non-numeric Long-Acting Insulin", "long-acting insulin without an amount: left out"),
    ("Non-numeric Food", "meals without an amount: left out"),
    (SERVINGS, "carbohydrate in servings: counts where --unit says what one holds (carbs=10 g)"),
];

/// Reads exports, one or more a person.
pub(super) fn import(
    sources: &[PathBuf],
    options: &TableOptions,
) -> Result<super::Import, CohortError> {
    let mut options = options.clone();
    options.refuse_columns(FORMAT)?;
    options.columns = COLUMNS.map(|(role, column)| (role, column.to_owned())).to_vec();
    if options.unit(Role::Carbs).is_some_and(|unit| unit.trim() != "g") {
        // Servings are then what is logged; the column of grams would be multiplied too.
        options.columns.retain(|(role, _)| *role != Role::Carbs);
        options.columns.push((Role::Carbs, SERVINGS.into()));
    }
    options.only =
        vec![Only { role: Role::Glucose, column: TYPE.into(), values: vec![HISTORIC.into()] }];
    let plan = Plan {
        format: FORMAT,
        options,
        numbering: &[],
        bolus_parts: &CALCULATED,
        counted: &COUNTED,
    };
    read(sources, &plan)
}
