//! The CSV that Dexcom Clarity exports.
//!
//! A row an event. The first rows hold the person's name and the device's alerts, without a time;
//! none of them is read. Glucose is of the rows `EGV` (`Low` and `High` beyond 40 to 400 mg/dL),
//! in mg/dL or mmol/L as the column's name says. Logged insulin is fast- or long-acting. Times are
//! the device's own clock. The person is named after the file. The header is in the language of the
//! account: English, Spanish (HUPA-UCM, `cgmpy`) or German; kinds of insulin are known in English.

use std::path::PathBuf;

use super::table::plan::Plan;
use super::table::{Only, Role, TableOptions, read};
use crate::error::CohortError;

const FORMAT: &str = "dexcom";
const TIME: &str = "Timestamp (YYYY-MM-DDThh:mm:ss)";
const TYPE: &str = "Event Type";
const SUBTYPE: &str = "Event Subtype";
const MG_PER_DL: &str = "Glucose Value (mg/dL)";
const MMOL_PER_L: &str = "Glucose Value (mmol/L)";
const UNITS: &str = "Insulin Value (u)";
const GRAMS: &str = "Carb Value (grams)";
const DURATION: &str = "Duration (hh:mm:ss)";
const COLUMNS: [(Role, &str); 6] = [
    (Role::Time, TIME),
    (Role::Glucose, MG_PER_DL),
    (Role::Glucose, MMOL_PER_L),
    (Role::Bolus, UNITS),
    (Role::LongActing, UNITS),
    (Role::Carbs, GRAMS),
];
const ROWS: [(Role, &str, &[&str]); 6] = [
    (Role::Glucose, TYPE, &["EGV", "EGW", "Niveles estimados de glucosa"]),
    (Role::Bolus, TYPE, INSULIN),
    (Role::Bolus, SUBTYPE, &["Fast-Acting"]),
    (Role::LongActing, TYPE, INSULIN),
    (Role::LongActing, SUBTYPE, &["Long-Acting"]),
    (Role::Carbs, TYPE, &["Carbs", "Carbohidratos", "Kohlenhydrate"]),
];
const INSULIN: &[&str] = &["Insulin", "Insulina"];
/// Names in other languages; case and marks do not count.
const NAMES: [(&str, &str); 16] = [
    ("Marca temporal (AAAA-MM-DDThh:mm:ss)", TIME),
    ("Tipo de evento", TYPE),
    ("Subtipo de evento", SUBTYPE),
    ("Nivel de glucosa (mg/dL)", MG_PER_DL),
    ("Nivel de glucosa (mmol/L)", MMOL_PER_L),
    ("Nivel de insulina (u)", UNITS),
    ("Nivel de carbohidratos (gramos)", GRAMS),
    ("Zeitstempel (JJJJ-MM-TTThh:mm:ss)", TIME),
    ("Ereignistyp", TYPE),
    ("Ereignisart", TYPE),
    ("Ereignisuntertyp", SUBTYPE),
    ("Glukosewert (mg/dL)", MG_PER_DL),
    ("Glukosewert (mmol/L)", MMOL_PER_L),
    ("Insulinwert (IE)", UNITS),
    ("Kohlenhydratwert (Gramm)", GRAMS),
    ("Dauer (hh:mm:ss)", DURATION),
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
        .map(|(role, column, values)| Only {
            role,
            column: column.into(),
            values: values.iter().map(|value| (*value).to_owned()).collect(),
        })
        .to_vec();
    let plan = Plan {
        format: FORMAT,
        options,
        numbering: &["Index"],
        names: &NAMES,
        counted: &[(DURATION, "durations of exercise: not read, a record has no column for them")],
        ..Plan::default()
    };
    read(sources, &plan)
}
