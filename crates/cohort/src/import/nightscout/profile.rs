//! `profile*.json`: basal schedules by name, each document from its `startDate` on.

use std::collections::BTreeMap;

use chrono::{DateTime, Utc};
use serde_json::Value;

use crate::error::{CohortError, Place};
use crate::import::json_records::{JsonRecord, number, wrong_part};
use crate::import::zone::{Clock, instant, zone};
use crate::range::check_value;
use crate::record::Channel;

/// Seconds of a day.
const DAY: i64 = 86_400;
/// Most rates of a schedule: one for each five minutes.
const MOST_RATES: usize = 288;

/// Rates of a day, U/h, each from a second of the day on; the first is at 0.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Schedule {
    pub(super) rates: Vec<(i64, f64)>,
}

impl Schedule {
    /// The pieces of the schedule between two local seconds: from, to, U/h.
    pub(super) fn pieces(&self, from: i64, to: i64) -> Vec<(i64, i64, f64)> {
        let mut pieces: Vec<(i64, i64, f64)> = Vec::new();
        let mut day = from.div_euclid(DAY) * DAY;
        while day < to {
            for (i, &(start, u_h)) in self.rates.iter().enumerate() {
                let end = self.rates.get(i + 1).map_or(DAY, |next| next.0);
                let (start, end) = ((day + start).max(from), (day + end).min(to));
                if start >= end {
                    continue;
                }
                match pieces.last_mut() {
                    // The rate goes on over midnight.
                    Some(last) if last.1 == start && last.2 == u_h => last.1 = end,
                    _ => pieces.push((start, end, u_h)),
                }
            }
            day += DAY;
        }
        pieces
    }

    /// The schedule that has at any time of day the rate of `hours` later (`timeshift` of a switch).
    pub(super) fn shifted(&self, hours: f64) -> Self {
        let shift = (hours * 3600.0).round() as i64;
        let mut rates: Vec<(i64, f64)> =
            self.rates.iter().map(|(start, u_h)| ((start - shift).rem_euclid(DAY), *u_h)).collect();
        rates.sort_by_key(|rate| rate.0);
        if let (Some((first, _)), Some((_, u_h))) = (rates.first(), rates.last())
            && *first > 0
        {
            rates.insert(0, (0, *u_h));
        }
        Self { rates }
    }

    /// Reads `basal` of a profile: a list of `time` and `value`, or one number.
    pub(super) fn read(basal: &Value, place: impl Fn() -> Place) -> Result<Self, CohortError> {
        let wrong = |expected| wrong_part(place(), basal, expected);
        let mut rates = Vec::new();
        let rate = |value: &Value| {
            let u_h = number(value).ok().flatten();
            let u_h = u_h.ok_or_else(|| wrong("rates whose value is a number"))?;
            check_value(Channel::Basal, u_h, false, &place)?;
            Ok(u_h)
        };
        match basal {
            Value::Array(items) if items.len() > MOST_RATES => {
                return Err(wrong("a list of at most 288 rates, one for each five minutes"));
            }
            Value::Array(items) => {
                for item in items {
                    let second = second_of_day(item)
                        .ok_or_else(|| wrong("rates whose time is HH:MM within a day"))?;
                    rates.push((second, rate(item.get("value").unwrap_or(&Value::Null))?));
                }
            }
            value => rates.push((0, rate(value)?)),
        }
        rates.sort_by_key(|rate| rate.0);
        match rates.first() {
            Some((0, _)) => Ok(Self { rates }),
            _ => Err(wrong("a list of rates that begins at 00:00")),
        }
    }
}

/// The second at which a rate begins: `time`, or `timeAsSeconds` where that has no colon.
fn second_of_day(item: &Value) -> Option<i64> {
    let text = item.get("time").and_then(Value::as_str).unwrap_or("");
    let Some((hour, minute)) = text.trim().split_once(':') else {
        let second = number(item.get("timeAsSeconds")?).ok()?? as i64;
        return (0..DAY).contains(&second).then_some(second);
    };
    let (hour, minute): (u8, u8) = (hour.parse().ok()?, minute.get(..2)?.parse().ok()?);
    (hour < 24 && minute < 60).then_some(i64::from(hour) * 3600 + i64::from(minute) * 60)
}

/// A document: schedules by name, in force from an instant on.
#[derive(Debug, Clone)]
pub(super) struct Document {
    pub(super) from: DateTime<Utc>,
    default: String,
    schedules: BTreeMap<String, Schedule>,
}

impl Document {
    /// The default schedule.
    pub(super) fn active(&self) -> Option<&Schedule> {
        self.schedules.get(&self.default)
    }
}

/// Every document, in order of time once [`Profiles::sort`] has run.
#[derive(Default)]
pub(super) struct Profiles {
    pub(super) documents: Vec<Document>,
    zone: Option<StatedZone>,
    /// Where a profile states another zone than another profile.
    pub(super) other_zone: Option<Place>,
}

/// A zone that a profile states.
struct StatedZone {
    name: String,
    place: Place,
    /// Whether by a default profile, and since when: the greatest holds.
    rank: (bool, DateTime<Utc>),
}

impl Profiles {
    /// Reads one document.
    pub(super) fn read(&mut self, record: &JsonRecord<'_>) -> Result<(), CohortError> {
        let from = match record.text("startDate")? {
            None => DateTime::UNIX_EPOCH,
            Some(text) => instant(text)
                .ok_or_else(|| record.wrong("startDate", "an instant like 2024-03-01T07:00:00Z"))?
                .to_utc(),
        };
        let mut document = Document {
            from,
            default: record.text("defaultProfile")?.unwrap_or("Default").to_owned(),
            schedules: BTreeMap::new(),
        };
        match record.value("store") {
            Some(Value::Object(store)) => {
                for (name, profile) in store {
                    let profile = profile
                        .as_object()
                        .ok_or_else(|| record.wrong("store", "an object of profiles"))?;
                    self.one(record, "store", name, |key| profile.get(key), &mut document)?;
                }
            }
            Some(_) => return Err(record.wrong("store", "an object of profiles")),
            // Before version 0.9 a document was the profile.
            None if record.value("basal").is_some() => {
                let name = document.default.clone();
                self.one(record, "basal", &name, |key| record.value(key), &mut document)?;
            }
            None => return Err(record.wrong("store", "an object of profiles; the key is missing")),
        }
        self.documents.push(document);
        Ok(())
    }

    /// Reads the profile of a name, whose value at a key `profile` gives.
    fn one<'v>(
        &mut self,
        record: &JsonRecord<'_>,
        key: &'static str,
        name: &str,
        profile: impl Fn(&str) -> Option<&'v Value>,
        document: &mut Document,
    ) -> Result<(), CohortError> {
        if let Some(basal) = profile("basal") {
            let schedule = Schedule::read(basal, || record.place(&format!("{key}.{name}.basal")))?;
            document.schedules.insert(name.to_owned(), schedule);
        }
        if let Some(Value::String(zone)) = profile("timezone")
            && !zone.trim().is_empty()
        {
            let place = record.place(&format!("{key}.{name}.timezone"));
            let rank = (name == document.default, document.from);
            let known = self.zone.as_ref();
            if known.is_some_and(|known| known.name != *zone) {
                self.other_zone.get_or_insert_with(|| place.clone());
            }
            if known.is_none_or(|known| rank > known.rank) {
                self.zone = Some(StatedZone { name: zone.clone(), place, rank });
            }
        }
        Ok(())
    }

    /// The wall clock of the profiles; `None` if none states a zone.
    pub(super) fn clock(&self) -> Result<Option<(Clock, Place)>, CohortError> {
        let Some(StatedZone { name, place, .. }) = &self.zone else { return Ok(None) };
        let expected = "the name of a time zone, like Europe/Madrid";
        let wrong = || CohortError::cell(place.clone(), name, expected);
        let zone = zone(name).ok_or_else(wrong)?;
        Ok(Some((Clock::Zone(zone), place.clone())))
    }

    /// The schedule of a name in the latest document that has it.
    pub(super) fn named(&self, name: &str) -> Option<&Schedule> {
        self.documents.iter().rev().find_map(|document| document.schedules.get(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_schedule_goes_on_over_midnight_and_is_cut_at_the_ends() {
        let schedule = Schedule { rates: vec![(0, 0.8), (6 * 3600, 1.0), (22 * 3600, 0.8)] };
        let pieces = schedule.pieces(5 * 3600, DAY + 6 * 3600 + 60);
        assert_eq!(
            pieces,
            [
                (5 * 3600, 6 * 3600, 0.8),
                (6 * 3600, 22 * 3600, 1.0),
                (22 * 3600, DAY + 6 * 3600, 0.8),
                (DAY + 6 * 3600, DAY + 6 * 3600 + 60, 1.0),
            ]
        );
    }

    #[test]
    fn a_rate_begins_at_a_time_of_day() {
        let second = |item: Value| second_of_day(&item);
        for (time, expected) in [
            ("00:00", Some(0)),
            ("23:59", Some(DAY - 60)),
            ("7:30:00", Some(27_000)),
            ("24:00", None),
            ("01:-5", None),
            ("-1:00", None),
            ("01:60", None),
            ("9223372036854775807:00", None),
        ] {
            // What the text says counts, also where it cannot be.
            let item = serde_json::json!({ "time": time, "timeAsSeconds": 7 });
            assert_eq!(second(item), expected, "{time}");
        }
        assert_eq!(second(serde_json::json!({ "timeAsSeconds": 3600 })), Some(3600));
        assert_eq!(second(serde_json::json!({ "timeAsSeconds": 1e300 })), None);
    }

    #[test]
    fn a_schedule_has_so_many_rates_and_no_more() {
        let schedule = |count: usize| {
            let rates = vec![serde_json::json!({ "time": "00:00", "value": 1 }); count];
            Schedule::read(&Value::Array(rates), || Place::file("profile.json"))
        };
        assert_eq!(schedule(MOST_RATES).expect("as many as there may be").rates.len(), MOST_RATES);
        let error = schedule(MOST_RATES + 1).expect_err("one more").to_string();
        assert!(error.contains("is not a list of at most 288 rates"), "{error}");
    }
}
