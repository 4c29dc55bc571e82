//! The watch: step counts in local time, sleep stages in UTC with an offset.

use std::collections::BTreeMap;

use super::events::{Stamp, stamp};
use crate::error::{CohortError, Place};
use crate::import::diary::{SECONDS, second};
use crate::import::report::Account;
use crate::import::steps::{STEP, Span, step_of};
use crate::range::check_value;
use crate::record::{Channel, Record};
use crate::text_table::{TextColumn, TextTable};
use crate::wall_clock::parse_day_first;

const OFFSET: &str = "start_time_offset_s";
/// Stages of a session; all but the last are sleep.
const STAGES: [&str; 4] = ["deep", "light", "rem", "awake"];
/// Longest session, s; longer ones are damaged.
const LONGEST_SESSION: i64 = 24 * 3600;

/// Spreads the counts of `Activity Data` evenly over the steps of their interval (15 min), summed
/// over kinds of activity. Returns in which steps the watch was worn.
pub(super) fn steps(
    table: &TextTable,
    span: &Span,
    record: &mut Record,
    account: &mut Account,
) -> Result<Vec<bool>, CohortError> {
    let times = table.column("activity_ts")?;
    let (counts, durations) = (table.column("step_count")?, table.column("duration_s")?);
    let offsets = table.column(OFFSET)?;
    let mut used_offsets: BTreeMap<i64, usize> = BTreeMap::new();
    let mut outside = 0;
    for i in 0..table.height() {
        let time = match stamp(table, &times, i)? {
            None => continue,
            Some(Stamp::Day) => {
                account.note(times.place(i), "activity without a time of day: left out", 1);
                continue;
            }
            Some(Stamp::At(time)) => time,
        };
        *used_offsets.entry(whole(&offsets, i)?).or_default() += 1;
        let count = counts.number(i)?.unwrap_or(0.0);
        let seconds = durations.required_number(i)?;
        if !(0.0..=86_400.0).contains(&seconds) {
            return Err(durations.wrong(i, "seconds of an interval, at most 86400"));
        }
        if !(0.0..=100_000.0).contains(&count) {
            return Err(counts.wrong(i, "a count of steps from 0 to 100000"));
        }
        let pieces = (seconds / 300.0).round().max(1.0) as i64;
        for piece in 0..pieces {
            let Some(k) = span.index(step_of(second(time)) + piece) else {
                outside += usize::from(piece == 0);
                continue;
            };
            let cell = &mut record.channel_mut(Channel::Steps)[k];
            let sum = cell.unwrap_or(0.0) + count / pieces as f64;
            check_value(Channel::Steps, sum, false, || counts.place(i))?;
            *cell = Some(sum);
        }
    }
    let place = Place::column(table.file(), "step_count");
    let what = "activity outside the span of glucose and insulin: left out";
    account.note(place.clone(), what, outside);
    account.note(place, "step counts of 15 min spread evenly over three steps", table.height());
    offsets_note(table, &used_offsets, account);
    Ok(record.steps().iter().map(Option::is_some).collect())
}

/// Puts the share of each step asleep into the record: from the stages inside a session, 0 outside
/// a session where the watch was worn, missing elsewhere.
pub(super) fn sleep(
    table: &TextTable,
    span: &Span,
    worn: &[bool],
    record: &mut Record,
    account: &mut Account,
) -> Result<(), CohortError> {
    let starts = table.column("start_date_ts")?;
    let (durations, offsets) = (table.column("duration_in_sec")?, table.column(OFFSET)?);
    let awake = table.column("awake_s")?;
    let stages = STAGES.map(|stage| stage_column(table, stage));
    let (mut sessions, mut begin_with_a_stage) = (0, 0);
    // Seconds asleep, and in a session, of each step.
    let (mut asleep, mut covered) = (vec![0; span.len()], vec![0; span.len()]);
    let mut used_offsets: BTreeMap<i64, usize> = BTreeMap::new();
    for i in 0..table.height() {
        let Some(start) = starts.text(i) else {
            account.note(table.place(i), "sleep without a start: left out", 1);
            continue;
        };
        let start = parse_day_first(start).map(second);
        let start = start.ok_or_else(|| starts.wrong(i, "a time in UTC like 31/12/2023 22:05"))?;
        let offset = whole(&offsets, i)?;
        *used_offsets.entry(offset).or_default() += 1;
        // The duration is the time asleep; the session also includes the time awake.
        let duration = whole(&durations, i)? + whole(&awake, i)?;
        if !(0..=LONGEST_SESSION).contains(&duration) {
            return Err(durations.wrong(i, "seconds of one sleep, at most 86400"));
        }
        let end = start + duration;
        let mut first_stage = None;
        for (stage, column) in STAGES.iter().zip(&stages) {
            let Some(column) = column else { continue };
            for (from, to) in intervals(column, i)? {
                first_stage = Some(first_stage.map_or(from, |first| from.min(first)));
                if *stage != "awake" {
                    add(&mut asleep, span, from + offset, to + offset);
                }
                let beyond = from < start - 60 || to > end + 60;
                let what = "stages outside their session's start and duration in UTC: kept";
                account.note(column.place(i), what, usize::from(beyond));
            }
        }
        let what = "sleep sessions without stages: left out";
        account.note(starts.place(i), what, usize::from(first_stage.is_none()));
        if let Some(first) = first_stage {
            sessions += 1;
            begin_with_a_stage += usize::from(first == start);
            add(&mut covered, span, start + offset, end + offset);
        }
    }
    let mut overlaps = 0;
    for (k, cell) in record.channel_mut(Channel::SleepEfficiency).iter_mut().enumerate() {
        overlaps += usize::from(asleep[k] > STEP);
        if covered[k] > 0 || asleep[k] > 0 {
            *cell = Some(asleep[k].min(STEP) as f64 / STEP as f64);
        } else if worn[k] {
            *cell = Some(0.0);
        }
    }
    let what = "steps that two sleep sessions claim: asleep at most wholly";
    account.note(Place::file(table.file()), what, overlaps);
    account.infer(
        Place::column(table.file(), "start_date_ts"),
        "UTC; local time adds start_time_offset_s",
        format!(
            "{begin_with_a_stage} of {sessions} sessions start at the minute of their first \
             stage, which is in seconds since 1970 UTC"
        ),
    );
    offsets_note(table, &used_offsets, account);
    Ok(())
}

fn offsets_note(table: &TextTable, offsets: &BTreeMap<i64, usize>, account: &mut Account) {
    if offsets.len() < 2 {
        return;
    }
    let list: Vec<String> =
        offsets.iter().map(|(s, rows)| format!("{s} s ({rows} rows)")).collect();
    let what = format!(
        "the watch's clock was moved ({}); whether the pump's and the sensor's were is not recorded",
        list.join(", ")
    );
    account.note(Place::column(table.file(), OFFSET), &what, 1);
}

/// Adds the seconds of an interval to the steps it touches.
fn add(seconds: &mut [i64], span: &Span, from: i64, to: i64) {
    for step in step_of(from).max(span.first)..=step_of(to).min(span.end - 1) {
        if let Some(k) = span.index(step) {
            seconds[k] += (to.min((step + 1) * STEP) - from.max(step * STEP)).max(0);
        }
    }
}

/// The column of a stage; some files write `.` for `_`.
fn stage_column<'a>(table: &'a TextTable, stage: &str) -> Option<TextColumn<'a>> {
    let wanted = format!("sleep_levels_map_{stage}");
    let at = table.header().iter().position(|name| name.replace('.', "_") == wanted)?;
    Some(table.column_at(at))
}

/// The intervals of a stage, UTC: a JSON list of starts and ends in seconds since 1970.
fn intervals(column: &TextColumn<'_>, i: usize) -> Result<Vec<(i64, i64)>, CohortError> {
    #[derive(serde::Deserialize)]
    #[serde(rename_all = "camelCase")]
    struct Interval {
        start_time_in_seconds: i64,
        end_time_in_seconds: i64,
    }
    let Some(text) = column.text(i) else { return Ok(Vec::new()) };
    let wrong = || column.wrong(i, "a JSON list of startTimeInSeconds and endTimeInSeconds");
    let intervals: Vec<Interval> = serde_json::from_str(text).map_err(|_| wrong())?;
    let times = intervals.iter().map(|one| (one.start_time_in_seconds, one.end_time_in_seconds));
    let fits = |(from, to): &(i64, i64)| {
        SECONDS.contains(from)
            && SECONDS.contains(to)
            && (0..=LONGEST_SESSION).contains(&(to - from))
    };
    times.map(|times| Some(times).filter(fits).ok_or_else(wrong)).collect()
}

/// A whole number of seconds.
fn whole(column: &TextColumn<'_>, i: usize) -> Result<i64, CohortError> {
    let value = column.required_number(i)?;
    if value.fract() == 0.0 && value.abs() <= 1e7 {
        Ok(value as i64)
    } else {
        Err(column.wrong(i, "whole seconds"))
    }
}
