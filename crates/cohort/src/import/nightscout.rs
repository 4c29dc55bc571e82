//! JSON files of a Nightscout site (github.com/nightscout/cgm-remote-monitor): `entries*.json`,
//! `treatments*.json` and `profile*.json`, as the site's interface or `mongoexport` writes them.
//!
//! A folder with entries is one person and names it; otherwise every sub-folder with entries is.
//! Times are instants. The wall clock is that of the zone that is given, else of the profile's `timezone`;
//! without one, each record needs its `utcOffset`. The basal rate is the active profile's, changed by temporary rates,
//! suspensions and profile switches. Entries other than `sgv` are not sensor readings. What the site
//! marks as deleted (`isValid` false, interface version 3) is not read.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use chrono::{DateTime, Utc};

use super::diary::{Diary, Moment, people, second};
use super::files::{self, name};
use super::json_records::{JsonRecord, for_each};
use super::zone::{Clock, from_millis, instant};
use crate::error::{CohortError, Place};
use crate::range::{MMOL_MEDIAN, check_value, median};
use crate::record::Channel;

mod basal;
mod profile;
mod treatments;

use profile::Profiles;
use treatments::Treatments;

const FORMAT: &str = "nightscout";
/// Up to this value a reading in mg/dL is a code of the sensor, not glucose.
const LAST_CODE: f64 = 12.0;

/// Reads a folder.
pub(super) fn import(source: &Path, zone: Option<Clock>) -> Result<super::Import, CohortError> {
    let mut diaries = Vec::new();
    for folder in folders(source)? {
        diaries.push(person(&folder, zone)?);
    }
    people(FORMAT, source, diaries)
}

/// The folders that have entries: the source or those inside it, in order.
fn folders(source: &Path) -> Result<Vec<PathBuf>, CohortError> {
    files::folder(source, FORMAT, "entries.json, treatments.json and profile.json")?;
    if !json_files(source, "entries")?.is_empty() {
        return Ok(vec![source.to_owned()]);
    }
    let mut folders = Vec::new();
    for path in files::entries(source)? {
        if path.is_dir() && !json_files(&path, "entries")?.is_empty() {
            folders.push(path);
        }
    }
    if folders.is_empty() {
        let reason = "no file named entries*.json, here or in a folder inside";
        return Err(CohortError::layout(source.display(), FORMAT, reason));
    }
    Ok(folders)
}

/// The files of a folder whose names begin with `kind`, in order.
fn json_files(folder: &Path, kind: &str) -> Result<Vec<(PathBuf, String)>, CohortError> {
    files::named(folder, |name| name.starts_with(kind) && name.ends_with(".json"))
}

fn person(folder: &Path, zone: Option<Clock>) -> Result<Diary, CohortError> {
    let id = std::path::absolute(folder).map_or_else(|_| name(folder), |path| name(&path));
    let shown = folder.display().to_string();
    files::identifier(&id, &shown, FORMAT, "the folder's name", files::LETTERS)?;
    let mut profiles = Profiles::default();
    for (path, name) in json_files(folder, "profile")? {
        for_each(&path, &name, |record| profiles.read(&record))?;
    }
    profiles.documents.sort_by_key(|document| document.from);
    let entries = json_files(folder, "entries")?;
    let file = entries.first().map_or("entries.json", |(_, name)| name.as_str());
    let mut diary = Diary::new(&id, file);
    diary.unit_is_open = true;
    let stated = match zone {
        Some(zone) => Some((zone, Place::file(file), "--zone says it")),
        None => profiles.clock()?.map(|(clock, place)| (clock, place, "the profile states it")),
    };
    let clock = stated.as_ref().map(|(clock, ..)| *clock);
    let (place, conclusion, evidence) = match stated {
        Some((clock, place, evidence)) => (place, format!("local time of {clock}"), evidence),
        None => {
            let each = "local time from the utcOffset of each record".to_owned();
            (Place::file(file), each, "no profile states a time zone")
        }
    };
    diary.account.infer(place, conclusion, evidence);
    read_entries(&entries, clock, &mut diary)?;

    let mut treatments = Treatments { clock, ..Treatments::default() };
    let mut seen = HashSet::new();
    for (path, name) in json_files(folder, "treatments")? {
        for_each(&path, &name, |record| {
            if deleted(&record, &mut diary) {
                return Ok(());
            }
            // `mongoexport` writes an object here.
            let id = record.value("_id").map(ToString::to_string);
            if id.is_some_and(|id| !seen.insert(id)) {
                let what = "records with an _id that came before: left out";
                diary.note(what, || record.place("_id"));
                return Ok(());
            }
            treatments.read(&record, &mut diary)
        })?;
    }
    basal::place(&profiles, treatments, &mut diary)?;
    Ok(diary)
}

/// Whether the site says that a record was deleted.
fn deleted(record: &JsonRecord<'_>, diary: &mut Diary) -> bool {
    let deleted = record.value("isValid").and_then(serde_json::Value::as_bool) == Some(false);
    if deleted {
        diary.note("records that were deleted: left out", || record.place("isValid"));
    }
    deleted
}

fn read_entries(
    files: &[(PathBuf, String)],
    clock: Option<Clock>,
    diary: &mut Diary,
) -> Result<(), CohortError> {
    // The unit is known when all are read.
    let mut readings: Vec<(Moment, f64, Place)> = Vec::new();
    for (path, name) in files {
        for_each(path, name, |record| {
            if deleted(&record, diary) {
                return Ok(());
            }
            if record.text("type")?.is_some_and(|kind| kind != "sgv") {
                let what = "entries that are not sensor readings: left out";
                diary.note(what, || record.place("type"));
                return Ok(());
            }
            let Some(value) = record.number("sgv")? else {
                diary.note("entries without a reading: left out", || record.place("sgv"));
                return Ok(());
            };
            let at = moment(&record, &["date", "dateString", "sysTime"], clock)?;
            readings.push((at, value, record.place("sgv")));
            Ok(())
        })?;
    }
    let values = readings.iter().map(|(_, value, _)| *value).filter(|value| *value > 0.0);
    let in_mmol = median(values.collect()).is_some_and(|median| median < MMOL_MEDIAN);
    let factor = if in_mmol { physiology::MG_PER_DL_PER_MMOL_PER_L } else { 1.0 };
    for (at, value, place) in readings {
        let code = value <= LAST_CODE && (!in_mmol || value <= 0.0);
        if code && value >= 0.0 {
            diary.note("readings of 12 or less: codes of the sensor, left out", || place);
        } else {
            check_value(Channel::Cgm, value * factor, false, || place.clone())?;
            diary.reading(at, value, || place.clone())?;
        }
    }
    Ok(())
}

/// The local time of a record: the first of `keys` that it has.
fn moment(
    record: &JsonRecord<'_>,
    keys: &[&'static str],
    clock: Option<Clock>,
) -> Result<Moment, CohortError> {
    let Some(key) = keys.iter().find(|key| record.value(key).is_some()) else {
        return Err(record.wrong(keys[0], "a time; the key is missing"));
    };
    let expected = "an instant: milliseconds since 1970, or a text like 2024-03-01T07:00:00.000Z";
    let (at, offset): (DateTime<Utc>, Option<i32>) = match record.value(key) {
        Some(serde_json::Value::Number(_)) => {
            let millis = record.number(key)?.and_then(from_millis);
            (millis.ok_or_else(|| record.wrong(key, expected))?, None)
        }
        _ => {
            let text = record.text(key)?.unwrap_or_default();
            let at = instant(text).ok_or_else(|| record.wrong(key, expected))?;
            let minutes = at.offset().local_minus_utc() / 60;
            // `Z` says nothing of the person's clock.
            (at.to_utc(), (minutes != 0).then_some(minutes))
        }
    };
    let clock = match clock {
        Some(clock) => clock,
        None => {
            let minutes = record.number("utcOffset")?.or(offset.map(f64::from));
            let Some(minutes) = minutes.filter(|minutes| minutes.abs() <= 18.0 * 60.0) else {
                let expected = "minutes ahead of UTC; add profile.json, which has the time zone, or \
                                say where the person lived with --zone";
                return Err(record.wrong("utcOffset", expected));
            };
            Clock::Offset(minutes as i32)
        }
    };
    Ok(Moment { second: second(clock.local(at)), again: clock.shows_again(at) })
}
