//! `Insulin Data`: pump rates, long-acting injections and boluses.
//!
//! Basal rows of kind `R` are U/h from their time until the next one. A step holds the mean over
//! its five minutes, so amounts are kept exactly. Rows of kind `L` are injections of long-acting
//! insulin, which no basal rate describes without a model of their absorption. They are left out
//! and counted. A person who has only those is on `mdi` with the basal missing.

use physiology::STEPS_PER_DAY;

use super::events::{Event, Events, Stamp, stamp};
use crate::error::{CohortError, Place};
use crate::import::diary::second;
use crate::import::rates::{Held, lay, therapy_of_changes};
use crate::import::report::Account;
use crate::import::steps::{STEP, Span, step_of};
use crate::person::Therapy;
use crate::range::check_value;
use crate::record::{Channel, Record};
use crate::text_table::TextTable;

const TIME: &str = "basal_ts";
const DOSE: &str = "basal_dose";
const KIND: &str = "insulin_kind";
/// A programmed rate changes or is confirmed at least once a day, s; after that the pump counts as
/// silent.
const HOLD: i64 = 86_400;

/// Pump rates and injections of one person.
pub(super) struct Basal {
    file: String,
    /// Rate changes, U/h, in order, one per time.
    rates: Vec<Event>,
    /// Long-acting injections, U.
    injections: Vec<Event>,
}

/// Reads a basal file.
pub(super) fn basal(table: &TextTable, account: &mut Account) -> Result<Basal, CohortError> {
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
                check_value(Channel::Basal, value, false, || doses.place(i))?;
                let late = rates.last().is_some_and(|last| time < last.time);
                let what = "rows earlier than the row above: sorted";
                account.note(times.place(i), what, usize::from(late));
                rates.push(event);
            }
            Some("L") => {
                check_value(Channel::Bolus, value, false, || doses.place(i))?;
                let what = "long-acting injections, which no basal rate describes: left out";
                account.note(doses.place(i), what, 1);
                injections.push(event);
            }
            _ => return Err(kinds.wrong(i, "R (a rate) or L (a long-acting injection)")),
        }
    }
    rates.sort_by_key(|event| event.time);
    rates.dedup_by(|later, kept| {
        let again = later.time == kept.time;
        if again {
            let what = "rates at one time: the last one of the file holds";
            account.note(later.place.clone(), what, 1);
            std::mem::swap(later, kept);
        }
        again
    });
    if rates.is_empty() && injections.is_empty() {
        return Err(CohortError::empty(table.file()));
    }
    Ok(Basal { file: table.file().into(), rates, injections })
}

/// Reads a bolus file.
pub(super) fn bolus(table: &TextTable, account: &mut Account) -> Result<Events, CohortError> {
    let events = Events::read(table, "bolus_ts", "bolus_dose", Channel::Bolus, 1.0, account)?;
    let zeros = events.events.iter().filter(|event| event.value == 0.0).count();
    account.note(Place::column(table.file(), "bolus_dose"), "boluses of 0 U: kept as 0", zeros);
    Ok(events)
}

impl Basal {
    /// The steps that lie wholly between the first and the last rate.
    pub(super) fn span(&self) -> Option<Span> {
        let (first, last) = (self.rates.first()?, self.rates.last()?);
        let before = second(first.time) - 1;
        Some(Span { first: step_of(before) + 1, end: step_of(second(last.time)) })
    }

    /// Each rate with its start and end.
    fn held(&self) -> impl Iterator<Item = Held> + '_ {
        self.rates.iter().zip(self.rates.iter().skip(1)).map(|(rate, next)| {
            let from = second(rate.time);
            (from, second(next.time).min(from + HOLD), rate.value)
        })
    }

    /// Puts the mean rate of each step that is wholly covered into the record.
    pub(super) fn place(&self, span: &Span, record: &mut Record, account: &mut Account) {
        let laid = lay(self.held(), *span, STEP, 0.0, record);
        let injected: f64 = self.injections.iter().map(|event| event.value).sum();
        let place = Place::column(&self.file, DOSE);
        let what = "steps more than 24 h after a rate, or without one: missing";
        account.note(place.clone(), what, laid.silent);
        let outside = laid.source - laid.kept;
        let any = outside > 1e-9 * laid.source.max(1.0);
        let what = format!("{outside:.2} U of basal outside whole steps of the span: left out");
        account.note(place, &what, usize::from(any));
        let kept = record.basal().iter().flatten().sum::<f64>() / 12.0;
        account.total(Channel::Basal, "U", laid.source + injected, kept, outside + injected);
    }

    /// The therapy that the rows indicate.
    pub(super) fn therapy(&self, account: &mut Account) -> Therapy {
        let place = Place::column(&self.file, KIND);
        let injections = self.injections.len();
        let (Some(first), Some(last)) = (self.rates.first(), self.rates.last()) else {
            let evidence = format!("{injections} long-acting injections and no rate");
            account.infer(place, "therapy mdi", evidence);
            return Therapy::Mdi;
        };
        let days = (second(last.time) - second(first.time)) as f64 / 86_400.0;
        let days = days.max(1.0 / STEPS_PER_DAY as f64);
        let changes = (self.rates.len() - 1) as f64 / days;
        let evidence =
            format!("{changes:.1} rates a day over {days:.1} days, {injections} injections");
        let (therapy, conclusion) = therapy_of_changes(changes);
        account.infer(place, conclusion, evidence);
        therapy
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
