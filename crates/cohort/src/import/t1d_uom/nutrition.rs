//! `Nutrition Data/UoMNutrition*.csv`: `meal_ts`, `carbs_g`. Protein, fat and fibre are not part
//! of the record.

use std::collections::BTreeSet;

use super::events::Events;
use crate::error::{CohortError, Place};
use crate::import::report::Account;
use crate::import::steps::Span;
use crate::record::{Channel, Record};
use crate::text_table::TextTable;

/// Reads the file.
pub(super) fn read(table: &TextTable, account: &mut Account) -> Result<Events, CohortError> {
    Events::read(table, "meal_ts", "carbs_g", Channel::Carbs, 1.0, account)
}

/// Puts the meals into the record and counts the days on which nothing was logged.
pub(super) fn place(
    meals: &Events,
    span: &Span,
    record: &mut Record,
    account: &mut Account,
) -> Result<(), CohortError> {
    meals.place(span, record, account, Channel::Carbs, "g")?;
    let (mut days, mut logged) = (BTreeSet::new(), BTreeSet::new());
    for (k, carbs) in record.carbs().iter().enumerate() {
        let Some(carbs) = carbs else { continue };
        days.insert(record.time(k).date());
        if *carbs > 0.0 {
            logged.insert(record.time(k).date());
        }
    }
    let what = "calendar days between logged ones without any carbohydrate: kept as 0";
    account.note(Place::column(&meals.file, "carbs_g"), what, days.len() - logged.len());
    Ok(())
}
