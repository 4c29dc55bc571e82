//! `HUPA*.csv` of the HUPA-UCM study (doi:10.17632/3hbcscwz44.1).
//!
//! One file per person, `;`-separated, on a five-minute grid whose gaps the authors filled: glucose
//! and heart rate linearly, doses with 0. Basal insulin is U per 5 minutes. By person, carbohydrate
//! is in servings of 10 g or in grams, and some doses are 0/1 flags (see `hupa_units`). Values that
//! were drawn are kept and counted; amounts that are flags become missing.

use std::path::Path;

use chrono::Datelike as _;
use contract::import_report::{Inference, Totals};
use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};
use rayon::prelude::*;

use super::files::{files, identifier};
use super::hupa_units::{
    BasalUnit, BolusUnit, CarbUnit, GRAMS_PER_SERVING, basal_unit, bolus_unit, carb_unit,
};
use super::report::{Imported, Notes, assemble, inference, totals_of};
use crate::error::{CohortError, Place};
use crate::person::{Person, Therapy};
use crate::range::{check_value, looks_like_mmol};
use crate::record::{Channel, Record, follows, longest};
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
    // Collected before the first error is taken, so the error is that of the first file for any
    // number of threads.
    let people: Vec<_> =
        files.par_iter().map(|(path, name)| person(&TextTable::read(path, name, b';')?)).collect();
    assemble(FORMAT, "the span from the file's first to its last row", people)
}

fn person(table: &TextTable) -> Result<Imported, CohortError> {
    let file = table.file();
    let id = file.strip_suffix(".csv").unwrap_or(file).to_owned();
    identifier(&id, file, FORMAT, "the file's name", "rename it")?;
    let steps = grid(table, &id)?;
    let mut reader = Reader {
        table,
        id: &id,
        steps: &steps.at,
        record: Record::new(steps.start, steps.len)?,
        notes: Notes::default(),
        inferences: Vec::new(),
        totals: Vec::new(),
    };
    reader.glucose()?;
    reader.heart_rate()?;
    let walked = reader.column(STEPS, Channel::Steps)?;
    reader.keep(Channel::Steps, &walked, 1.0);
    let therapy = reader.basal()?;
    reader.bolus_and_carbs()?;
    let Reader { record, mut notes, inferences, totals, .. } = reader;
    let absent = steps.len - steps.at.len();
    notes.add_many(&id, Place::column(file, TIME), "steps without a row: missing", absent);
    notes.add(&id, Place::file(file), "no sleep, set changes or weight; calories are not used");
    let person = Person { id, weight: None, therapy, heart_rate_baseline: None, record };
    Ok(Imported { person, file: file.into(), totals, inferences, notes })
}

/// The grid of the rows.
struct Grid {
    start: chrono::NaiveDateTime,
    len: usize,
    /// The step of each row.
    at: Vec<usize>,
}

fn grid(table: &TextTable, person: &str) -> Result<Grid, CohortError> {
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
        let (days, limit) = (elapsed.num_days(), longest(table.height()));
        if days >= limit {
            let (place, person) = (times.place(i), person.into());
            return Err(CohortError::TooLong { place, person, days, limit });
        }
        at.push(usize::try_from(elapsed.num_minutes() / 5).expect("times ascend"));
    }
    let len = at.last().map_or(0, |last| last + 1);
    Ok(Grid { start, len, at })
}

/// Fills one person's record from the columns.
struct Reader<'a> {
    table: &'a TextTable,
    id: &'a str,
    steps: &'a [usize],
    record: Record,
    notes: Notes,
    inferences: Vec<Inference>,
    totals: Vec<Totals>,
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

    fn infer(&mut self, column: &str, conclusion: &str, evidence: String) {
        let place = Place::column(self.table.file(), column);
        self.inferences.push(inference(self.id, place, conclusion, evidence));
    }

    fn note(&mut self, column: &str, what: &str, count: usize) {
        self.notes.add_many(self.id, Place::column(self.table.file(), column), what, count);
    }

    fn glucose(&mut self) -> Result<(), CohortError> {
        let values = self.column(GLUCOSE, Channel::Cgm)?;
        if let Some(median) = looks_like_mmol(&values) {
            return Err(CohortError::LooksLikeMmol {
                place: Place::column(self.table.file(), GLUCOSE),
                person: self.id.into(),
                median,
            });
        }
        self.keep(Channel::Cgm, &values, 1.0);
        let at_floor = values.iter().flatten().filter(|value| **value == FLOOR).count();
        self.note(GLUCOSE, "readings of exactly 40 mg/dL: the sensor's floor, kept", at_floor);
        self.lines(GLUCOSE, Channel::Cgm);
        self.reading_interval();
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
    fn lines(&mut self, column: &str, channel: Channel) {
        let lines = StraightLines::find(self.record.channel(channel));
        let drawn = lines.values_in_lines_of(0);
        let share = 100.0 * lines.share;
        let what = format!("values on straight lines between others ({share:.0} %), kept");
        self.note(column, &what, drawn);
        let long = lines.values_in_lines_of(LONG_LINE);
        let what = "of these in lines of half an hour or more: filled gaps, kept";
        self.note(column, what, long);
    }

    /// Infers the interval of the sensor's own readings from the commonest line between them.
    fn reading_interval(&mut self) {
        let lines = StraightLines::find(self.record.cgm());
        let mut counts = std::collections::BTreeMap::new();
        for line in &lines.inside {
            *counts.entry(line.len() + 1).or_insert(0_usize) += 1;
        }
        let Some((steps, count)) = counts.into_iter().max_by_key(|(_, count)| *count) else {
            return;
        };
        let all = lines.inside.len();
        self.infer(
            GLUCOSE,
            &format!("a reading every {} min, lines drawn between them", 5 * steps),
            format!("{count} of {all} straight lines are that long"),
        );
    }

    fn basal(&mut self) -> Result<Therapy, CohortError> {
        let values = self.column(BASAL, Channel::Basal)?;
        let (unit, evidence) = basal_unit(&values);
        // U in the source per unit of the column, and U/h per unit of the column.
        let (conclusion, units, rate) = match unit {
            BasalUnit::UnitsPerFiveMinutes => ("U per 5 min; x 12 U/h", 1.0, 12.0),
            BasalUnit::UnitsPerHour => ("U/h", 1.0 / STEPS_PER_HOUR as f64, 1.0),
        };
        self.infer(BASAL, conclusion, evidence);
        self.check_rates(&values, rate)?;
        self.keep(Channel::Basal, &values, rate);
        let source = values.iter().flatten().sum::<f64>() * units;
        let kept = self.record.basal().iter().flatten().sum::<f64>() / STEPS_PER_HOUR as f64;
        self.totals.push(totals_of(Channel::Basal, "U", source, kept, 0.0));
        let (therapy, conclusion, evidence) = therapy(self.record.basal());
        self.infer(BASAL, conclusion, evidence);
        Ok(therapy)
    }

    /// Refuses a rate, U/h, that no column holds; one may be among amounts that decide the unit.
    fn check_rates(&self, values: &[Option<f64>], factor: f64) -> Result<(), CohortError> {
        let column = self.table.column(BASAL)?;
        for (i, value) in values.iter().enumerate() {
            let Some(value) = value else { continue };
            check_value(Channel::Basal, value * factor, false, || column.place(i))?;
        }
        Ok(())
    }

    fn bolus_and_carbs(&mut self) -> Result<(), CohortError> {
        let bolus = self.column(BOLUS, Channel::Bolus)?;
        let carbs = self.column(CARBS, Channel::Carbs)?;

        let (unit, evidence) = bolus_unit(&bolus);
        let conclusion = match unit {
            BolusUnit::Units => "U",
            BolusUnit::Flag => "a flag without an amount: bolus_u is missing",
            BolusUnit::Nothing => "no bolus was recorded: bolus_u is missing",
        };
        self.infer(BOLUS, conclusion, evidence);
        let amounts = unit == BolusUnit::Units;
        if amounts {
            self.keep(Channel::Bolus, &bolus, 1.0);
        }
        self.account(BOLUS, Channel::Bolus, "U", &bolus, amounts.then_some(1.0));

        let (unit, evidence) = carb_unit(&carbs, amounts.then_some(bolus.as_slice()));
        let (conclusion, factor) = match unit {
            CarbUnit::Grams => ("g", Some(1.0)),
            CarbUnit::Servings => ("servings of 10 g; x 10 g", Some(GRAMS_PER_SERVING)),
            CarbUnit::Flag => ("a flag without an amount: carbs_g is missing", None),
            CarbUnit::Nothing => ("nothing was logged: carbs_g is missing", None),
        };
        self.infer(CARBS, conclusion, evidence);
        if let Some(factor) = factor {
            self.keep(Channel::Carbs, &carbs, factor);
        }
        self.account(CARBS, Channel::Carbs, "g", &carbs, factor);
        Ok(())
    }

    /// Closes the sum of a dose column. The column is kept whole or, without a factor, left out
    /// whole.
    fn account(
        &mut self,
        column: &str,
        channel: Channel,
        unit: &str,
        values: &[Option<f64>],
        factor: Option<f64>,
    ) {
        let source = values.iter().flatten().sum::<f64>();
        match factor {
            Some(factor) => {
                let kept = self.record.channel(channel).iter().flatten().sum();
                self.totals.push(totals_of(channel, unit, source * factor, kept, 0.0));
            }
            None => {
                let flags = values.iter().flatten().filter(|value| **value > 0.0).count();
                self.note(column, "entries without an amount: left out", flags);
                self.totals.push(totals_of(channel, "entries", source, 0.0, source));
            }
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
        .expect("a good file");
        let record = &imported.person.record;
        assert_eq!(imported.person.id, "HUPA1234P");
        assert_eq!(record.len(), 3);
        assert_eq!(record.cgm(), &[Some(86.0), None, Some(40.0)]);
        // 12 x 0.05 and 12 x 0.075 in f64.
        assert_eq!(record.basal(), &[Some(0.05 * 12.0), None, Some(0.075 * 12.0)]);
        assert_eq!(record.bolus(), &[Some(6.0), None, Some(0.0)]);
        assert_eq!(record.carbs(), &[Some(50.0), None, Some(5.0)]);
        assert_eq!(record.heart_rate(), &[Some(65.4), None, None]);
        assert!(imported.totals.iter().all(Totals::closes), "{:?}", imported.totals);
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
