//! `Glucose Data/UoMGlucose*.csv`: `bg_ts`, `value` in mmol/L.

use physiology::MG_PER_DL_PER_MMOL_PER_L;

use super::FORMAT;
use super::events::{Event, Events};
use crate::error::{CohortError, Place};
use crate::import::diary::second;
use crate::import::report::Account;
use crate::import::steps::{STEP, Span, step_of, time_of};
use crate::range::{MMOL_MEDIAN, median};
use crate::record::{Channel, Record};
use crate::text_table::TextTable;

/// Readings closer than this come from two streams; a sensor reports every five minutes.
const INTERLEAVED_MINUTES: i64 = 3;

/// Reads the file: readings in mg/dL.
pub(super) fn read(table: &TextTable, account: &mut Account) -> Result<Events, CohortError> {
    let column = table.column("value")?;
    let mut values = Vec::with_capacity(table.height());
    for i in 0..table.height() {
        values.extend(column.number(i)?);
    }
    let median = median(values);
    if let Some(median) = median.filter(|median| *median >= MMOL_MEDIAN) {
        let reason = format!("median glucose of {median} looks like mg/dL, not mmol/L");
        return Err(CohortError::layout(table.file(), FORMAT, reason));
    }
    let factor = MG_PER_DL_PER_MMOL_PER_L;
    let events = Events::read(table, "bg_ts", "value", Channel::Cgm, factor, account)?;
    let evidence = median.map_or_else(String::new, |median| format!("median {median}"));
    account.infer(Place::column(table.file(), "value"), "mmol/L; x 18 mg/dL", evidence);
    Ok(events)
}

/// The steps from the first to the last reading.
pub(super) fn span(readings: &Events) -> Span {
    let events = &readings.events;
    Span { first: nearest(&events[0]), end: nearest(&events[events.len() - 1]) + 1 }
}

/// Puts each reading at the nearest step. Of several readings the nearest in time stays; at equal
/// distance the first of the file.
pub(super) fn place(readings: &Events, span: &Span, record: &mut Record, account: &mut Account) {
    let cells = record.channel_mut(Channel::Cgm);
    let mut best: Vec<Option<i64>> = vec![None; cells.len()];
    let (mut beside, mut outside, mut close, mut differ) = (0, 0, 0, 0);
    let mut previous: Option<&Event> = None;
    for event in &readings.events {
        let Some(k) = span.index(nearest(event)) else {
            outside += 1;
            continue;
        };
        if let Some(previous) = previous {
            let apart = event.time.signed_duration_since(previous.time).num_minutes();
            close += usize::from(apart <= INTERLEAVED_MINUTES);
            differ += usize::from(apart == 0 && event.value != previous.value);
        }
        previous = Some(event);
        let at = time_of(nearest(event));
        let distance = event.time.signed_duration_since(at).num_minutes().abs();
        match best[k] {
            Some(nearer) if nearer <= distance => beside += 1,
            known => {
                beside += usize::from(known.is_some());
                best[k] = Some(distance);
                cells[k] = Some(event.value);
            }
        }
    }
    let moved = best.iter().flatten().filter(|distance| **distance > 0).count();
    for (what, count) in [
        ("readings moved by 1 or 2 min to the nearest step", moved),
        ("readings beside a nearer or earlier one of the step: left out", beside),
        ("readings at most 3 min after another: interleaved or repeated streams", close),
        ("readings at the time of another but with another value", differ),
        ("readings outside the span of glucose and insulin: left out", outside),
    ] {
        account.note(Place::column(&readings.file, "value"), what, count);
    }
}

/// The step whose start is nearest: minutes 3 and 4 of a step belong to the next one.
fn nearest(event: &Event) -> i64 {
    step_of(second(event.time) + STEP / 2)
}
