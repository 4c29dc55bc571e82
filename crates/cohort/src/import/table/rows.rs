//! The rows of one file as events of people.

use std::collections::{BTreeMap, HashSet};
use std::hash::{DefaultHasher, Hash as _, Hasher as _};

use chrono::{Datelike as _, NaiveDateTime, TimeDelta};

use super::clock::{Clock, Hour, Local};
use super::layout::Opened;
use super::log::{Event, Log};
use super::numbers::{Evidence, Numbers};
use super::options::Role;
use super::plan::{Found, Plan};
use super::stamp::{DateOrder, Stamp};
use super::unit::{Unit, glucose_unit_in, glucose_unit_of};
use crate::error::{CohortError, Place};
use crate::import::report::Account;
use crate::person::{is_person_id, with_id_letters};
use crate::range::{check_value, median};
use crate::record::Channel;
use crate::text_table::TextTable;

/// Texts that say that there is no value.
const NOTHING: [&str; 10] = ["na", "n/a", "#n/a", "nan", "null", "none", "nr", "-", "--", "---"];
/// What a sensor writes below and above its range.
const LOW: [&str; 6] = ["low", "lo", "<40", "bajo", "niedrig", "laag"];
const HIGH: [&str; 6] = ["high", "hi", ">400", "alto", "hoch", "hoog"];
/// The bounds of a sensor, mg/dL.
const LOWEST: f64 = 40.0;
const HIGHEST: f64 = 400.0;
/// Share of the span of dates at which an order of day and month is the continuous one.
const CONTINUOUS: f64 = 0.2;
const UNIQUE_EXPECTED: &str = "a name that stays unique in letters, digits, '_', '-' and '.'";
const TIME_EXPECTED: &str = "a time like 2024-03-01 08:05 or 31/12/2024 08:05";

/// A mapped column of one file.
struct Column {
    role: Role,
    index: usize,
    /// Columns whose sum counts where the column itself is empty.
    parts: Vec<usize>,
    /// Columns and the texts of which they must hold one.
    only: Vec<(usize, Vec<String>)>,
    unit: Unit,
}

/// A file whose columns are known.
pub(super) struct File<'a> {
    opened: &'a Opened,
    person: Option<usize>,
    time: usize,
    clock: Option<usize>,
    columns: Vec<Column>,
    /// Where the file has each column of the plan.
    pub(super) found: Vec<Found>,
}

impl<'a> File<'a> {
    /// Finds the columns of the plan. `files` are the names that may stand before a column's.
    pub(super) fn new(
        opened: &'a Opened,
        plan: &Plan,
        files: &[String],
    ) -> Result<Self, CohortError> {
        let table = &opened.table;
        let found = plan.found(table, &opened.stem, files);
        let find = |role| plan.columns(role, &found).first().copied();
        let absent =
            |column: &str| CohortError::missing_column(table.file(), column, table.header());
        let missing =
            |role: Role| absent(&plan.names(role).unwrap_or_else(|| role.name().to_owned()));
        let (time, clock) = match (find(Role::Time), find(Role::Date), find(Role::Clock)) {
            (Some(time), _, _) => (time, None),
            (None, Some(date), Some(clock)) => (date, Some(clock)),
            (None, Some(_), None) => return Err(missing(Role::Clock)),
            (None, None, _) => return Err(missing(Role::Time)),
        };
        let person = find(Role::Person);
        if person.is_none() && plan.has(Role::Person) {
            return Err(missing(Role::Person));
        }
        let mut columns = Vec::new();
        for role in Role::ALL.into_iter().filter(|role| role.channel().is_some()) {
            let parts = plan.parts(role).iter().filter_map(|name| plan.find(name, table));
            let parts: Vec<usize> = parts.collect();
            let indices = match plan.columns(role, &found) {
                found if found.is_empty() => parts.first().copied().into_iter().collect(),
                // A known format has several names of one column, a user's map several columns.
                found if !plan.is_users() => found[..1].to_vec(),
                found => found,
            };
            if let [one, other, ..] = indices[..]
                && !matches!(role, Role::Bolus | Role::Carbs)
            {
                let [one, other] = [one, other].map(|at| &table.header()[at]);
                let reason =
                    format!("'{one}' and '{other}' of {} are both {}", table.file(), role.name());
                return Err(CohortError::option("--map", reason));
            }
            let mut only = Vec::new();
            for rule in plan.options.only.iter().filter(|rule| rule.role == role) {
                let at = plan.find(&rule.column, table).ok_or_else(|| absent(&rule.column))?;
                only.push((at, rule.values.clone()));
            }
            let unit = Unit::of(role, &plan.options)?;
            for index in indices {
                let (parts, only) = (parts.clone(), only.clone());
                columns.push(Column { role, index, parts, only, unit });
            }
        }
        if columns.is_empty() {
            return Err(missing(Role::Glucose));
        }
        Ok(Self { opened, person, time, clock, columns, found })
    }

    /// The roles that the file has.
    pub(super) fn roles(&self) -> impl Iterator<Item = Role> {
        self.columns.iter().map(|column| column.role)
    }

    fn table(&self) -> &'a TextTable {
        &self.opened.table
    }

    fn place(&self, i: usize, column: usize) -> Place {
        self.table().cell_place(i, column)
    }

    fn column_place(&self, column: usize) -> Place {
        Place::column(self.table().file(), &self.table().header()[column])
    }

    /// The text of the time in row `i`.
    fn written(&self, i: usize) -> Option<String> {
        let date = self.table().cell(i, self.time)?;
        match self.clock {
            None => Some(date.to_owned()),
            Some(clock) => {
                // A date column may hold midnight behind each date.
                let date = date.split([' ', 'T']).next().unwrap_or(date);
                Some(format!("{date} {}", self.table().cell(i, clock).unwrap_or("")))
            }
        }
    }

    /// Whether row `i` belongs to the rows of a column.
    fn counts(&self, column: &Column, i: usize) -> bool {
        column.only.iter().all(|(at, values)| self.holds(i, *at, values))
    }

    /// Whether a cell of row `i` holds one of some texts.
    fn holds(&self, i: usize, at: usize, values: &[String]) -> bool {
        let text = self.table().cell(i, at).unwrap_or("");
        values.iter().any(|value| value.trim().eq_ignore_ascii_case(text))
    }

    /// The order of day and month, with what shows it; `None` if the file leaves it open.
    pub(super) fn order(&self) -> Result<Option<(DateOrder, String)>, CohortError> {
        let (mut first, mut second): (Option<usize>, Option<usize>) = (None, None);
        let mut jumps = [0.0_f64; 2];
        let mut previous: Option<[i64; 2]> = None;
        let mut any = false;
        for i in 0..self.table().height() {
            let Some((a, b, year)) = self.table().cell(i, self.time).and_then(Stamp::open) else {
                continue;
            };
            any = true;
            match (a > 12, b > 12) {
                (true, false) => first = first.or(Some(i)),
                (false, true) => second = second.or(Some(i)),
                _ => {}
            }
            // Days as they would be under either order, roughly.
            let day = |day: u32, month: u32| {
                i64::from(year) * 366 + i64::from(month) * 31 + i64::from(day)
            };
            let days = [day(a, b), day(b, a)];
            if let Some(before) = previous {
                for (jump, (day, before)) in jumps.iter_mut().zip(days.iter().zip(before)) {
                    *jump += (day - before).abs() as f64;
                }
            }
            previous = Some(days);
        }
        if !any {
            return Ok(Some((DateOrder::DayFirst, String::new())));
        }
        let cell = |i| self.table().cell(i, self.time).unwrap_or("").to_owned();
        match (first, second) {
            (Some(day), Some(month)) => Err(CohortError::Undecided {
                place: self.place(month, self.time),
                reason: format!(
                    "'{}' has the month first, '{}' in {} the day",
                    cell(month),
                    cell(day),
                    self.table().place(day)
                ),
                remedy: "write all dates in one way; YYYY-MM-DD is never mistaken",
            }),
            (Some(i), None) => Ok(Some((DateOrder::DayFirst, format!("'{}'", cell(i))))),
            (None, Some(i)) => Ok(Some((DateOrder::MonthFirst, format!("'{}'", cell(i))))),
            (None, None) => {
                let [day_first, month_first] = jumps;
                let (order, days, other) = if day_first < CONTINUOUS * month_first {
                    (DateOrder::DayFirst, day_first, month_first)
                } else if month_first < CONTINUOUS * day_first {
                    (DateOrder::MonthFirst, month_first, day_first)
                } else {
                    return Ok(None);
                };
                let evidence = format!(
                    "from row to row the dates move by {days:.0} days in all, \
                     by {other:.0} in the other order"
                );
                Ok(Some((order, evidence)))
            }
        }
    }

    /// The error of a file whose order stays open.
    pub(super) fn open_order(&self) -> CohortError {
        let open = |i: &usize| self.table().cell(*i, self.time).and_then(Stamp::open).is_some();
        let i = (0..self.table().height()).find(open).unwrap_or(0);
        CohortError::Undecided {
            place: self.place(i, self.time),
            reason: format!(
                "'{}' may have the day or the month first, and no other row decides it",
                self.table().cell(i, self.time).unwrap_or("")
            ),
            remedy: "say --dates day-first or --dates month-first",
        }
    }

    /// How the file writes numbers.
    fn numbers(&self, told: Option<char>) -> Result<Numbers, CohortError> {
        let mut evidence = Evidence::default();
        for column in &self.columns {
            for i in 0..self.table().height() {
                if !self.counts(column, i) {
                    continue;
                }
                for at in std::iter::once(column.index).chain(column.parts.iter().copied()) {
                    if let Some(text) = self.table().cell(i, at) {
                        evidence.see(text, || self.place(i, at));
                    }
                }
            }
        }
        evidence.decide(told)
    }

    /// The factor to mg/dL.
    fn glucose_factor(
        &self,
        column: &Column,
        numbers: Numbers,
        facts: &mut Account,
    ) -> Result<f64, CohortError> {
        let values = (0..self.table().height())
            .filter(|i| self.counts(column, *i))
            .filter_map(|i| numbers.parse(self.table().cell(i, column.index)?));
        let median = median(values.collect());
        let name = &self.table().header()[column.index];
        let seen = median.map(glucose_unit_of);
        let told = match column.unit {
            Unit::Times(1.0) => Some("mg/dL"),
            Unit::Times(_) => Some("mmol/L"),
            _ => None,
        };
        let unit = told.or_else(|| glucose_unit_in(name)).or(seen).unwrap_or("mg/dL");
        if let (Some(seen), Some(median)) = (seen, median)
            && seen != unit
        {
            return Err(CohortError::Undecided {
                place: self.column_place(column.index),
                reason: format!("said to be {unit}, but a median of {median:.1} is {seen}"),
                remedy: "say --unit glucose=mg/dL or --unit glucose=mmol/L, or map another column",
            });
        }
        let shown = median.map_or_else(|| "no number".to_owned(), |m| format!("median {m:.1}"));
        facts.infer(self.column_place(column.index), format!("glucose in {unit}"), shown);
        Ok(if unit == "mmol/L" { physiology::MG_PER_DL_PER_MMOL_PER_L } else { 1.0 })
    }

    /// Adds the file's events to the logs of its people, who are named by a column or the file.
    pub(super) fn read(
        &self,
        plan: &Plan,
        clock: Clock,
        (order, order_shown): (DateOrder, &str),
        seen: &mut HashSet<u64>,
        logs: &mut BTreeMap<String, Log>,
    ) -> Result<(), CohortError> {
        let table = self.table();
        let numbers = self.numbers(plan.options.decimal)?;
        let mut facts = Account::default();
        facts.infer(Place::file(table.file()), self.opened.form.as_str(), "its first lines");
        if numbers.decimal == ',' {
            let shown = "the cells of the mapped columns";
            facts.infer(Place::file(table.file()), "numbers with a decimal comma", shown);
        }
        if !order_shown.is_empty() {
            let order = format!("dates are {}", order.name());
            facts.infer(self.column_place(self.time), order, order_shown);
        }
        let mut factors = Vec::with_capacity(self.columns.len());
        for column in &self.columns {
            factors.push(match (column.role, column.unit) {
                (Role::Glucose, _) => self.glucose_factor(column, numbers, &mut facts)?,
                (Role::Sleep, Unit::Open) => self.sleep_factor(column, numbers, &mut facts),
                (_, Unit::Times(factor)) => factor,
                (_, Unit::PerMinutes(_) | Unit::Open) => 1.0,
            });
        }
        let stamps = self.stamps(order)?;
        let instants_only = stamps.iter().flatten().all(|stamp| stamp.offset == Some(0));
        if clock.zone.is_none()
            && instants_only
            && let Some(i) = stamps.iter().position(Option::is_some)
        {
            return Err(CohortError::Undecided {
                place: self.place(i, self.time),
                reason: "times are UTC, and the record needs the person's wall clock".into(),
                remedy: "say where the person lived: --zone Europe/Madrid (or --zone UTC)",
            });
        }
        let mut times = stamps.iter().flatten().map(|stamp| stamp.written);
        let newest_first = times.next() > times.next_back();
        let mut hours: BTreeMap<String, (NaiveDateTime, bool)> = BTreeMap::new();
        let mut written: BTreeMap<String, String> = BTreeMap::new();
        for (i, stamp) in stamps.iter().enumerate() {
            let values = self.values(i, &factors, numbers)?;
            if values.is_empty() {
                continue;
            }
            let id = self.person(i, plan, &mut written)?;
            let log = logs.entry(id.clone()).or_insert_with(|| Log::new(&id, table.file()));
            for column in &self.columns {
                let place = || self.column_place(column.index);
                log.columns.entry(column.role).or_insert_with(place);
            }
            let Some(stamp) = *stamp else {
                return Err(table.cell_wrong(i, self.time, TIME_EXPECTED));
            };
            let untimed = !stamp.timed;
            let twice = !seen.insert(self.fingerprint(i, plan, &id));
            // An instant is one of several offsets: at that hour the person's clock showed UTC.
            let usual = Local { time: stamp.written, hour: Hour::Usual };
            let local = clock.local(stamp).unwrap_or(usual);
            if !(1900..2200).contains(&local.time.year()) {
                return Err(table.cell_wrong(i, self.time, "a time within the years 1900 to 2199"));
            }
            let state = hours.entry(id).or_insert((local.time, newest_first));
            let hour = settle(local, state, newest_first);
            let of_hour = match hour {
                Hour::Skipped => Some(
                    "times in the hour that the clock skipped: kept as written; the device did \
                     not follow daylight-saving time",
                ),
                Hour::Second => Some(
                    "rows in the hour that came again when the clock was set back: doses are \
                     added to those of the first hour, readings only fill its gaps",
                ),
                _ => None,
            };
            if let Some(what) = of_hour {
                log.account.note(self.place(i, self.time), what, 1);
            }
            for (role, index, value) in values {
                let place = || self.place(i, index);
                let left = if untimed {
                    Some("on a date without a time of day: left out, since the step is unknown")
                } else if twice {
                    Some("in a row that stands twice: the second one is left out")
                } else {
                    None
                };
                if let Some(why) = left {
                    log.account.note(place(), &format!("{} {why}", role.name()), 1);
                    *log.left_out.entry(role).or_default() += value;
                    continue;
                }
                let bound = role == Role::Glucose
                    && table.cell(i, index).is_some_and(|text| numbers.parse(text).is_none());
                if bound {
                    let what =
                        "'Low' and 'High', beyond the sensor's range: kept as 40 and 400 mg/dL";
                    log.account.note(place(), what, 1);
                }
                if role == Role::HeartRate && value == 0.0 {
                    log.account.note(place(), "heart rates of 0: no signal, left out", 1);
                    continue;
                }
                let second = local.time.and_utc().timestamp();
                log.events.entry(role).or_default().push(Event { second, value, hour });
            }
        }
        for (id, written) in written {
            if let Some(log) = logs.get_mut(&id) {
                log.written = written;
            }
        }
        self.tell(plan, facts, logs);
        Ok(())
    }

    /// Says what was found out about the file to its first person, and counts what it has besides.
    fn tell(&self, plan: &Plan, facts: Account, logs: &mut BTreeMap<String, Log>) {
        let table = self.table();
        let mut of_file = logs.values_mut().map(|log| &mut log.account);
        let Some(account) = of_file.find(|account| account.file == table.file()) else { return };
        account.take(facts);
        for (name, what) in plan.counted {
            let Some(at) = plan.find(name, table) else { continue };
            let rows = || (0..table.height()).filter(|i| table.cell(*i, at).is_some());
            if let Some(first) = rows().next() {
                account.note(self.place(first, at), what, rows().count());
            }
        }
        let unknown: Vec<(usize, usize)> =
            (0..table.height()).filter_map(|i| Some((i, self.unknown_kind(i)?))).collect();
        if let Some((first, at)) = unknown.first() {
            let what = "doses of a kind that is not known: left out";
            account.note(self.place(*first, *at), what, unknown.len());
        }
        for (id, log) in logs.iter_mut().filter(|(id, log)| **id != log.written) {
            let what = format!("'{}' is called {id}: names of people and files", log.written);
            log.account.note(Place::file(table.file()), &what, 1);
        }
    }

    /// The column of row `i` whose kind of event is read, but not the kind below it.
    fn unknown_kind(&self, i: usize) -> Option<usize> {
        let of_kind = |column: &&Column| match column.only.as_slice() {
            [(at, values), _, ..] => self.holds(i, *at, values),
            _ => false,
        };
        let index = self.columns.iter().find(of_kind)?.index;
        let read = self.columns.iter().any(|one| one.index == index && self.counts(one, i));
        (!read && self.table().cell(i, index).is_some()).then_some(index)
    }

    /// The stamp of each row; `None` where the cell is empty.
    fn stamps(&self, order: DateOrder) -> Result<Vec<Option<Stamp>>, CohortError> {
        (0..self.table().height())
            .map(|i| {
                let used = || {
                    let cells = self.columns.iter().filter(|column| self.counts(column, i));
                    cells.into_iter().any(|column| self.table().cell(i, column.index).is_some())
                };
                let Some(text) = self.written(i) else { return Ok(None) };
                match Stamp::parse(&text, order) {
                    Some(stamp) => Ok(Some(stamp)),
                    // Rows that hold no value may hold remarks in place of a time.
                    None if !used() => Ok(None),
                    None => Err(self.table().cell_wrong(i, self.time, TIME_EXPECTED)),
                }
            })
            .collect()
    }

    /// The values of row `i` in the record's units, each with its role and column.
    fn values(
        &self,
        i: usize,
        factors: &[f64],
        numbers: Numbers,
    ) -> Result<Vec<(Role, usize, f64)>, CohortError> {
        let mut values = Vec::new();
        for (column, factor) in self.columns.iter().zip(factors) {
            if !self.counts(column, i) {
                continue;
            }
            let mut index = column.index;
            let mut value = self.number(i, column.index, column.role, numbers)?;
            if value.is_none() {
                for part in &column.parts {
                    if let Some(amount) = self.number(i, *part, column.role, numbers)? {
                        index = *part;
                        value = Some(value.unwrap_or(0.0) + amount);
                    }
                }
            }
            let Some(value) = value else { continue };
            // A bound is in mg/dL whatever the unit of the others.
            let value = match value {
                f64::NEG_INFINITY => LOWEST,
                f64::INFINITY => HIGHEST,
                value => value * factor,
            };
            // An amount of basal is judged as a dose, its rate on the grid.
            let channel = match (column.role, column.unit) {
                (Role::Basal, Unit::PerMinutes(_)) => Some(Channel::Bolus),
                (role, _) => role.channel(),
            };
            if let Some(channel) = channel {
                check_value(channel, value, false, || self.place(i, index))?;
            }
            values.push((column.role, index, value));
        }
        Ok(values)
    }

    /// A cell as a number; a sensor's `Low` and `High` are infinite.
    fn number(
        &self,
        i: usize,
        index: usize,
        role: Role,
        numbers: Numbers,
    ) -> Result<Option<f64>, CohortError> {
        let Some(text) = self.table().cell(i, index) else { return Ok(None) };
        if let Some(value) = numbers.parse(text) {
            return Ok(Some(value));
        }
        let word = text.to_lowercase();
        let word = word.as_str();
        match role {
            _ if NOTHING.contains(&word) => Ok(None),
            Role::Glucose if LOW.contains(&word) => Ok(Some(f64::NEG_INFINITY)),
            Role::Glucose if HIGH.contains(&word) => Ok(Some(f64::INFINITY)),
            Role::SetChange if ["yes", "true", "x"].contains(&word) => Ok(Some(1.0)),
            Role::SetChange if ["no", "false"].contains(&word) => Ok(Some(0.0)),
            _ => {
                let expected =
                    "a number; write digits, and leave the cell empty where nothing is known";
                Err(self.table().cell_wrong(i, index, expected))
            }
        }
    }

    /// The factor to a share.
    fn sleep_factor(&self, column: &Column, numbers: Numbers, facts: &mut Account) -> f64 {
        let values = (0..self.table().height())
            .filter_map(|i| numbers.parse(self.table().cell(i, column.index)?))
            .filter(|value| *value > 0.0);
        let median = median(values.collect()).unwrap_or(1.0);
        let (factor, unit) = if median > 1.5 {
            (0.01, "sleep efficiency in per cent")
        } else {
            (1.0, "sleep efficiency as a share")
        };
        let shown = format!("median {median:.2} of those above 0");
        facts.infer(self.column_place(column.index), unit, shown);
        factor
    }

    /// The person of row `i`; `known` takes the name of each identifier as it is written.
    fn person(
        &self,
        i: usize,
        plan: &Plan,
        known: &mut BTreeMap<String, String>,
    ) -> Result<String, CohortError> {
        let written = match self.person {
            Some(at) => self.table().cell(i, at).ok_or_else(|| {
                self.table().cell_wrong(i, at, "a person's identifier; the cell is empty")
            })?,
            None => self.opened.stem.as_str(),
        };
        let id = with_id_letters(written);
        let id = id.trim_start_matches(['_', '-', '.']).to_owned();
        let wrong = |expected| match self.person {
            Some(at) => self.table().cell_wrong(i, at, expected),
            None => {
                let reason =
                    "the file's name becomes the person's identifier; use letters and digits";
                CohortError::layout(self.table().file(), plan.format, reason)
            }
        };
        if !is_person_id(&id) {
            return Err(wrong("a person's identifier; use letters and digits"));
        }
        if known.entry(id.clone()).or_insert_with(|| written.to_owned()) != written {
            return Err(wrong(UNIQUE_EXPECTED));
        }
        Ok(id)
    }

    /// Whose a row is and what it holds under which names, as a number.
    fn fingerprint(&self, i: usize, plan: &Plan, id: &str) -> u64 {
        let mut hasher = DefaultHasher::new();
        id.hash(&mut hasher);
        for (at, name) in self.table().header().iter().enumerate() {
            if !plan.numbering.contains(&name.as_str()) {
                name.hash(&mut hasher);
                self.table().cell(i, at).hash(&mut hasher);
            }
        }
        hasher.finish()
    }
}

/// Which of two equal hours a local time without an offset lies in: the second one from where the
/// clock went back, or, in a file that begins with its newest row, up to there. `state` is the last
/// such time and whether it was in the second hour.
fn settle(local: Local, state: &mut (NaiveDateTime, bool), newest_first: bool) -> Hour {
    if local.hour != Hour::FirstOrSecond {
        return local.hour;
    }
    let apart = local.time.signed_duration_since(state.0);
    let jump = if newest_first { apart } else { -apart };
    if jump > TimeDelta::minutes(15) && jump < TimeDelta::minutes(75) {
        state.1 = !newest_first;
    } else if apart.abs() > TimeDelta::hours(2) {
        state.1 = newest_first;
    }
    state.0 = local.time;
    if state.1 { Hour::Second } else { Hour::First }
}
