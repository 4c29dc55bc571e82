//! `HUPA*.csv` of the HUPA-UCM study (doi:10.17632/3hbcscwz44.1).
//!
//! One file per person, `;`-separated, on a five-minute grid whose gaps the authors filled: glucose
//! and heart rate linearly, doses with 0. Basal insulin is U per 5 minutes. By person, carbohydrate
//! is in servings of 10 g or in grams, and some doses are 0/1 flags (see `hupa_units`). Values that
//! were drawn are kept and counted; amounts that are flags become missing.

use std::path::Path;

use chrono::{Datelike as _, NaiveDateTime};
use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

use super::files::{files, identifier};
use super::hupa_units::{Meaning, basal_unit, bolus_unit, carb_unit};
use super::report::{Account, Imported, assemble};
use crate::error::{CohortError, Place};
use crate::person::{Person, Therapy};
use crate::range::{check_unit, check_value};
use crate::record::{Channel, Record, check_span, follows};
use crate::straight_lines::StraightLines;
use crate::text_table::TextTable;
use crate::wall_clock::parse_iso;

const FORMAT: &str = "hupa-ucm";
const TIME: &str = "time";
const GLUCOSE: &str = "glucose";
const HEART_RATE: &str = "heart_rate";
const STEPS: &str = "steps";
const BASAL: &str = "basal_rate";
const BOLUS: &str = "bolus_volume_delivered";
const CARBS: &str = "carb_input";
/// The lowest value the sensor reports, mg/dL.
const FLOOR: f64 = 40.0;
/// Inner steps of a straight line that is longer than the sensor's 15 minutes: half an hour or more
/// between readings.
const LONG_LINE: usize = 5;
/// Share of a day's steps whose basal repeats the day before in a programmed profile.
const PROFILE_SHARE: f64 = 0.5;

/// Reads a file or the folder's `HUPA*.csv`.
pub(super) fn import(source: &Path) -> Result<super::Import, CohortError> {
    let files = files(source, FORMAT, "HUPA*.csv", |name| {
        name.starts_with("HUPA") && name.ends_with(".csv")
    })?;
    let people = files.iter().map(|(path, name)| person(&TextTable::read(path, name, b';')?));
    let days_are = "the span from the file's first to its last row";
    assemble(FORMAT, source.display(), days_are, people)
}

fn person(table: &TextTable) -> Result<Imported, CohortError> {
    let file = table.file();
    let id = file.strip_suffix(".csv").unwrap_or(file);
    identifier(id, file, FORMAT, "the file's name", "rename it")?;
    let (start, steps) = grid(table, id)?;
    let len = steps.last().map_or(0, |last| last + 1);
    let (record, account) = (Record::new(start, len)?, Account::new(id, file));
    let mut reader = Reader { table, steps: &steps, record, account };
    reader.glucose()?;
    reader.heart_rate()?;
    let walked = reader.column(STEPS, Channel::Steps)?;
    reader.keep(Channel::Steps, &walked, 1.0);
    let therapy = reader.basal()?;
    reader.bolus_and_carbs()?;
    reader.note(TIME, "steps without a row: missing", len - steps.len());
    let Reader { record, mut account, .. } = reader;
    account.note(Place::file(file), "no sleep, set changes or weight; calories are not used", 1);
    let person = Person { id: id.into(), weight: None, therapy, heart_rate_baseline: None, record };
    Ok(Imported { person: Some(person), account })
}

/// The start of the grid of the rows, and the step of each row.
fn grid(table: &TextTable, person: &str) -> Result<(NaiveDateTime, Vec<usize>), CohortError> {
    let times = table.column(TIME)?;
    let expected =
        "a local time like 2024-03-01T08:05:00 without a zone, in the years 1900 to 2199";
    let time = |i: usize| {
        times
            .text(i)
            .and_then(parse_iso)
            .filter(|time| (1900..2200).contains(&time.year()))
            .ok_or_else(|| times.wrong(i, expected))
    };
    let start = time(0)?;
    let mut at: Vec<usize> = Vec::with_capacity(table.height());
    let mut previous = None;
    for i in 0..table.height() {
        let time = time(i)?;
        follows(time, previous, person, || times.place(i))?;
        previous = Some(time);
        let elapsed = time.signed_duration_since(start);
        check_span(elapsed.num_days(), table.height(), person, || times.place(i))?;
        at.push(usize::try_from(elapsed.num_minutes() / 5).expect("times ascend"));
    }
    Ok((start, at))
}

/// Fills one person's record from the columns.
struct Reader<'a> {
    table: &'a TextTable,
    steps: &'a [usize],
    record: Record,
    account: Account,
}

impl Reader<'_> {
    /// A column's numbers in the source's unit, one per row, each checked for `channel`.
    fn column(&self, name: &str, channel: Channel) -> Result<Vec<Option<f64>>, CohortError> {
        let column = self.table.column(name)?;
        (0..self.table.height())
            .map(|i| {
                let value = column.number(i)?;
                if let Some(value) = value {
                    check_value(channel, value, false, || column.place(i))?;
                }
                Ok(value)
            })
            .collect()
    }

    /// Puts values, times `factor`, on the grid.
    fn keep(&mut self, channel: Channel, values: &[Option<f64>], factor: f64) {
        let cells = self.record.channel_mut(channel);
        for (&k, value) in self.steps.iter().zip(values) {
            cells[k] = value.map(|value| value * factor);
        }
    }

    /// A column of the file, for messages.
    fn place(&self, column: &str) -> Place {
        Place::column(self.table.file(), column)
    }

    fn note(&mut self, column: &str, what: &str, count: usize) {
        self.account.note(self.place(column), what, count);
    }

    fn glucose(&mut self) -> Result<(), CohortError> {
        let values = self.column(GLUCOSE, Channel::Cgm)?;
        check_unit(&values, &self.account.id, || self.place(GLUCOSE))?;
        self.keep(Channel::Cgm, &values, 1.0);
        let at_floor = values.iter().flatten().filter(|value| **value == FLOOR).count();
        self.note(GLUCOSE, "readings of exactly 40 mg/dL: the sensor's floor, kept", at_floor);
        let lines = self.lines(GLUCOSE, Channel::Cgm);
        // The commonest line between readings shows their interval.
        let mut counts = std::collections::BTreeMap::new();
        for line in &lines.inside {
            *counts.entry(line.len() + 1).or_insert(0_usize) += 1;
        }
        if let Some((steps, count)) = counts.into_iter().max_by_key(|(_, count)| *count) {
            let interval = 5 * steps;
            self.account.infer(
                self.place(GLUCOSE),
                format!("a reading every {interval} min, lines drawn between them"),
                format!("{count} of {} straight lines are that long", lines.inside.len()),
            );
        }
        Ok(())
    }

    fn heart_rate(&mut self) -> Result<(), CohortError> {
        let mut values = self.column(HEART_RATE, Channel::HeartRate)?;
        let mut zeros = 0;
        for value in values.iter_mut().filter(|value| **value == Some(0.0)) {
            *value = None;
            zeros += 1;
        }
        self.note(HEART_RATE, "heart rates of 0: no signal, set to missing", zeros);
        self.keep(Channel::HeartRate, &values, 1.0);
        self.lines(HEART_RATE, Channel::HeartRate);
        Ok(())
    }

    /// Counts what was drawn between readings.
    fn lines(&mut self, column: &str, channel: Channel) -> StraightLines {
        let lines = StraightLines::find(self.record.channel(channel));
        let drawn = lines.values_in_lines_of(0);
        let share = 100.0 * lines.share;
        let what = format!("values on straight lines between others ({share:.0} %), kept");
        self.note(column, &what, drawn);
        let long = lines.values_in_lines_of(LONG_LINE);
        let what = "of these in lines of half an hour or more: filled gaps, kept";
        self.note(column, what, long);
        lines
    }

    fn basal(&mut self) -> Result<Therapy, CohortError> {
        let values = self.column(BASAL, Channel::Basal)?;
        let (factor, conclusion, evidence) = basal_unit(&values);
        self.account.infer(self.place(BASAL), conclusion, evidence);
        // A rate that no column holds may be among amounts that decide the unit.
        let column = self.table.column(BASAL)?;
        for (i, value) in values.iter().enumerate() {
            let Some(value) = value else { continue };
            check_value(Channel::Basal, value * factor, false, || column.place(i))?;
        }
        self.keep(Channel::Basal, &values, factor);
        let steps_per_hour = STEPS_PER_HOUR as f64;
        // U in the source per unit of the column.
        let units = factor / steps_per_hour;
        let source = values.iter().flatten().sum::<f64>() * units;
        let kept = self.record.basal().iter().flatten().sum::<f64>() / steps_per_hour;
        self.account.total(Channel::Basal, "U", source, kept, 0.0);
        let (therapy, conclusion, evidence) = therapy(self.record.basal());
        self.account.infer(self.place(BASAL), conclusion, evidence);
        Ok(therapy)
    }

    fn bolus_and_carbs(&mut self) -> Result<(), CohortError> {
        let bolus = self.column(BOLUS, Channel::Bolus)?;
        let carbs = self.column(CARBS, Channel::Carbs)?;
        let of_bolus = bolus_unit(&bolus);
        let of_carbs = carb_unit(&carbs, of_bolus.0.is_some().then_some(bolus.as_slice()));
        self.doses(BOLUS, Channel::Bolus, "U", &bolus, of_bolus);
        self.doses(CARBS, Channel::Carbs, "g", &carbs, of_carbs);
        Ok(())
    }

    /// Keeps a dose column whole or, without a factor, leaves it out whole.
    fn doses(
        &mut self,
        column: &str,
        channel: Channel,
        unit: &str,
        values: &[Option<f64>],
        (factor, conclusion, evidence): Meaning,
    ) {
        self.account.infer(self.place(column), conclusion, evidence);
        let source = values.iter().flatten().sum::<f64>();
        if let Some(factor) = factor {
            self.keep(channel, values, factor);
            let kept = self.record.channel(channel).iter().flatten().sum();
            self.account.total(channel, unit, source * factor, kept, 0.0);
        } else {
            let flags = values.iter().flatten().filter(|value| **value > 0.0).count();
            self.note(column, "entries without an amount: left out", flags);
            self.account.total(channel, "entries", source, 0.0, source);
        }
    }
}

/// Whether the basal rate is a profile that repeats from day to day.
fn therapy(basal: &[Option<f64>]) -> (Therapy, &'static str, String) {
    let pairs: Vec<(f64, f64)> = basal
        .iter()
        .zip(basal.iter().skip(STEPS_PER_DAY))
        .filter_map(|(today, tomorrow)| today.zip(*tomorrow))
        .collect();
    // Relative rounding of the file's sixteen digits.
    let equal = pairs.iter().filter(|(a, b)| (a - b).abs() <= 1e-9 * a.abs()).count();
    let share = if pairs.is_empty() { 0.0 } else { equal as f64 / pairs.len() as f64 };
    let evidence = format!("{:.0} % of steps repeat the rate of the day before", 100.0 * share);
    if share >= PROFILE_SHARE {
        (Therapy::OpenLoopPump, "therapy open_loop_pump: a programmed profile", evidence)
    } else {
        (Therapy::Unknown, "therapy unknown: no repeating profile", evidence)
    }
}

#[cfg(test)]
mod tests {
    use contract::import_report::Totals;

    use super::*;

    const HEADER: &str = "time;glucose;calories;heart_rate;steps;basal_rate;\
                          bolus_volume_delivered;carb_input\n";

    fn read(rows: &str) -> Result<Imported, CohortError> {
        let text = format!("{HEADER}{rows}");
        person(&TextTable::parse(text.into_bytes(), "HUPA1234P.csv", b';')?)
    }

    #[test]
    fn units_are_converted_and_a_gap_is_missing() {
        let imported = read(
            "2018-06-13T22:45:00;86.0;6.2;65.4;0.0;0.05;6.0;5.0\n\
             2018-06-13T22:55:00;40.0;6.2;0.0;12.0;0.075;0.0;0.5\n",
        )
        .and_then(|person| assemble(FORMAT, "", "", [Ok(person)]))
        .expect("a good file");
        let (person, account) = (&imported.cohort.people[0], &imported.report.people[0]);
        let record = &person.record;
        assert_eq!(person.id, "HUPA1234P");
        assert_eq!(record.len(), 3);
        assert_eq!(record.cgm(), &[Some(86.0), None, Some(40.0)]);
        // 12 x 0.05 and 12 x 0.075 in f64.
        assert_eq!(record.basal(), &[Some(0.05 * 12.0), None, Some(0.075 * 12.0)]);
        assert_eq!(record.bolus(), &[Some(6.0), None, Some(0.0)]);
        assert_eq!(record.carbs(), &[Some(50.0), None, Some(5.0)]);
        assert_eq!(record.heart_rate(), &[Some(65.4), None, None]);
        let mut totals = account.totals.iter().flatten();
        assert!(totals.all(Totals::closes), "{:?}", account.totals);
    }

    #[test]
    fn broken_rows_are_errors_with_their_place() {
        for (rows, says) in [
            ("2018-06-13 22:45:00;86;6;65;0;0.1;0;0\n", "row 2, column time: '2018-06-13 22:45"),
            ("2018-06-13T22:46:00;86;6;65;0;0.1;0;0\n", "off the 5-minute grid"),
            ("1024-06-13T22:45:00;86;6;65;0;0.1;0;0\n", "row 2, column time: '1024-06-13T22:45"),
            ("2018-06-13T22:45:00;5.1;6;65;0;0.1;0;0\n", "column glucose: person 'HUPA1234P' has"),
            ("2018-06-13T22:45:00;86;6;65;0;-0.1;0;0\n", "column basal_rate: -0.1 is outside"),
            ("2018-06-13T22:45:00;86;6;65;0;0.1;0\n", "row 2: 7 fields where the header has 8"),
        ] {
            let message = read(rows).err().expect("refused").to_string();
            assert!(message.contains(says), "{message}");
        }
        let repeated = "2018-06-13T22:45:00;86;6;65;0;0.1;0;0\n".repeat(2);
        let message = read(&repeated).err().expect("refused").to_string();
        assert!(
            message.contains("row 3, column time: person 'HUPA1234P' has two rows"),
            "{message}"
        );
    }

    #[test]
    fn a_rate_that_no_column_holds_is_refused_where_it_stands() {
        let start = parse_iso("2018-06-13T00:00:00").expect("a literal time");
        let mut rows = String::new();
        for i in 0..1001 {
            let time = start + chrono::TimeDelta::minutes(5 * i);
            // The mean is 43 U a day as amounts of five minutes, in which 101 U are 1212 U/h.
            let basal = if i == 10 { "101" } else { "0.05" };
            rows += &format!("{};86;6;65;0;{basal};0;0\n", time.format("%Y-%m-%dT%H:%M:%S"));
        }
        let message = read(&rows).err().expect("refused").to_string();
        let says = "HUPA1234P.csv, row 12, column basal_rate: 1212 is outside 0 to 1200 U/h";
        assert!(message.contains(says), "{message}");
    }
}
