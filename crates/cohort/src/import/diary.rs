//! One person's events, laid on the five-minute grid as they are read.
//!
//! Importers of event logs pass each event on and keep nothing themselves, so that memory grows
//! with days and not with rows. The record spans the first to the last sensor reading.
//!
//! - A reading belongs to the nearest step; of several the nearest in time stays, then the first.
//! - Doses are summed; one with a duration is spread evenly over it.
//! - Rates hold until their end, or until a later rate begins. A step holds the amount of its five
//!   minutes as a rate, and is recorded if rates cover four of them.
//! - Boluses are 0 where rates are recorded, and between the first and the last bolus; carbohydrate
//!   is 0 between the first and the last entry. Elsewhere they are not recorded.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, HashSet};
use std::path::Path;

use chrono::NaiveDateTime;
use physiology::{Kilograms, MG_PER_DL_PER_MMOL_PER_L, STEPS_PER_DAY, STEPS_PER_HOUR};

use super::rates::{COVERED, Held, lay, therapy_of, unless_rounding};
use super::report::{Account, DAYS_OF_READINGS, Imported, assemble};
use super::steps::{STEP, Span, time_of};
use crate::error::{CohortError, Place};
use crate::person::{Person, Therapy};
use crate::range::{check_unit, check_value, looks_like_mmol};
use crate::record::{Channel, MAX_DAYS, Record, check_span};

/// Longest time a rate without an end holds, s: a pump confirms its rate once a day.
const HOLD: i64 = 86_400;
/// Longest duration of a dose, s.
const LONGEST_DOSE: i64 = 2 * 86_400;
/// The first second of 1900 and of 2200, from 1970.
pub(super) const SECONDS: std::ops::Range<i64> = -2_208_988_800..7_258_118_400;

/// A second on a person's wall clock, from 1970.
#[derive(Clone, Copy)]
pub(super) struct Moment {
    pub(super) second: i64,
    /// Whether the clock showed it before: it was set back in between.
    pub(super) again: bool,
}

impl From<i64> for Moment {
    fn from(second: i64) -> Self {
        Self { second, again: false }
    }
}

/// Sum and weight in one step of a channel; the weight is 0 where nothing was recorded.
#[derive(Clone, Copy, Default)]
struct Cell {
    sum: f64,
    weight: f32,
}

/// A basal rate, U/h, from a second to another (`None`: until the next rate).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rate {
    pub(super) from: i64,
    pub(super) to: Option<i64>,
    pub(super) u_h: f64,
}

/// One person's events.
#[derive(Default)]
pub(super) struct Diary {
    pub(super) account: Account,
    /// Body weight.
    pub(super) weight: Option<Kilograms>,
    /// Therapy as the source states it; inferred from the rates if it does not.
    pub(super) therapy: Option<Therapy>,
    /// Whether the format leaves the unit of glucose open: it is mmol/L if the median can be
    /// nothing else. Otherwise it is mg/dL.
    pub(super) unit_is_open: bool,
    /// The cells of each channel by day.
    pages: BTreeMap<(Channel, i64), Box<[Cell]>>,
    /// Pages of each channel.
    days: [i64; Channel::ALL.len()],
    rates: Vec<Rate>,
    /// Injected insulin, U, that no rate and no bolus describes.
    injected: f64,
    /// Second, duration and amount of each bolus.
    boluses: HashSet<(i64, i64, u64)>,
    /// Sum over the source and over repeated entries, by channel.
    doses: BTreeMap<Channel, (f64, f64)>,
    /// What was noted, where first, and how often.
    tally: Vec<(&'static str, Place, usize)>,
}

/// Seconds from 1970 on the local clock.
pub(super) fn second(time: NaiveDateTime) -> i64 {
    time.and_utc().timestamp()
}

impl Diary {
    /// An empty diary; `file` is named where something concerns all of it.
    pub(super) fn new(id: &str, file: &str) -> Self {
        Self { account: Account::new(id, file), ..Self::default() }
    }

    /// Counts one occurrence of `what`; the first place is kept.
    pub(super) fn note(&mut self, what: &'static str, place: impl FnOnce() -> Place) {
        match self.tally.iter_mut().find(|(known, ..)| *known == what) {
            Some((_, _, count)) => *count += 1,
            None => self.tally.push((what, place(), 1)),
        }
    }

    /// A step's cell. Refuses a day beyond those that the longest record touches.
    fn cell(
        &mut self,
        channel: Channel,
        step: i64,
        place: &impl Fn() -> Place,
    ) -> Result<&mut Cell, CohortError> {
        let per_day = STEPS_PER_DAY as i64;
        let page = match self.pages.entry((channel, step.div_euclid(per_day))) {
            Entry::Occupied(page) => page.into_mut(),
            Entry::Vacant(vacant) => {
                let days = self.days[channel as usize] + 1;
                // Both ends of the longest record may lie within a day.
                if days > MAX_DAYS + 1 {
                    let (place, person, limit) = (place(), self.account.id.clone(), MAX_DAYS);
                    return Err(CohortError::TooLong { place, person, days, limit });
                }
                self.days[channel as usize] = days;
                vacant.insert(vec![Cell::default(); STEPS_PER_DAY].into())
            }
        };
        let index = usize::try_from(step.rem_euclid(per_day)).expect("a remainder is not negative");
        Ok(&mut page[index])
    }

    /// A sensor reading, in mg/dL or in the unit that is found out.
    pub(super) fn reading(
        &mut self,
        at: impl Into<Moment>,
        value: f64,
        place: impl Fn() -> Place,
    ) -> Result<(), CohortError> {
        let Moment { second: at, again } = at.into();
        check_second(at, &place)?;
        check_value(Channel::Cgm, value, false, &place)?;
        let step = (at + STEP / 2).div_euclid(STEP);
        // Nearer readings weigh more, half of a step at least; at equal distance the first one stays.
        let near = (STEP - (at - step * STEP).abs()) as f32;
        // The hour that comes again only fills gaps.
        let weight = if again { near / STEP as f32 } else { near };
        let cell = self.cell(Channel::Cgm, step, &place)?;
        let (taken, same) = (cell.weight > 0.0, cell.weight == weight && cell.sum == value);
        if weight > cell.weight {
            *cell = Cell { sum: value, weight };
        }
        if same {
            self.note("readings given twice: one is kept", place);
        } else if taken {
            self.note("readings beside a nearer or earlier one of the step: left out", place);
        }
        Ok(())
    }

    /// An amount (basal insulin, bolus or carbohydrate) given evenly over `seconds`; 0 for all at
    /// once.
    pub(super) fn dose(
        &mut self,
        channel: Channel,
        at: i64,
        seconds: i64,
        amount: f64,
        place: impl Fn() -> Place,
    ) -> Result<(), CohortError> {
        check_second(at, &place)?;
        check_value(channel, amount, false, &place)?;
        if !(0..=LONGEST_DOSE).contains(&seconds) {
            let expected = "a duration from 0 to 2 days";
            return Err(CohortError::cell(place(), &format!("{seconds} s"), expected));
        }
        let sums = self.doses.entry(channel).or_default();
        sums.0 += amount;
        // A pump gives no two equal boluses at one second; a meal may have two equal parts.
        let again = channel == Channel::Bolus
            && amount > 0.0
            && !self.boluses.insert((at, seconds, amount.to_bits()));
        if again {
            sums.1 += amount;
            self.note("boluses given twice at the same second: one is kept", place);
            return Ok(());
        }
        self.spread(channel, at, seconds, amount, &place)
    }

    /// Adds an amount to the steps of an interval.
    fn spread(
        &mut self,
        channel: Channel,
        at: i64,
        seconds: i64,
        amount: f64,
        place: &impl Fn() -> Place,
    ) -> Result<(), CohortError> {
        let end = at + seconds;
        for step in at.div_euclid(STEP)..=(end - 1).max(at).div_euclid(STEP) {
            let inside = end.min((step + 1) * STEP) - at.max(step * STEP);
            let part = if seconds == 0 { amount } else { amount * inside as f64 / seconds as f64 };
            let cell = self.cell(channel, step, place)?;
            (cell.sum, cell.weight) = (cell.sum + part, 1.0);
        }
        Ok(())
    }

    /// Steps walked within `seconds` from `at`.
    pub(super) fn steps(
        &mut self,
        at: i64,
        seconds: i64,
        count: f64,
        place: impl Fn() -> Place,
    ) -> Result<(), CohortError> {
        check_second(at, &place)?;
        check_value(Channel::Steps, count, false, &place)?;
        self.spread(Channel::Steps, at, seconds.clamp(0, HOLD), count, &place)
    }

    /// A heart rate, 1/min; the step holds the mean.
    pub(super) fn heart_rate(
        &mut self,
        at: i64,
        value: f64,
        place: impl Fn() -> Place,
    ) -> Result<(), CohortError> {
        check_second(at, &place)?;
        check_value(Channel::HeartRate, value, false, &place)?;
        if value == 0.0 {
            self.note("heart rates of 0: no signal, left out", place);
            return Ok(());
        }
        let cell = self.cell(Channel::HeartRate, at.div_euclid(STEP), &place)?;
        (cell.sum, cell.weight) = (cell.sum + value, cell.weight + 1.0);
        Ok(())
    }

    /// An interval in bed, of which `seconds` asleep are spread evenly over it.
    pub(super) fn asleep(
        &mut self,
        from: i64,
        to: i64,
        seconds: i64,
        place: impl Fn() -> Place,
    ) -> Result<(), CohortError> {
        check_second(from, &place)?;
        if !(0..=LONGEST_DOSE).contains(&(to - from)) {
            let expected = "an end of sleep within 2 days after its start";
            return Err(CohortError::cell(place(), &format!("{} s", to - from), expected));
        }
        if to > from {
            let seconds = seconds.clamp(0, to - from);
            self.spread(Channel::SleepEfficiency, from, to - from, seconds as f64, &place)?;
        }
        Ok(())
    }

    /// A change of the infusion set.
    pub(super) fn set_change(
        &mut self,
        at: i64,
        place: impl Fn() -> Place,
    ) -> Result<(), CohortError> {
        check_second(at, &place)?;
        let cell = self.cell(Channel::SetChange, at.div_euclid(STEP), &place)?;
        *cell = Cell { sum: 1.0, weight: 1.0 };
        Ok(())
    }

    /// Counts injected insulin, U, that is left out.
    pub(super) fn leave_out_injection(
        &mut self,
        amount: f64,
        place: impl Fn() -> Place,
    ) -> Result<(), CohortError> {
        check_value(Channel::Bolus, amount, false, place)?;
        self.injected += amount;
        Ok(())
    }

    /// A basal rate.
    pub(super) fn rate(
        &mut self,
        rate: Rate,
        place: impl Fn() -> Place,
    ) -> Result<(), CohortError> {
        check_second(rate.from, &place)?;
        check_value(Channel::Basal, rate.u_h, false, place)?;
        match self.rates.last_mut() {
            // A rate that goes on.
            Some(last)
                if last.u_h == rate.u_h && last.to == Some(rate.from) && rate.to.is_some() =>
            {
                last.to = rate.to;
            }
            _ => self.rates.push(rate),
        }
        Ok(())
    }

    /// The steps from the first to the last reading; refused where what the diary holds cannot
    /// fill a record of that length.
    pub(super) fn record_span(&self) -> Result<Option<Span>, CohortError> {
        let per_day = STEPS_PER_DAY as i64;
        let pages = self.pages.range((Channel::Cgm, i64::MIN)..=(Channel::Cgm, i64::MAX));
        let mut readings = pages.flat_map(|((_, day), page)| {
            let taken = page.iter().enumerate().filter(|(_, cell)| cell.weight > 0.0);
            taken.map(move |(at, _)| day * per_day + at as i64)
        });
        let Some(first) = readings.next() else { return Ok(None) };
        let last = readings.next_back().unwrap_or(first);
        let entries = self.pages.values().flat_map(|page| page.iter());
        let entries = entries.filter(|cell| cell.weight > 0.0).count();
        let Account { id, file, .. } = &self.account;
        check_span((last - first) / per_day, entries, id, || Place::file(file))?;
        Ok(Some(Span { first, end: last + 1 }))
    }

    /// The person and the account; nobody without a sensor reading.
    pub(super) fn finish(mut self) -> Result<Imported, CohortError> {
        let Some(span) = self.record_span()? else {
            return Ok(Imported { person: None, account: self.account });
        };
        for (what, place, count) in std::mem::take(&mut self.tally) {
            self.account.note(place, what, count);
        }
        let mut record = Record::new(time_of(span.first), span.len())?;
        self.place_cells(span.first, &mut record)?;
        self.find_unit(&mut record)?;
        let mut therapy = self.therapy;
        if !self.rates.is_empty() || self.injected > 0.0 {
            let rates = self.resolved();
            self.place_rates(&rates, span, &mut record);
            if therapy.is_none()
                && let Some((found, conclusion, evidence)) = therapy_of(&rates)
            {
                self.account.infer(self.column(Channel::Basal), conclusion, evidence);
                therapy = Some(found);
            }
        }
        fill_zeros(&mut record);
        for (channel, unit) in [(Channel::Basal, "U"), (Channel::Bolus, "U"), (Channel::Carbs, "g")]
        {
            let Some(&(source, repeated)) = self.doses.get(&channel) else { continue };
            let sum: f64 = record.channel(channel).iter().flatten().sum();
            let kept = if channel == Channel::Basal { sum / STEPS_PER_HOUR as f64 } else { sum };
            let outside = self.outside(channel, unit, source - repeated - kept, source);
            self.account.total(channel, unit, source, kept, repeated + outside);
        }
        let person = Person {
            id: self.account.id.clone(),
            weight: self.weight,
            therapy: therapy.unwrap_or(Therapy::Unknown),
            heart_rate_baseline: None,
            record,
        };
        Ok(Imported { person: Some(person), account: self.account })
    }

    /// The column of a channel, for messages.
    fn column(&self, channel: Channel) -> Place {
        Place::column(&self.account.file, channel.name())
    }

    /// An amount of the source that is not in the record, with a note of it.
    fn outside(&mut self, channel: Channel, unit: &str, amount: f64, source: f64) -> f64 {
        let amount = unless_rounding(amount, source);
        let what = format!("{amount:.2} {unit} outside whole steps of the record: left out");
        self.account.note(self.column(channel), &what, usize::from(amount > 0.0));
        amount
    }

    /// Puts every channel but the basal rate into the record, which begins at `first`.
    fn place_cells(&mut self, first: i64, record: &mut Record) -> Result<(), CohortError> {
        for ((channel, day), page) in std::mem::take(&mut self.pages) {
            let cells = record.channel_mut(channel);
            for (i, cell) in page.iter().enumerate().filter(|(_, cell)| cell.weight > 0.0) {
                let step = day * STEPS_PER_DAY as i64 + i as i64 - first;
                let Some(value) = usize::try_from(step).ok().and_then(|k| cells.get_mut(k)) else {
                    continue;
                };
                let sum = match channel {
                    Channel::Basal => cell.sum * STEPS_PER_HOUR as f64,
                    Channel::HeartRate => cell.sum / f64::from(cell.weight),
                    Channel::SleepEfficiency => (cell.sum / STEP as f64).min(1.0),
                    _ => cell.sum,
                };
                check_value(channel, sum, false, || self.column(channel))?;
                *value = Some(sum);
            }
        }
        Ok(())
    }

    fn find_unit(&mut self, record: &mut Record) -> Result<(), CohortError> {
        let place = self.column(Channel::Cgm);
        if !self.unit_is_open {
            return check_unit(record.cgm(), &self.account.id, || place);
        }
        let Some(median) = looks_like_mmol(record.cgm()) else { return Ok(()) };
        for value in record.channel_mut(Channel::Cgm).iter_mut().flatten() {
            *value *= MG_PER_DL_PER_MMOL_PER_L;
            check_value(Channel::Cgm, *value, false, || place.clone())?;
        }
        self.account.infer(place, "glucose in mmol/L; x 18 mg/dL", format!("median {median}"));
        Ok(())
    }

    /// The rates in order of time, each with its end; a later one ends the one before it.
    fn resolved(&mut self) -> Vec<Held> {
        let mut rates = std::mem::take(&mut self.rates);
        rates.sort_by_key(|rate| rate.from);
        let (mut twice, mut cut) = (0, 0);
        let mut kept: Vec<Rate> = Vec::with_capacity(rates.len());
        for rate in rates {
            match kept.last_mut() {
                Some(last) if last.from == rate.from => {
                    twice += 1;
                    *last = rate;
                }
                _ => kept.push(rate),
            }
        }
        let next = kept.iter().skip(1).map(|rate| rate.from).chain([i64::MAX]);
        let end = |(rate, next): (&Rate, i64)| {
            // A rate without an end or a successor says nothing of what followed.
            let open = if next == i64::MAX { rate.from } else { rate.from + HOLD };
            let end = rate.to.unwrap_or(open).max(rate.from);
            cut += usize::from(rate.to.is_some() && end > next);
            (rate.from, end.min(next), rate.u_h)
        };
        let resolved = kept.iter().zip(next).map(end).collect();
        let place = self.column(Channel::Basal);
        let what = "rates at one time: the last one of the file holds";
        self.account.note(place.clone(), what, twice);
        self.account.note(place, "rates that a later one ends", cut);
        resolved
    }

    /// Puts the rates into the record of `span`.
    fn place_rates(&mut self, rates: &[Held], span: Span, record: &mut Record) {
        let laid = lay(rates.iter().copied(), span, COVERED, 0.0, record);
        if !rates.is_empty() {
            let place = self.column(Channel::Basal);
            let what = "steps without a rate for at least 4 of 5 min: not recorded";
            self.account.note(place.clone(), what, laid.silent);
            let what = "steps with a rate for 4 of 5 min only: the amount is kept";
            self.account.note(place, what, laid.partly);
        }
        let outside = self.outside(Channel::Basal, "U", laid.source - laid.kept, laid.source);
        let (source, injected) = (laid.source + self.injected, self.injected);
        self.account.total(Channel::Basal, "U", source, laid.kept, outside + injected);
    }
}

/// Says where nothing was given, and where a watch was worn without sleep.
fn fill_zeros(record: &mut Record) {
    let basal: Vec<bool> = record.basal().iter().map(Option::is_some).collect();
    for channel in [Channel::Bolus, Channel::Carbs, Channel::SetChange] {
        let cells = record.channel_mut(channel);
        let Some(first) = cells.iter().position(Option::is_some) else { continue };
        let last = cells.iter().rposition(Option::is_some).unwrap_or(first);
        let of_pump = channel != Channel::Carbs;
        for (k, cell) in cells.iter_mut().enumerate() {
            if (first..=last).contains(&k) || of_pump && basal[k] {
                cell.get_or_insert(0.0);
            }
        }
    }
    if record.sleep_efficiency().iter().any(Option::is_some) {
        let worn: Vec<bool> = (0..record.len())
            .map(|k| record.heart_rate()[k].is_some() || record.steps()[k].is_some())
            .collect();
        let cells = record.channel_mut(Channel::SleepEfficiency).iter_mut();
        for (cell, _) in cells.zip(worn).filter(|(_, worn)| *worn) {
            cell.get_or_insert(0.0);
        }
    }
}

/// The people of the diaries, in their order. Who has no sensor reading is left out and named.
pub(super) fn people(
    format: &'static str,
    source: &Path,
    diaries: impl IntoIterator<Item = Diary>,
) -> Result<super::Import, CohortError> {
    assemble(format, source.display(), DAYS_OF_READINGS, diaries.into_iter().map(Diary::finish))
}

fn check_second(at: i64, place: &impl Fn() -> Place) -> Result<(), CohortError> {
    if SECONDS.contains(&at) {
        return Ok(());
    }
    let expected = "a time within the years 1900 to 2199";
    Err(CohortError::cell(place(), &format!("{at} s from 1970"), expected))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_beyond_the_longest_record_are_refused_where_they_are_read() {
        let mut diary = Diary::new("p", "e.csv");
        // A reading a day from 1970.
        let mut read =
            |day: i64| diary.reading(day * 86_400, 100.0, || Place::row("e.csv", day as usize));
        for day in 0..=MAX_DAYS {
            read(day).expect("within the longest record");
        }
        read(0).expect("a day that is known");
        let error = read(MAX_DAYS + 1).expect_err("too many days").to_string();
        let says = "e.csv, row 7321: person 'p' spans 7322 days, more than 7320";
        assert!(error.contains(says), "{error}");
    }

    #[test]
    fn the_hour_that_comes_again_only_fills_gaps() {
        let mut diary = Diary::new("p", "e.csv");
        let place = || Place::row("e.csv", 1);
        let again = |second| Moment { second, again: true };
        // The file begins with the last reading; those of the second hour are on the grid.
        diary.reading(again(600), 130.0, place).expect("a reading");
        diary.reading(again(300), 120.0, place).expect("a reading");
        diary.reading(310, 100.0, place).expect("a reading");
        diary.reading(0, 90.0, place).expect("a reading");
        let person = diary.finish().expect("a record").person.expect("a reading");
        assert_eq!(person.record.cgm(), [Some(90.0), Some(100.0), Some(130.0)]);
    }

    #[test]
    fn insulin_that_is_left_out_is_part_of_the_source() {
        let mut diary = Diary::new("p", "e.csv");
        let place = || Place::row("e.csv", 1);
        diary.reading(0, 100.0, place).expect("a reading");
        diary.leave_out_injection(12.0, place).expect("an amount");
        assert!(diary.leave_out_injection(-1.0, place).is_err());
        let imported = assemble("f", "", "", [diary.finish()]).expect("a reading");
        let basal = &imported.report.people[0].totals.as_ref().expect("totals")[0];
        assert_eq!((basal.source, basal.record, basal.left_out), (12.0, 0.0, 12.0));
    }
}
