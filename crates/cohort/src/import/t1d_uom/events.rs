//! Amounts at irregular times.

use chrono::{Datelike as _, NaiveDateTime};
use contract::import_report::Totals;

use super::Account;
use crate::error::{CohortError, Place};
use crate::import::diary::second;
use crate::import::report::totals_of;
use crate::import::steps::{Span, step_of};
use crate::range::check_value;
use crate::record::{Channel, Record};
use crate::text_table::{TextColumn, TextTable};
use crate::wall_clock::{parse_day_first, parse_day_first_date};

/// An amount at a time.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Event {
    pub(super) time: NaiveDateTime,
    pub(super) value: f64,
    pub(super) place: Place,
}

/// The events of one file, in order of time.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Events {
    pub(super) events: Vec<Event>,
    /// Sum of the amounts whose row has a date but no time of day.
    pub(super) untimed: f64,
}

/// The time in a row.
pub(super) enum Stamp {
    At(NaiveDateTime),
    /// A date alone.
    Day,
}

/// The stamp in row `i`, `None` if the whole row is empty.
pub(super) fn stamp(
    table: &TextTable,
    column: &TextColumn<'_>,
    i: usize,
) -> Result<Option<Stamp>, CohortError> {
    let Some(text) = column.text(i) else {
        return if blank(table, i) {
            Ok(None)
        } else {
            Err(column.wrong(i, "a time like 31/12/2023 08:05; the cell is empty"))
        };
    };
    let in_range = |time: &NaiveDateTime| (1900..2200).contains(&time.year());
    if let Some(time) = parse_day_first(text).filter(in_range) {
        Ok(Some(Stamp::At(time)))
    } else if parse_day_first_date(text).is_some() {
        Ok(Some(Stamp::Day))
    } else {
        let expected = "a time like 31/12/2023 08:05 (day first), in the years 1900 to 2199";
        Err(column.wrong(i, expected))
    }
}

/// Whether no column with a name holds anything in row `i`.
fn blank(table: &TextTable, i: usize) -> bool {
    let columns = table.header().iter().enumerate();
    columns.filter(|(_, name)| !name.is_empty()).all(|(at, _)| table.cell(i, at).is_none())
}

impl Events {
    /// Reads the columns `time` and `value`; `factor` turns the source's unit into the record's.
    pub(super) fn read(
        table: &TextTable,
        time: &str,
        value: &str,
        channel: Channel,
        factor: f64,
        account: &mut Account<'_>,
    ) -> Result<Self, CohortError> {
        let (times, values) = (table.column(time)?, table.column(value)?);
        let mut events: Vec<Event> = Vec::with_capacity(table.height());
        let mut untimed = 0.0;
        for i in 0..table.height() {
            let Some(stamp) = stamp(table, &times, i)? else {
                account.note(table.place(i), "empty rows: left out", 1);
                continue;
            };
            let Some(amount) = values.number(i)? else {
                account.note(values.place(i), "rows without an amount: left out", 1);
                continue;
            };
            let amount = amount * factor;
            check_value(channel, amount, false, || values.place(i))?;
            match stamp {
                Stamp::At(time) => {
                    let late = events.last().is_some_and(|last| time < last.time);
                    account.note(
                        times.place(i),
                        "rows earlier than the row above: sorted",
                        usize::from(late),
                    );
                    events.push(Event { time, value: amount, place: values.place(i) });
                }
                Stamp::Day => {
                    let what = "values on a date without a time of day: left out, since the step \
                                is unknown";
                    account.note(times.place(i), what, 1);
                    untimed += amount;
                }
            }
        }
        events.sort_by_key(|event| event.time);
        if events.is_empty() {
            return Err(CohortError::Empty { file: table.file().into() });
        }
        Ok(Self { events, untimed })
    }

    /// The steps from the first to the last event.
    pub(super) fn span(&self) -> Option<Span> {
        let (first, last) = (self.events.first()?, self.events.last()?);
        Some(Span { first: step_of(second(first.time)), end: step_of(second(last.time)) + 1 })
    }

    /// Adds the amounts to their steps; a step without one within the events' span holds 0.
    ///
    /// # Errors
    /// If a step would hold more than its column can.
    pub(super) fn place(
        &self,
        span: &Span,
        record: &mut Record,
        account: &mut Account<'_>,
        channel: Channel,
        unit: &str,
    ) -> Result<Totals, CohortError> {
        let cells = record.channel_mut(channel);
        let mut source = self.untimed;
        let mut left_out = self.untimed;
        let mut filled = vec![false; cells.len()];
        if let Some(own) = self.span() {
            for step in own.first.max(span.first)..own.end.min(span.end) {
                if let Some(k) = span.index(step) {
                    cells[k] = Some(0.0);
                }
            }
        }
        for event in &self.events {
            source += event.value;
            match span.index(step_of(second(event.time))) {
                Some(k) => {
                    let more = filled[k] && event.value > 0.0;
                    account.note(
                        event.place.clone(),
                        "amounts in a step that already has one: summed",
                        usize::from(more),
                    );
                    filled[k] |= event.value > 0.0;
                    let sum = cells[k].unwrap_or(0.0) + event.value;
                    check_value(channel, sum, false, || event.place.clone())?;
                    cells[k] = Some(sum);
                }
                None => {
                    left_out += event.value;
                    account.note(
                        event.place.clone(),
                        "amounts outside the span of glucose and insulin: left out",
                        1,
                    );
                }
            }
        }
        let kept = cells.iter().flatten().sum();
        Ok(totals_of(channel, unit, source, kept, left_out))
    }
}
