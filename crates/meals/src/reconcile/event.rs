//! The events that are reconciled, and what became of each.

use chrono::NaiveDateTime;
use contract::meals::{EventKind, Fate, MealEvent};

/// One event and what became of it.
#[derive(Debug, Clone, PartialEq)]
pub struct EventRow {
    /// The person's identifier.
    pub person_id: String,
    /// Start of the event's step, local wall clock.
    pub time: NaiveDateTime,
    /// What it is.
    pub kind: EventKind,
    /// g of carbohydrate or U of insulin; `None` for a detection without a size.
    pub size: Option<f64>,
    /// Strength of a detection's evidence, nats or standard deviations; `None` for other events.
    pub evidence: Option<f64>,
    /// What became of it.
    pub fate: Fate,
    /// Time of the event that decided its fate.
    pub partner: Option<NaiveDateTime>,
}

/// How often each fate befell an event; fates that befell none are left out.
#[must_use]
pub fn count_fates<'a>(events: impl IntoIterator<Item = &'a EventRow>) -> Vec<(Fate, usize)> {
    let mut counts = [0_usize; Fate::ALL.len()];
    for event in events {
        counts[event.fate as usize] += 1;
    }
    Fate::ALL.into_iter().zip(counts).filter(|(_, count)| *count > 0).collect()
}

impl From<&EventRow> for MealEvent {
    fn from(row: &EventRow) -> Self {
        Self {
            person_id: row.person_id.clone(),
            time: as_iso(row.time),
            kind: row.kind,
            size: row.size,
            evidence: row.evidence,
            fate: row.fate,
            partner: row.partner.map(as_iso),
        }
    }
}

/// A local time as cohort folders write it.
fn as_iso(time: NaiveDateTime) -> String {
    time.format("%Y-%m-%dT%H:%M:%S").to_string()
}
