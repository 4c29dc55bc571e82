//! Amounts at irregular times.

use chrono::{Datelike as _, NaiveDateTime};

use crate::error::{CohortError, Place};
use crate::import::diary::second;
use crate::import::report::Account;
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

/// The events of one file, in order of time; there is one at least.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Events {
    pub(super) file: String,
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
    let expected = match column.text(i) {
        None if blank(table, i) => return Ok(None),
        None => "a time like 31/12/2023 08:05; the cell is empty",
        Some(text) => {
            let in_range = |time: &NaiveDateTime| (1900..2200).contains(&time.year());
            if let Some(time) = parse_day_first(text).filter(in_range) {
                return Ok(Some(Stamp::At(time)));
            }
            if parse_day_first_date(text).is_some() {
                return Ok(Some(Stamp::Day));
            }
            "a time like 31/12/2023 08:05 (day first), in the years 1900 to 2199"
        }
    };
    Err(column.wrong(i, expected))
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
        account: &mut Account,
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
                    let what = "rows earlier than the row above: sorted";
                    account.note(times.place(i), what, usize::from(late));
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
            return Err(CohortError::empty(table.file()));
        }
        Ok(Self { file: table.file().into(), events, untimed })
    }

    /// The steps from the first to the last event.
    pub(super) fn span(&self) -> Span {
        let step = |event: &Event| step_of(second(event.time));
        Span { first: step(&self.events[0]), end: step(&self.events[self.events.len() - 1]) + 1 }
    }

    /// Adds the amounts to their steps; a step without one within the events' span holds 0.
    ///
    /// # Errors
    /// If a step would hold more than its column can.
    pub(super) fn place(
        &self,
        span: &Span,
        record: &mut Record,
        account: &mut Account,
        channel: Channel,
        unit: &str,
    ) -> Result<(), CohortError> {
        let cells = record.channel_mut(channel);
        let (mut source, mut left_out) = (self.untimed, self.untimed);
        let mut filled = vec![false; cells.len()];
        let own = self.span();
        let own = own.first.max(span.first)..own.end.min(span.end);
        for k in own.filter_map(|step| span.index(step)) {
            cells[k] = Some(0.0);
        }
        for event in &self.events {
            source += event.value;
            let Some(k) = span.index(step_of(second(event.time))) else {
                left_out += event.value;
                let what = "amounts outside the span of glucose and insulin: left out";
                account.note(event.place.clone(), what, 1);
                continue;
            };
            let more = filled[k] && event.value > 0.0;
            let what = "amounts in a step that already has one: summed";
            account.note(event.place.clone(), what, usize::from(more));
            filled[k] |= event.value > 0.0;
            let sum = cells[k].unwrap_or(0.0) + event.value;
            check_value(channel, sum, false, || event.place.clone())?;
            cells[k] = Some(sum);
        }
        let kept = cells.iter().flatten().sum();
        account.total(channel, unit, source, kept, left_out);
        Ok(())
    }
}
