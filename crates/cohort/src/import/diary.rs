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

use std::borrow::Cow;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, HashSet};

use chrono::NaiveDateTime;
use physiology::{Kilograms, MG_PER_DL_PER_MMOL_PER_L, STEPS_PER_DAY, STEPS_PER_HOUR};

use contract::import_report::{Inference, Totals};

use super::rates::{COVERED, Held, Laid, lay, therapy_of};
use super::report::{Imported, Notes, assemble_measured, inference, totals_of};
use super::steps::{STEP, Span, step_of, time_of};
use crate::error::{CohortError, Place};
use crate::person::{Person, Therapy};
use crate::range::{check_value, looks_like_mmol};
use crate::record::{Channel, MAX_DAYS, Record, longest};

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

/// A channel's cells of one day.
type Page = [Cell; STEPS_PER_DAY];

/// A basal rate, U/h, from a second to another (`None`: until the next rate).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rate {
    pub(super) from: i64,
    pub(super) to: Option<i64>,
    pub(super) u_h: f64,
}

/// The unit of a source's glucose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum GlucoseUnit {
    /// mg/dL, stated by the format.
    MgPerDl,
    /// Not stated: mmol/L if the median can be nothing else.
    Inferred,
}

/// One person's events.
pub(super) struct Diary {
    id: String,
    file: String,
    /// Body weight.
    pub(super) weight: Option<Kilograms>,
    /// Therapy as the source states it; inferred from the rates if it does not.
    pub(super) therapy: Option<Therapy>,
    /// Unit of the readings.
    pub(super) glucose: GlucoseUnit,
    pages: BTreeMap<(Channel, i64), Box<Page>>,
    /// Pages of each channel.
    days: [i64; Channel::ALL.len()],
    rates: Vec<Rate>,
    /// Injected insulin, U, that no rate and no bolus describes.
    injected: f64,
    /// Second, duration and amount of each bolus.
    boluses: HashSet<(i64, i64, u64)>,
    /// Sum over the source and over repeated entries, by channel.
    doses: BTreeMap<Channel, (f64, f64)>,
    tally: Vec<(Cow<'static, str>, Place, usize)>,
    inferences: Vec<Inference>,
}

/// Seconds from 1970 on the local clock.
pub(super) fn second(time: NaiveDateTime) -> i64 {
    time.and_utc().timestamp()
}

impl Diary {
    /// An empty diary; `file` is named where something concerns all of it.
    pub(super) fn new(id: &str, file: &str, glucose: GlucoseUnit) -> Self {
        Self {
            id: id.into(),
            file: file.into(),
            weight: None,
            therapy: None,
            glucose,
            pages: BTreeMap::new(),
            days: [0; Channel::ALL.len()],
            rates: Vec::new(),
            injected: 0.0,
            boluses: HashSet::new(),
            doses: BTreeMap::new(),
            tally: Vec::new(),
            inferences: Vec::new(),
        }
    }

    /// The person's identifier.
    pub(super) fn id(&self) -> &str {
        &self.id
    }

    /// The file that is named where something concerns all of the diary.
    pub(super) fn file(&self) -> &str {
        &self.file
    }

    /// Counts one occurrence of `what`; the first place is kept.
    pub(super) fn note(&mut self, what: &'static str, place: impl FnOnce() -> Place) {
        match self.tally.iter_mut().find(|(known, ..)| *known == what) {
            Some((_, _, count)) => *count += 1,
            None => self.tally.push((what.into(), place(), 1)),
        }
    }

    /// Records what was inferred.
    pub(super) fn infer(&mut self, place: Place, conclusion: &str, evidence: String) {
        self.inferences.push(inference(&self.id, place, conclusion, evidence));
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
                    let person = self.id.clone();
                    let limit = MAX_DAYS;
                    return Err(CohortError::TooLong { place: place(), person, days, limit });
                }
                self.days[channel as usize] = days;
                vacant.insert(empty_page())
            }
        };
        let index = usize::try_from(step.rem_euclid(per_day)).expect("a remainder is not negative");
        Ok(&mut page[index])
    }

    /// A sensor reading, in the unit of [`Diary::glucose`].
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
            return Err(CohortError::Cell {
                place: place(),
                value: format!("{seconds} s"),
                expected: "a duration from 0 to 2 days",
            });
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
        let (first, end) = (at.div_euclid(STEP), at + seconds);
        if seconds == 0 {
            let cell = self.cell(channel, first, place)?;
            (cell.sum, cell.weight) = (cell.sum + amount, 1.0);
            return Ok(());
        }
        for step in first..=(end - 1).div_euclid(STEP) {
            let inside = end.min((step + 1) * STEP) - at.max(step * STEP);
            let cell = self.cell(channel, step, place)?;
            cell.sum += amount * inside as f64 / seconds as f64;
            cell.weight = 1.0;
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
            return Err(CohortError::Cell {
                place: place(),
                value: format!("{} s", to - from),
                expected: "an end of sleep within 2 days after its start",
            });
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

    /// An injection of long-acting insulin, U, which no rate describes.
    pub(super) fn long_acting(
        &mut self,
        amount: f64,
        place: impl Fn() -> Place,
    ) -> Result<(), CohortError> {
        self.leave_out_injection(amount, &place)?;
        self.note("long-acting injections, which no basal rate describes: left out", place);
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

    /// The seconds of the first and the last reading's step.
    fn span(&self) -> Option<(i64, i64)> {
        let per_day = STEPS_PER_DAY as i64;
        let mut pages = self.pages.range((Channel::Cgm, i64::MIN)..=(Channel::Cgm, i64::MAX));
        let (&(_, day), page) = pages.next()?;
        let at = page.iter().position(|cell| cell.weight > 0.0)?;
        let first = day * per_day + at as i64;
        let (&(_, day), page) = pages.next_back().unwrap_or((&(Channel::Cgm, day), page));
        let at = page.iter().rposition(|cell| cell.weight > 0.0)?;
        Some((first * STEP, (day * per_day + at as i64) * STEP))
    }

    /// The same; refused where what the diary holds cannot fill a record of that length.
    pub(super) fn record_span(&self) -> Result<Option<(i64, i64)>, CohortError> {
        let Some((first, last)) = self.span() else { return Ok(None) };
        let days = (last - first) / 86_400;
        let entries = self.pages.values().flat_map(|page| page.iter());
        let limit = longest(entries.filter(|cell| cell.weight > 0.0).count());
        if days >= limit {
            let (place, person) = (Place::file(&self.file), self.id.clone());
            return Err(CohortError::TooLong { place, person, days, limit });
        }
        Ok(Some((first, last)))
    }

    /// The person and the account; `None` without a sensor reading.
    pub(super) fn finish(mut self) -> Result<Option<Imported>, CohortError> {
        let Some((first, last)) = self.record_span()? else { return Ok(None) };
        let len = usize::try_from((last - first) / STEP).expect("readings ascend") + 1;
        let mut record = Record::new(time_of(step_of(first)), len)?;
        self.place_cells(first / STEP, &mut record)?;
        self.infer_unit(&mut record)?;

        let mut totals = Vec::new();
        let mut therapy = self.therapy;
        if !self.rates.is_empty() || self.injected > 0.0 {
            let rates = self.resolved();
            totals.push(self.place_rates(&rates, step_of(first), &mut record));
            if therapy.is_none()
                && let Some((found, conclusion, evidence)) = therapy_of(&rates)
            {
                let place = Place::column(&self.file, Channel::Basal.column());
                self.infer(place, conclusion, evidence);
                therapy = Some(found);
            }
        }
        self.fill_zeros(&mut record);
        for (channel, unit) in [(Channel::Basal, "U"), (Channel::Bolus, "U"), (Channel::Carbs, "g")]
        {
            let Some(&(source, repeated)) = self.doses.get(&channel) else { continue };
            let sum: f64 = record.channel(channel).iter().flatten().sum();
            let kept = if channel == Channel::Basal { sum / STEPS_PER_HOUR as f64 } else { sum };
            // Rounding of sums in another order is not an amount.
            let outside = source - repeated - kept;
            let outside = if outside.abs() <= 1e-9 * source.max(1.0) { 0.0 } else { outside };
            self.outside(channel, unit, outside);
            totals.push(totals_of(channel, unit, source, kept, repeated + outside));
        }
        let mut notes = Notes::default();
        for (what, place, count) in self.tally {
            notes.add_many(&self.id, place, &what, count);
        }
        let person = Person {
            id: self.id,
            weight: self.weight,
            therapy: therapy.unwrap_or(Therapy::Unknown),
            heart_rate_baseline: None,
            record,
        };
        let (file, inferences) = (self.file, self.inferences);
        Ok(Some(Imported { person, file, totals, inferences, notes }))
    }

    fn outside(&mut self, channel: Channel, unit: &'static str, amount: f64) {
        if amount > 0.0 {
            let place = Place::column(&self.file, channel.column());
            let what = format!("{amount:.2} {unit} outside whole steps of the record: left out");
            self.tally.push((what.into(), place, 1));
        }
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
                let place = || Place::column(&self.file, channel.column());
                check_value(channel, sum, false, place)?;
                *value = Some(sum);
            }
        }
        Ok(())
    }

    fn infer_unit(&mut self, record: &mut Record) -> Result<(), CohortError> {
        let Some(median) = looks_like_mmol(record.cgm()) else { return Ok(()) };
        let place = Place::column(&self.file, Channel::Cgm.column());
        if self.glucose == GlucoseUnit::MgPerDl {
            let person = self.id.clone();
            return Err(CohortError::LooksLikeMmol { place, person, median });
        }
        for value in record.channel_mut(Channel::Cgm).iter_mut().flatten() {
            *value *= MG_PER_DL_PER_MMOL_PER_L;
            check_value(Channel::Cgm, *value, false, || place.clone())?;
        }
        self.infer(place, "glucose in mmol/L; x 18 mg/dL", format!("median {median}"));
        Ok(())
    }

    /// The rates in order of time, each with its end; a later one ends the one before it.
    fn resolved(&mut self) -> Vec<Held> {
        let mut rates = std::mem::take(&mut self.rates);
        rates.sort_by_key(|rate| rate.from);
        let place = || Place::column(&self.file, Channel::Basal.column());
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
        let next: Vec<i64> = kept.iter().skip(1).map(|rate| rate.from).chain([i64::MAX]).collect();
        let resolved = kept
            .iter()
            .zip(next)
            .map(|(rate, next)| {
                // A rate without an end or a successor says nothing of what followed.
                let open = if next == i64::MAX { rate.from } else { rate.from + HOLD };
                let end = rate.to.unwrap_or(open).max(rate.from);
                cut += usize::from(rate.to.is_some() && end > next);
                (rate.from, end.min(next), rate.u_h)
            })
            .collect();
        for (what, count) in [
            ("rates at one time: the last one of the file holds", twice),
            ("rates that a later one ends", cut),
        ] {
            if count > 0 {
                self.tally.push((what.into(), place(), count));
            }
        }
        resolved
    }

    /// Puts the rates into the record, which begins at the step `first`.
    fn place_rates(&mut self, rates: &[Held], first: i64, record: &mut Record) -> Totals {
        let span = Span { first, end: first + record.len() as i64 };
        let Laid { source, kept, silent, partly } =
            lay(rates.iter().copied(), span, COVERED, 0.0, record);
        let place = || Place::column(&self.file, Channel::Basal.column());
        let silence = "steps without a rate for at least 4 of 5 min: not recorded";
        let part = "steps with a rate for 4 of 5 min only: the amount is kept";
        for (what, count) in [(silence, silent), (part, partly)] {
            if count > 0 && !rates.is_empty() {
                self.tally.push((what.into(), place(), count));
            }
        }
        let outside = source - kept;
        let outside = if outside.abs() <= 1e-9 * source.max(1.0) { 0.0 } else { outside };
        self.outside(Channel::Basal, "U", outside);
        let injected = self.injected;
        totals_of(Channel::Basal, "U", source + injected, kept, outside + injected)
    }

    /// Says where nothing was given, and where a watch was worn without sleep.
    fn fill_zeros(&mut self, record: &mut Record) {
        let basal: Vec<bool> = record.basal().iter().map(Option::is_some).collect();
        for channel in [Channel::Bolus, Channel::Carbs, Channel::SetChange] {
            let cells = record.channel_mut(channel);
            let Some(first) = cells.iter().position(Option::is_some) else { continue };
            let last = cells.iter().rposition(Option::is_some).unwrap_or(first);
            let of_pump = channel != Channel::Carbs;
            for (k, cell) in cells.iter_mut().enumerate() {
                if cell.is_none() && ((first..=last).contains(&k) || of_pump && basal[k]) {
                    *cell = Some(0.0);
                }
            }
        }
        if record.sleep_efficiency().iter().any(Option::is_some) {
            let worn: Vec<bool> = (0..record.len())
                .map(|k| record.heart_rate()[k].is_some() || record.steps()[k].is_some())
                .collect();
            let cells = record.channel_mut(Channel::SleepEfficiency).iter_mut();
            for (cell, worn) in cells.zip(worn) {
                if cell.is_none() && worn {
                    *cell = Some(0.0);
                }
            }
        }
    }
}

/// The people of the diaries, in their order. Who has no sensor reading is left out and named.
pub(super) fn people(
    format: &'static str,
    source: &str,
    diaries: impl IntoIterator<Item = Diary>,
) -> Result<super::Import, CohortError> {
    let people = diaries.into_iter().map(|diary| {
        let (id, file) = (diary.id.clone(), diary.file.clone());
        Ok((id, file, diary.finish()?))
    });
    assemble_measured(format, source, people)
}

fn empty_page() -> Box<Page> {
    let page: Box<[Cell]> = vec![Cell::default(); STEPS_PER_DAY].into_boxed_slice();
    page.try_into().unwrap_or_else(|_| unreachable!("a page has the steps of a day"))
}

fn check_second(at: i64, place: &impl Fn() -> Place) -> Result<(), CohortError> {
    if SECONDS.contains(&at) {
        return Ok(());
    }
    Err(CohortError::Cell {
        place: place(),
        value: format!("{at} s from 1970"),
        expected: "a time within the years 1900 to 2199",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_beyond_the_longest_record_are_refused_where_they_are_read() {
        let mut diary = Diary::new("p", "e.csv", GlucoseUnit::MgPerDl);
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
        let mut diary = Diary::new("p", "e.csv", GlucoseUnit::MgPerDl);
        let place = || Place::row("e.csv", 1);
        let again = |second| Moment { second, again: true };
        // The file begins with the last reading; those of the second hour are on the grid.
        diary.reading(again(600), 130.0, place).expect("a reading");
        diary.reading(again(300), 120.0, place).expect("a reading");
        diary.reading(310, 100.0, place).expect("a reading");
        diary.reading(0, 90.0, place).expect("a reading");
        let imported = diary.finish().expect("a record").expect("a reading");
        let glucose = imported.person.record.channel(Channel::Cgm);
        assert_eq!(glucose, [Some(90.0), Some(100.0), Some(130.0)]);
    }

    #[test]
    fn insulin_that_is_left_out_is_part_of_the_source() {
        let mut diary = Diary::new("p", "e.csv", GlucoseUnit::MgPerDl);
        let place = || Place::row("e.csv", 1);
        diary.reading(0, 100.0, place).expect("a reading");
        diary.leave_out_injection(12.0, place).expect("an amount");
        assert!(diary.leave_out_injection(-1.0, place).is_err());
        let imported = diary.finish().expect("a record").expect("a reading");
        let basal = &imported.totals[0];
        assert_eq!((basal.source, basal.record, basal.left_out), (12.0, 0.0, 12.0));
    }
}
