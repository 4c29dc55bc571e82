//! The example day of T1DSim_AI (github.com/mosqueralopez/T1DSim_AI), `example_subject*.csv`.
//!
//! Rows are five minutes apart and have the hour of the day and a weekend flag, but no date. The
//! importer chooses a date that agrees with both: the first week of 2024, Monday for working days.
//! The insulin rate (U/h) includes boluses and stays one rate. Heart rate is relative to the
//! baseline, so the person's baseline is 0.

use std::path::Path;

use chrono::{Datelike as _, NaiveDate, NaiveDateTime, TimeDelta, Timelike as _, Weekday};
use physiology::{BeatsPerMinute, STEPS_PER_HOUR};

use super::files::{LETTERS, files, identifier};
use super::report::{Account, Imported, assemble};
use crate::error::{CohortError, Place};
use crate::person::{Person, Therapy};
use crate::range::{check_unit, check_value};
use crate::record::{Channel, Record};
use crate::text_table::{TextColumn, TextTable};

const FORMAT: &str = "t1dsim";
const HOUR: &str = "hour_of_day";
const WEEKEND: &str = "feat_is_weekend";
/// Columns that are kept as they are.
const COLUMNS: [(&str, Channel); 5] = [
    ("cgm", Channel::Cgm),
    ("input_insulin_ODEPop", Channel::Basal),
    ("input_meal_carbs_ODEPop", Channel::Carbs),
    ("heart_rate_WRTbaseline", Channel::HeartRate),
    ("sleep_efficiency", Channel::SleepEfficiency),
];

/// Reads a file or the folder's `example_subject*.csv`.
pub(super) fn import(source: &Path) -> Result<super::Import, CohortError> {
    let files = files(source, FORMAT, "example_subject*.csv", |name| {
        name.starts_with("example_subject") && name.ends_with(".csv")
    })?;
    let people = files.iter().map(|(path, name)| person(&TextTable::read(path, name, b',')?));
    assemble(FORMAT, source.display(), "the rows of the file / 288", people)
}

fn person(table: &TextTable) -> Result<Imported, CohortError> {
    let file = table.file();
    let id = file.strip_suffix(".csv").unwrap_or(file);
    identifier(id, file, FORMAT, "the file's name", LETTERS)?;
    let start = start(table)?;
    let mut record = Record::new(start, table.height())?;
    let mut account = Account::new(id, file);
    for (name, channel) in COLUMNS {
        let column = table.column(name)?;
        let mut source = 0.0;
        for i in 0..table.height() {
            let Some(value) = column.number(i)? else { continue };
            check_value(channel, value, true, || column.place(i))?;
            record.channel_mut(channel)[i] = Some(value);
            source += value;
        }
        let (unit, per_unit) = match channel {
            Channel::Basal => ("U", STEPS_PER_HOUR as f64),
            Channel::Carbs => ("g", 1.0),
            _ => continue,
        };
        let kept = record.channel(channel).iter().flatten().sum::<f64>() / per_unit;
        account.total(channel, unit, source / per_unit, kept, 0.0);
    }
    check_unit(record.cgm(), id, || Place::column(file, COLUMNS[0].0))?;
    // Zero, not missing, where the rate is recorded: the rate already includes the boluses.
    let recorded: Vec<bool> = record.basal().iter().map(Option::is_some).collect();
    for (bolus, recorded) in record.channel_mut(Channel::Bolus).iter_mut().zip(recorded) {
        *bolus = recorded.then_some(0.0);
    }
    let what = "the rate includes boluses: kept as basal_u_h, bolus_u is 0";
    account.note(Place::column(file, "input_insulin_ODEPop"), what, 1);
    account.note(Place::file(file), "no step counts, set changes, weight or therapy", 1);
    let evidence = "the file has no date; hour and weekend flag of every row agree with this one";
    account.infer(Place::column(file, HOUR), format!("the first row is {start}"), evidence);
    let person = Person {
        id: id.into(),
        weight: None,
        therapy: Therapy::Unknown,
        heart_rate_baseline: Some(BeatsPerMinute(0.0)),
        record,
    };
    Ok(Imported { person: Some(person), account })
}

/// The first start in the week from Monday 2024-01-01 that agrees with every row's hour and
/// weekend flag.
fn start(table: &TextTable) -> Result<NaiveDateTime, CohortError> {
    let (hours, weekends) = (table.column(HOUR)?, table.column(WEEKEND)?);
    let whole = |column: &TextColumn<'_>, i: usize, high: u32, expected| {
        let value = column.required_number(i)?;
        (0..=high).find(|n| f64::from(*n) == value).ok_or_else(|| column.wrong(i, expected))
    };
    let mut rows = Vec::with_capacity(table.height());
    for i in 0..table.height() {
        let hour = whole(&hours, i, 23, "an hour from 0 to 23")?;
        rows.push((hour, whole(&weekends, i, 1, "0 or 1")? == 1));
    }
    let first_hour = rows.first().map_or(0, |row| row.0);
    // Rows before the hour first changes give the minute; without a change the hour begins.
    let before_change = rows.iter().position(|row| row.0 != first_hour).unwrap_or(STEPS_PER_HOUR);
    let minute = 60_u32.saturating_sub(5 * u32::try_from(before_change).unwrap_or(12)) % 60;

    let mut furthest = (0, HOUR);
    for day in 1..=7 {
        let start = NaiveDate::from_ymd_opt(2024, 1, day)
            .and_then(|date| date.and_hms_opt(first_hour, minute, 0))
            .expect("hour and minute are in range");
        let disagrees = |(i, (hour, weekend)): (usize, &(u32, bool))| {
            let time = start + TimeDelta::minutes(5 * i as i64);
            if time.hour() != *hour {
                return Some((i, HOUR));
            }
            let is_weekend = matches!(time.weekday(), Weekday::Sat | Weekday::Sun);
            (is_weekend != *weekend).then_some((i, WEEKEND))
        };
        let first = rows.iter().enumerate().find_map(disagrees);
        let Some(first) = first else { return Ok(start) };
        furthest = furthest.max(first);
    }
    let (row, column) = furthest;
    let expected =
        "what the rows above lead to; rows must be 5 minutes apart, without gaps, in order";
    Err(table.column(column)?.wrong(row, expected))
}

#[cfg(test)]
mod tests {
    use contract::import_report::Totals;

    use super::*;

    const HEADER: &str = "hour_of_day,cgm,sleep_efficiency,heart_rate_WRTbaseline,\
                          feat_is_weekend,input_insulin_ODEPop,input_meal_carbs_ODEPop\n";

    fn read(rows: &str) -> Result<Imported, CohortError> {
        let text = format!("{HEADER}{rows}");
        person(&TextTable::parse(text.into_bytes(), "example_subject1.csv", b',')?)
    }

    #[test]
    fn clock_weekend_and_values_are_kept() {
        let imported = read(
            "22,128,0.970000029,-15.05045189,1,0.948,0\n\
             23,126,1,-15.6,1,4.0920000000000005,30\n\
             23,125,,,1,0.816,0\n",
        )
        .and_then(|person| assemble(FORMAT, "", "", [Ok(person)]))
        .expect("a good file");
        let (person, account) = (&imported.cohort.people[0], &imported.report.people[0]);
        assert_eq!(person.record.start().to_string(), "2024-01-06 22:55:00");
        let inputs = person.inputs(0..3, crate::MissingDoses::Error).expect("complete");
        let context: Vec<_> =
            inputs.iter().map(|input| (input.context.hour, input.context.weekend)).collect();
        assert_eq!(context, [(22, true), (23, true), (23, true)]);
        assert_eq!(inputs[0].context.heart_rate_over_baseline, Some(BeatsPerMinute(-15.05045189)));
        assert_eq!(inputs[0].context.sleep_efficiency, Some(0.970000029));
        assert_eq!(inputs[1].insulin().0, 4.0920000000000005);
        assert_eq!(person.record.heart_rate()[2], None);
        assert!(account.totals.iter().flatten().all(Totals::closes));
    }

    #[test]
    fn rows_that_do_not_follow_are_errors() {
        for (rows, says) in [
            ("0,128,1,0,0,1,0\n2,128,1,0,0,1,0\n", "row 3, column hour_of_day: '2' is not what"),
            ("0,128,1,0,0,1,0\n0,128,1,0,1,1,0\n", "row 3, column feat_is_weekend: '1' is not"),
            ("24,128,1,0,0,1,0\n", "'24' is not an hour from 0 to 23"),
            ("0,7.1,1,0,0,1,0\n", "looks like mmol/L; multiply by 18 or import"),
            ("0,128,1,0,0,-1,0\n", "row 2, column input_insulin_ODEPop: -1 is outside"),
            ("0,128,1,x,0,1,0\n", "column heart_rate_WRTbaseline: 'x' is not a number"),
        ] {
            let message = read(rows).err().expect("refused").to_string();
            assert!(message.contains(says), "{message}");
        }
    }
}
