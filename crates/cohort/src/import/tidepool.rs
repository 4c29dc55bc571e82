//! Exports of Tidepool (tidepool.org): one JSON or XLSX file per person.
//!
//! The file's name is the person. A JSON file is an array of data; a workbook has a sheet for each
//! type of data and a datum a row ([`sheets`]). Glucose is in mmol/L or mg/dL, each datum says
//! which. The local time is that of `time` in the zone that is given; without one `deviceTime`, or
//! `time` with `timezoneOffset`, or in the zone `timezone`. Carbohydrate comes from `wizard` and
//! `food`; a meal that both have is given twice.
//!
//! Durations are milliseconds in Tidepool's own data, and minutes in what its site exports, which
//! also writes `nutrition` as text and leaves out the doses of injections (package
//! `@tidepool/data-tools` 2.5, which `tidepool-org/export` calls). The longest duration of a file
//! shows which it is.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use serde_json::Value;

use super::diary::{Diary, Moment, Rate, people, second};
use super::files::{LETTERS, files, identifier};
use super::json_records::{JsonRecord, for_each, number, wrong_part};
use super::workbook::{Workbook, is_archive};
use super::zone::{Clock, instant, zone};
use crate::error::{CohortError, Place};
use crate::record::Channel;
use crate::wall_clock::parse_iso;

mod sheets;

const FORMAT: &str = "tidepool";
/// mg/dL in a mmol/L as Tidepool converts them (its data model, `units`).
const MG_PER_DL: f64 = 18.01559;
/// Food within this many seconds of a bolus calculator's entry may be the same meal.
const SAME_MEAL: i64 = 900;
/// Ends of the names of exports in a folder.
const ENDINGS: [&str; 2] = [".json", ".xlsx"];
/// Longest duration, ms: 10 days.
const LONGEST: f64 = 8.64e8;
const INCOMPLETE: &str = "the export says that it is not complete: export a shorter range of dates";
/// ms in a minute.
const MINUTE: f64 = 60_000.0;

/// Reads a file or the folder's `*.json` and `*.xlsx`.
pub(super) fn import(source: &Path, zone: Option<Clock>) -> Result<super::Import, CohortError> {
    let mut diaries = Vec::new();
    let mut known: HashMap<String, String> = HashMap::new();
    let wanted = |name: &str| ENDINGS.iter().any(|ending| name.ends_with(ending));
    for (path, name) in files(source, FORMAT, "*.json or *.xlsx", wanted)? {
        let stem = ENDINGS.iter().find_map(|ending| name.strip_suffix(ending));
        let id = stem.unwrap_or(&name).to_owned();
        identifier(&id, &name, FORMAT, "the file's name", LETTERS)?;
        if let Some(other) = known.insert(id.clone(), name.clone()) {
            let reason = format!("'{other}' is of the same person; keep one of them");
            return Err(CohortError::layout(name, FORMAT, reason));
        }
        let mut diary = Diary::new(&id, &name);
        if let Some(clock) = zone {
            let local = format!("local time of {clock}");
            diary.account.infer(Place::file(&name), local, "--zone says it");
        }
        let mut reader = Reader { diary, zone, duration: MINUTE, ..Reader::default() };
        if is_archive(&path) {
            sheets::read(&mut Workbook::open(&path, &name)?, &name, &mut reader)?;
        } else {
            reader.json(&path, &name)?;
        }
        diaries.push(reader.finish());
    }
    people(FORMAT, source, diaries)
}

#[derive(Default)]
struct Reader {
    diary: Diary,
    /// The wall clock that was given.
    zone: Option<Clock>,
    /// ms in the unit of durations.
    duration: f64,
    seen: HashSet<String>,
    /// Seconds and grams of carbohydrate of the bolus calculator.
    wizards: Vec<(i64, f64)>,
    /// Seconds and grams of carbohydrate of food, and where.
    foods: Vec<(i64, f64, Place)>,
}

impl Reader {
    /// Reads a JSON file, after a look at its durations.
    fn json(&mut self, path: &Path, name: &str) -> Result<(), CohortError> {
        let mut longest = 0.0_f64;
        for_each(path, name, |record| {
            if matches!(record.text("type"), Ok(Some("basal" | "bolus")))
                && let Ok(Some(duration)) = record.number("duration")
            {
                longest = longest.max(duration);
            }
            Ok(())
        })?;
        self.duration = if longest > LONGEST / MINUTE { 1.0 } else { MINUTE };
        if longest > 0.0 {
            let unit = if self.duration == MINUTE { "minutes" } else { "milliseconds" };
            let (unit, evidence) =
                (format!("durations in {unit}"), format!("the longest is {longest}"));
            self.diary.account.infer(Place::column(name, "duration"), unit, evidence);
        }
        for_each(path, name, |record| self.read(&record))
    }

    fn read(&mut self, record: &JsonRecord<'_>) -> Result<(), CohortError> {
        if record.value("exportError").is_some() {
            self.diary.note(INCOMPLETE, || record.place("exportError"));
            return Ok(());
        }
        let Some(kind) = record.text("type")? else {
            return Err(record.wrong("type", "the kind of datum, like cbg; the key is missing"));
        };
        if let Some(id) = record.text("id")?
            && !self.seen.insert(id.to_owned())
        {
            self.diary.note("data with an id that came before: left out", || record.place("id"));
            return Ok(());
        }
        match kind {
            "cbg" => self.glucose(record),
            "basal" => self.basal(record),
            "bolus" => self.bolus(record),
            "wizard" => self.wizard(record),
            "food" => self.food(record),
            "insulin" => self.injection(record),
            "deviceEvent" => self.event(record),
            _ => Ok(()),
        }
    }

    fn glucose(&mut self, record: &JsonRecord<'_>) -> Result<(), CohortError> {
        let factor = match record.text("units")? {
            Some("mmol/L" | "mmol/l") => MG_PER_DL,
            Some("mg/dL" | "mg/dl") => 1.0,
            _ => return Err(record.wrong("units", "mmol/L or mg/dL")),
        };
        let value = required(record, "value")?;
        self.diary.reading(moment(record, self.zone)?, value * factor, || record.place("value"))
    }

    fn basal(&mut self, record: &JsonRecord<'_>) -> Result<(), CohortError> {
        let u_h = match (record.text("deliveryType")?, record.number("rate")?) {
            (_, Some(rate)) => rate,
            (Some("suspend"), None) => 0.0,
            (_, None) => return Err(record.wrong("rate", "U/h; the key is missing")),
        };
        let from = at(record, self.zone)?;
        let to = record.number("duration")?.map(|_| self.seconds(record)).transpose()?;
        let to = to.map(|seconds| from + seconds);
        self.diary.rate(Rate { from, to, u_h }, || record.place("rate"))
    }

    fn bolus(&mut self, record: &JsonRecord<'_>) -> Result<(), CohortError> {
        let at = at(record, self.zone)?;
        let (normal, extended) = (record.number("normal")?, record.number("extended")?);
        if normal.is_none() && extended.is_none() {
            return Err(record.wrong("normal", "U; the key (or extended) is missing"));
        }
        if let Some(amount) = normal {
            self.diary.dose(Channel::Bolus, at, 0, amount, || record.place("normal"))?;
        }
        if let Some(amount) = extended {
            let seconds = self.seconds(record)?;
            self.diary.dose(Channel::Bolus, at, seconds, amount, || record.place("extended"))?;
        }
        Ok(())
    }

    fn wizard(&mut self, record: &JsonRecord<'_>) -> Result<(), CohortError> {
        let Some(grams) = record.number("carbInput")? else { return Ok(()) };
        if record.text("carbUnits")?.is_some_and(|unit| unit != "grams") {
            return Err(record.wrong("carbUnits", "grams; exchanges have no fixed weight"));
        }
        if grams != 0.0 {
            let at = at(record, self.zone)?;
            self.wizards.push((at, grams));
            self.diary.dose(Channel::Carbs, at, 0, grams, || record.place("carbInput"))?;
        }
        Ok(())
    }

    fn food(&mut self, record: &JsonRecord<'_>) -> Result<(), CohortError> {
        let key = "nutrition.carbohydrate.net";
        let parsed = match record.value("nutrition") {
            // As the site exports it.
            Some(Value::String(text)) => {
                let parsed = serde_json::from_str::<Value>(text);
                Some(parsed.map_err(|_| record.wrong("nutrition", "JSON of what food contains"))?)
            }
            _ => None,
        };
        let food = parsed.as_ref().or_else(|| record.value("nutrition"));
        let net = food.and_then(|food| food.get("carbohydrate")?.get("net"));
        let Some(net) = net else {
            self.diary.note("food without carbohydrate: left out", || record.place("nutrition"));
            return Ok(());
        };
        let grams = number(net).ok().flatten();
        let grams = grams.ok_or_else(|| wrong_part(record.place(key), net, "a number"))?;
        let at = at(record, self.zone)?;
        self.foods.push((at, grams, record.place(key)));
        self.diary.dose(Channel::Carbs, at, 0, grams, || record.place(key))
    }

    /// An injection: rapid insulin is a bolus, long-acting insulin has no rate.
    fn injection(&mut self, record: &JsonRecord<'_>) -> Result<(), CohortError> {
        if record.value("formulation").is_none() && record.value("dose").is_none() {
            let what = "injections without dose and insulin, which Tidepool's site does not export: \
                        left out";
            self.diary.note(what, || record.place("dose"));
            return Ok(());
        }
        let kind = record.value("formulation").and_then(|one| one.get("simple")?.get("actingType"));
        let total = record.value("dose").and_then(|dose| number(dose.get("total")?).ok()?);
        if kind.and_then(Value::as_str) != Some("rapid") {
            let what = "injections that are not rapid insulin: left out";
            self.diary.note(what, || record.place("formulation"));
            let amount = total.unwrap_or(0.0);
            return self.diary.leave_out_injection(amount, || record.place("dose"));
        }
        let total = total.ok_or_else(|| record.wrong("dose", "an object with a number total"))?;
        self.diary.dose(Channel::Bolus, at(record, self.zone)?, 0, total, || record.place("dose"))
    }

    /// Whole seconds of a duration.
    fn seconds(&self, record: &JsonRecord<'_>) -> Result<i64, CohortError> {
        let millis = required(record, "duration")? * self.duration;
        if !(0.0..=LONGEST).contains(&millis) {
            return Err(record.wrong("duration", "a duration from 0 to 10 days"));
        }
        Ok((millis / 1000.0).round() as i64)
    }

    fn event(&mut self, record: &JsonRecord<'_>) -> Result<(), CohortError> {
        let prime = record.text("subType")? == Some("prime");
        if prime && record.text("primeTarget")? == Some("cannula") {
            self.diary.set_change(at(record, self.zone)?, || record.place("subType"))?;
        }
        Ok(())
    }

    /// The diary, with the meals that seem to be given twice counted.
    fn finish(mut self) -> Diary {
        for (at, grams, place) in &self.foods {
            let same = |(other, amount): &(i64, f64)| {
                (other - at).abs() <= SAME_MEAL && (amount - grams).abs() < 0.5
            };
            if self.wizards.iter().any(same) {
                let what = "food like a bolus calculator's entry at most 15 min apart: both kept, \
                            perhaps one meal";
                self.diary.note(what, || place.clone());
            }
        }
        self.diary
    }
}

fn required(record: &JsonRecord<'_>, key: &str) -> Result<f64, CohortError> {
    record.number(key)?.ok_or_else(|| record.wrong(key, "a number; the key is missing"))
}

/// The local second of a datum.
fn at(record: &JsonRecord<'_>, given: Option<Clock>) -> Result<i64, CohortError> {
    Ok(moment(record, given)?.second)
}

fn moment(record: &JsonRecord<'_>, given: Option<Clock>) -> Result<Moment, CohortError> {
    let of = |clock: Clock, instant| Moment {
        second: second(clock.local(instant)),
        again: clock.shows_again(instant),
    };
    let given = given.filter(|_| record.value("time").is_some());
    if given.is_none()
        && let Some(text) = record.text("deviceTime")?
    {
        let time = parse_iso(text.get(..19).unwrap_or(text));
        let expected = "a local time like 2024-03-01T08:05:00";
        let second = time.map(second).ok_or_else(|| record.wrong("deviceTime", expected))?;
        return Ok(Moment::from(second));
    }
    let Some(text) = record.text("time")? else {
        return Err(record.wrong("time", "an instant; the key is missing"));
    };
    let expected = "an instant like 2024-03-01T07:05:00.000Z";
    let instant = instant(text).ok_or_else(|| record.wrong("time", expected))?.to_utc();
    if let Some(clock) = given {
        return Ok(of(clock, instant));
    }
    let clock = match (record.number("timezoneOffset")?, record.text("timezone")?) {
        (Some(minutes), _) if minutes.abs() <= 18.0 * 60.0 => Clock::Offset(minutes as i32),
        (Some(_), _) => return Err(record.wrong("timezoneOffset", "minutes ahead of UTC")),
        (None, Some(name)) => Clock::Zone(zone(name).ok_or_else(|| {
            record.wrong("timezone", "the name of a time zone, like Europe/Madrid")
        })?),
        (None, None) => {
            let expected = "a local time; deviceTime, timezoneOffset and timezone are missing: say where \
                            the person lived with --zone";
            return Err(record.wrong("deviceTime", expected));
        }
    };
    Ok(of(clock, instant))
}
