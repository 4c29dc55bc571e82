//! `Nutrition Data/UoMNutrition*.csv`: `meal_ts`, `carbs_g`. Protein, fat and fibre are not part
//! of the record.

use std::collections::BTreeSet;

use contract::import_report::Totals;

use super::Account;
use super::events::Events;
use crate::error::{CohortError, Place};
use crate::import::steps::Span;
use crate::record::{Channel, Record};
use crate::text_table::TextTable;

/// Meals and the name of their file.
pub(super) struct Meals {
    events: Events,
    file: String,
}

/// Reads the file.
pub(super) fn read(table: &TextTable, account: &mut Account<'_>) -> Result<Meals, CohortError> {
    let events = Events::read(table, "meal_ts", "carbs_g", Channel::Carbs, 1.0, account)?;
    Ok(Meals { events, file: table.file().into() })
}

/// Puts the meals into the record and counts the days on which nothing was logged.
pub(super) fn place(
    meals: &Meals,
    span: &Span,
    record: &mut Record,
    account: &mut Account<'_>,
) -> Result<Totals, CohortError> {
    let totals = meals.events.place(span, record, account, Channel::Carbs, "g")?;
    let (mut days, mut logged) = (BTreeSet::new(), BTreeSet::new());
    for (k, carbs) in record.carbs().iter().enumerate() {
        let Some(carbs) = carbs else { continue };
        days.insert(record.time(k).date());
        if *carbs > 0.0 {
            logged.insert(record.time(k).date());
        }
    }
    account.note(
        Place::column(&meals.file, "carbs_g"),
        "calendar days between logged ones without any carbohydrate: kept as 0",
        days.len() - logged.len(),
    );
    Ok(totals)
}
