//! `Insulin Data`: pump rates, long-acting injections and boluses.
//!
//! Basal rows of kind `R` are U/h from their time until the next one. A step holds the mean over
//! its five minutes, so amounts are kept exactly. Rows of kind `L` are injections of long-acting
//! insulin, which no basal rate describes without a model of their absorption. They are left out
//! and counted. A person who has only those is on `mdi` with the basal missing.

use chrono::{NaiveDateTime, TimeDelta};
use contract::import_report::Totals;
use physiology::STEPS_PER_DAY;

use super::events::{Event, Events, Stamp, stamp};
use super::{Account, Span, step_of, time_of};
use crate::error::{CohortError, Place};
use crate::person::Therapy;
use crate::range::check_value;
use crate::record::{Channel, Record};
use crate::text_table::TextTable;

const TIME: &str = "basal_ts";
const DOSE: &str = "basal_dose";
const KIND: &str = "insulin_kind";
/// A programmed rate changes or is confirmed at least once a day; after that the pump counts as
/// silent.
const HOLD: TimeDelta = TimeDelta::hours(24);
/// From this number of rate changes a day, a controller sets them, not a person.
const CHANGES_OF_A_CONTROLLER: f64 = 48.0;

/// Pump rates and injections of one person.
pub(super) struct Basal {
    file: String,
    /// Rate changes, U/h, in order, one per time.
    rates: Vec<Event>,
    /// Long-acting injections, U.
    injections: Vec<Event>,
}

/// Reads a basal file.
pub(super) fn basal(table: &TextTable, account: &mut Account<'_>) -> Result<Basal, CohortError> {
    let (times, doses, kinds) = (table.column(TIME)?, table.column(DOSE)?, table.column(KIND)?);
    let (mut rates, mut injections) = (Vec::<Event>::new(), Vec::new());
    for i in 0..table.height() {
        let time = match stamp(table, &times, i)? {
            None => {
                account.note(table.place(i), "empty rows: left out", 1);
                continue;
            }
            // The programme's first rate of a day may be stamped with the date alone.
            Some(Stamp::Day) => {
                return Err(times.wrong(i, "a time like 31/12/2023 08:05; the hour is missing"));
            }
            Some(Stamp::At(time)) => time,
        };
        let value = doses.required_number(i)?;
        let event = Event { time, value, place: doses.place(i) };
        match kinds.text(i) {
            Some("R") => {
                check_value(Channel::Basal, value, false)
                    .map_err(|range| range.at(doses.place(i)))?;
                let late = rates.last().is_some_and(|last| time < last.time);
                let what = "rows earlier than the row above: sorted";
                account.note(times.place(i), what, usize::from(late));
                rates.push(event);
            }
            Some("L") => {
                check_value(Channel::Bolus, value, false)
                    .map_err(|range| range.at(doses.place(i)))?;
                let what = "long-acting injections, which no basal rate describes: left out";
                account.note(doses.place(i), what, 1);
                injections.push(event);
            }
            _ => return Err(kinds.wrong(i, "R (a rate) or L (a long-acting injection)")),
        }
    }
    rates.sort_by_key(|event| event.time);
    let mut kept: Vec<Event> = Vec::with_capacity(rates.len());
    for event in rates {
        match kept.last_mut() {
            Some(last) if last.time == event.time => {
                let what = "rates at one time: the last one of the file holds";
                account.note(event.place.clone(), what, 1);
                *last = event;
            }
            _ => kept.push(event),
        }
    }
    if kept.is_empty() && injections.is_empty() {
        return Err(CohortError::Empty { file: table.file().into() });
    }
    Ok(Basal { file: table.file().into(), rates: kept, injections })
}

/// Reads a bolus file.
pub(super) fn bolus(table: &TextTable, account: &mut Account<'_>) -> Result<Events, CohortError> {
    let events = Events::read(table, "bolus_ts", "bolus_dose", Channel::Bolus, 1.0, account)?;
    let zeros = events.events.iter().filter(|event| event.value == 0.0).count();
    account.note(Place::column(table.file(), "bolus_dose"), "boluses of 0 U: kept as 0", zeros);
    Ok(events)
}

impl Basal {
    /// The steps that lie wholly between the first and the last rate.
    pub(super) fn span(&self) -> Option<Span> {
        let (first, last) = (self.rates.first()?, self.rates.last()?);
        let before = first.time - TimeDelta::seconds(1);
        Some(Span { first: step_of(before) + 1, end: step_of(last.time) })
    }

    /// Each rate with its start and end.
    fn held(&self) -> impl Iterator<Item = (NaiveDateTime, NaiveDateTime, f64)> + '_ {
        self.rates
            .iter()
            .zip(self.rates.iter().skip(1))
            .map(|(rate, next)| (rate.time, next.time.min(rate.time + HOLD), rate.value))
    }

    /// Puts the mean rate of each step that is wholly covered into the record.
    pub(super) fn place(
        &self,
        span: &Span,
        record: &mut Record,
        account: &mut Account<'_>,
    ) -> Totals {
        // U and seconds of each step.
        let mut steps = vec![(0.0, 0_i64); span.len()];
        let mut source = 0.0;
        for (start, end, rate) in self.held() {
            source += rate * seconds(start, end) / 3600.0;
            let (first, last) = (step_of(start).max(span.first), step_of(end).min(span.end - 1));
            for step in first..=last {
                let Some(k) = span.index(step) else { continue };
                let (from, to) = (start.max(time_of(step)), end.min(time_of(step + 1)));
                if to > from {
                    steps[k].0 += rate * seconds(from, to) / 3600.0;
                    steps[k].1 += to.signed_duration_since(from).num_seconds();
                }
            }
        }
        let injected: f64 = self.injections.iter().map(|event| event.value).sum();
        let mut kept = 0.0;
        let mut silent = 0;
        let cells = record.channel_mut(Channel::Basal);
        for (cell, (amount, covered)) in cells.iter_mut().zip(steps) {
            if covered == 300 {
                *cell = Some(amount * 12.0);
                kept += amount;
            } else {
                silent += 1;
            }
        }
        let what = "steps more than 24 h after a rate, or without one: missing";
        account.note(Place::column(&self.file, DOSE), what, silent);
        let outside = source - kept;
        if outside > 1e-9 * source.max(1.0) {
            let what = format!("{outside:.2} U of basal outside whole steps of the span: left out");
            account.note(Place::column(&self.file, DOSE), &what, 1);
        }
        Totals {
            column: Channel::Basal.column().to_owned(),
            unit: "U".to_owned(),
            source: source + injected,
            record: record.basal().iter().flatten().sum::<f64>() / 12.0,
            left_out: outside + injected,
        }
    }

    /// The therapy that the rows indicate.
    pub(super) fn therapy(&self, account: &mut Account<'_>) -> Therapy {
        let place = Place::column(&self.file, KIND);
        let injections = self.injections.len();
        let (Some(first), Some(last)) = (self.rates.first(), self.rates.last()) else {
            let evidence = format!("{injections} long-acting injections and no rate");
            account.infer(place, "therapy mdi", evidence);
            return Therapy::Mdi;
        };
        let days = (seconds(first.time, last.time) / 86_400.0).max(1.0 / STEPS_PER_DAY as f64);
        let changes = (self.rates.len() - 1) as f64 / days;
        let evidence =
            format!("{changes:.1} rates a day over {days:.1} days, {injections} injections");
        if changes >= CHANGES_OF_A_CONTROLLER {
            account.infer(place, "therapy aid: a controller sets the rate", evidence);
            Therapy::Aid
        } else {
            account.infer(place, "therapy open_loop_pump: a programmed profile", evidence);
            Therapy::OpenLoopPump
        }
    }
}

/// Where the pump's rates are missing, boluses of 0 become missing too. Where rates are recorded, a
/// step without a bolus had none, also before the first bolus and after the last.
pub(super) fn silence_between(record: &mut Record, has_rates: bool) {
    if !has_rates || record.basal().iter().all(Option::is_none) {
        return;
    }
    let recorded: Vec<bool> = record.basal().iter().map(Option::is_some).collect();
    for (bolus, recorded) in record.channel_mut(Channel::Bolus).iter_mut().zip(recorded) {
        match *bolus {
            None if recorded => *bolus = Some(0.0),
            Some(0.0) if !recorded => *bolus = None,
            _ => {}
        }
    }
}

fn seconds(from: NaiveDateTime, to: NaiveDateTime) -> f64 {
    to.signed_duration_since(from).num_seconds() as f64
}
