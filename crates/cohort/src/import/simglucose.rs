//! Results of simglucose (github.com/jxx123/simglucose): one CSV a patient, named `adult#001.csv`.
//!
//! `CHO` (g/min) and `insulin` (U/min) are means from a row's `Time` to the next one. Insulin
//! includes boluses and stays one rate. The reading is `CGM`; `BG` is not measured and not used.

use std::path::{Path, PathBuf};

use super::diary::{Diary, Rate, people, second};
use super::files::{files, identifier};
use crate::error::CohortError;
use crate::record::Channel;
use crate::text_table::{TextColumn, TextTable};
use crate::wall_clock::parse_iso_start;

const FORMAT: &str = "simglucose";
/// Longest time from row to row, s.
const LONGEST_SAMPLE: i64 = 3600;

/// Tables of a results folder that are not a patient's.
const SUMMARIES: [&str; 3] = ["performance_stats.csv", "CVGA_stats.csv", "risk_trace.csv"];

/// Reads a file or the folder's `*.csv` of patients.
pub(super) fn import(source: &Path) -> Result<super::Import, CohortError> {
    let wanted = |name: &str| name.ends_with(".csv") && !SUMMARIES.contains(&name);
    let files = files(source, FORMAT, "*.csv", wanted)?;
    let read = |(path, name): &(PathBuf, String)| person(&TextTable::read(path, name, b',')?);
    let diaries: Result<Vec<Diary>, _> = files.iter().map(read).collect();
    people(FORMAT, source, diaries?)
}

fn person(table: &TextTable) -> Result<Diary, CohortError> {
    let stem = table.file().strip_suffix(".csv").unwrap_or(table.file());
    let id = stem.replace('#', "-");
    identifier(&id, table.file(), FORMAT, "the file's name", "rename it")?;
    let mut diary = Diary::new(&id, table.file());
    let (times, cgm) = (table.column("Time")?, table.column("CGM")?);
    let (carbs, insulin) = (table.column("CHO")?, table.column("insulin")?);
    for i in 0..table.height() {
        let at = time(&times, i)?;
        if let Some(glucose) = cgm.number(i)? {
            diary.reading(at, glucose, || cgm.place(i))?;
        }
        let (carbs_now, insulin_now) = (carbs.number(i)?, insulin.number(i)?);
        if i + 1 == table.height() {
            // The last row has a reading alone: its sample has no end.
            let given = carbs_now.unwrap_or(0.0) != 0.0 || insulin_now.is_some();
            if given {
                diary
                    .note("amounts of the last row, which has no end: left out", || table.place(i));
            }
            break;
        }
        let seconds = time(&times, i + 1)? - at;
        if !(1..=LONGEST_SAMPLE).contains(&seconds) {
            return Err(times.wrong(i + 1, "later than the row above, by at most an hour"));
        }
        if let Some(g_min) = carbs_now {
            let grams = g_min * seconds as f64 / 60.0;
            diary.dose(Channel::Carbs, at, seconds, grams, || carbs.place(i))?;
        }
        if let Some(u_min) = insulin_now {
            let rate = Rate { from: at, to: Some(at + seconds), u_h: u_min * 60.0 };
            diary.rate(rate, || insulin.place(i))?;
            diary.dose(Channel::Bolus, at, 0, 0.0, || insulin.place(i))?;
        }
    }
    diary.note("the rate includes boluses: kept as basal_u_h, bolus_u is 0", || {
        crate::error::Place::column(table.file(), "insulin")
    });
    diary.therapy = Some(crate::person::Therapy::Unknown);
    Ok(diary)
}

fn time(times: &TextColumn<'_>, i: usize) -> Result<i64, CohortError> {
    let time = times.text(i).and_then(parse_iso_start);
    time.map(second).ok_or_else(|| times.wrong(i, "a time like 2024-03-01 08:05:00"))
}
