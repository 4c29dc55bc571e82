//! Tables of ReplayBG (github.com/gcappon/replay-bg, DIANA-UNIPD/replaybg): one CSV a person.
//!
//! `t` is a local time on the five-minute grid, `glucose` is in mg/dL, `cho` in g/min, `bolus` and
//! `basal` in U/min, each a mean over the five minutes from `t`. Labels of meals and boluses and
//! `exercise` are not part of the record.

use std::path::{Path, PathBuf};

use chrono::NaiveDateTime;

use super::diary::{Diary, Rate, people, second};
use super::files::{files, identifier};
use crate::error::CohortError;
use crate::record::{Channel, follows};
use crate::text_table::{TextColumn, TextTable};
use crate::wall_clock::parse_iso_start;

const FORMAT: &str = "replaybg";
/// Seconds and minutes of a step.
const SECONDS: i64 = 300;
const MINUTES: f64 = 5.0;

/// Reads a file or the folder's `*.csv`.
pub(super) fn import(source: &Path) -> Result<super::Import, CohortError> {
    let files = files(source, FORMAT, "*.csv", |name| name.ends_with(".csv"))?;
    let read = |(path, name): &(PathBuf, String)| person(&TextTable::read(path, name, b',')?);
    let diaries: Result<Vec<Diary>, _> = files.iter().map(read).collect();
    people(FORMAT, source, diaries?)
}

fn person(table: &TextTable) -> Result<Diary, CohortError> {
    let id = table.file().strip_suffix(".csv").unwrap_or(table.file());
    identifier(id, table.file(), FORMAT, "the file's name", "rename it")?;
    let mut diary = Diary::new(id, table.file());
    let (times, glucose) = (table.column("t")?, table.column("glucose")?);
    let (carbs, bolus, basal) =
        (table.column("cho")?, table.column("bolus")?, table.column("basal")?);
    let mut previous = None;
    for i in 0..table.height() {
        let time = time(&times, i)?;
        follows(time, previous, id, || times.place(i))?;
        previous = Some(time);
        let at = second(time);
        if let Some(value) = number(&glucose, i)? {
            diary.reading(at, value, || glucose.place(i))?;
        }
        for (channel, column) in [(Channel::Carbs, &carbs), (Channel::Bolus, &bolus)] {
            if let Some(rate) = number(column, i)? {
                diary.dose(channel, at, 0, rate * MINUTES, || column.place(i))?;
            }
        }
        if let Some(u_min) = number(&basal, i)? {
            let rate = Rate { from: at, to: Some(at + SECONDS), u_h: u_min * 60.0 };
            diary.rate(rate, || basal.place(i))?;
        }
    }
    Ok(diary)
}

/// A number; MATLAB and pandas write `NaN` for a missing one.
fn number(column: &TextColumn<'_>, i: usize) -> Result<Option<f64>, CohortError> {
    match column.text(i) {
        Some(text) if text.eq_ignore_ascii_case("nan") => Ok(None),
        _ => column.number(i),
    }
}

/// `01-Mar-2024 08:05:00` (MATLAB) or `2024-03-01 08:05:00`.
fn time(times: &TextColumn<'_>, i: usize) -> Result<NaiveDateTime, CohortError> {
    let text = times.text(i).unwrap_or("");
    parse_iso_start(text)
        .or_else(|| NaiveDateTime::parse_from_str(text, "%d-%b-%Y %H:%M:%S").ok())
        .ok_or_else(|| times.wrong(i, "a time like 01-Mar-2024 08:05:00 or 2024-03-01 08:05:00"))
}
