//! From times as written to the wall clock of a person.

use std::str::FromStr as _;

use chrono::offset::LocalResult;
use chrono::{NaiveDateTime, TimeDelta, TimeZone as _};
use chrono_tz::{TZ_VARIANTS, Tz};

use super::stamp::Stamp;
use crate::error::{CohortError, shorten};
use crate::near_name::plain;

/// How written times become local ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Clock {
    pub(super) zone: Option<Tz>,
    /// Times without an offset are UTC.
    pub(super) utc: bool,
}

/// A local time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Local {
    pub(super) time: NaiveDateTime,
    /// Where the time lies in its zone.
    pub(super) hour: Hour,
}

/// What daylight-saving time makes of an hour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Hour {
    /// There is one such hour.
    Usual,
    /// The hour before the clock was set back, whose times come again.
    First,
    /// The hour after it.
    Second,
    /// One of the two.
    FirstOrSecond,
    /// The clock skipped it: it was not set forward.
    Skipped,
}

impl Clock {
    /// The clock of a zone's name.
    pub(super) fn new(zone: Option<&str>, utc: bool) -> Result<Self, CohortError> {
        let zone = zone.map(find).transpose()?;
        if utc && zone.is_none() {
            let reason = "say also where the person lived, like --zone Europe/Madrid";
            return Err(CohortError::option("--utc", reason));
        }
        Ok(Self { zone, utc })
    }

    /// The local time of a stamp; `None` where it is an instant and the zone is not known.
    pub(super) fn local(self, stamp: Stamp) -> Option<Local> {
        let offset = stamp.offset.or(self.utc.then_some(0));
        let usual = |time| Local { time, hour: Hour::Usual };
        match (offset, self.zone) {
            (None, None) => Some(usual(stamp.written)),
            (None, Some(zone)) => {
                let hour = match zone.from_local_datetime(&stamp.written) {
                    LocalResult::Single(_) => Hour::Usual,
                    LocalResult::Ambiguous(..) => Hour::FirstOrSecond,
                    LocalResult::None => Hour::Skipped,
                };
                Some(Local { time: stamp.written, hour })
            }
            // The clock that was written is the person's own.
            (Some(offset), None) => (offset != 0).then(|| usual(stamp.written)),
            (Some(offset), Some(zone)) => {
                let utc = stamp.written - TimeDelta::seconds(i64::from(offset));
                let time = zone.from_utc_datetime(&utc);
                let hour = match zone.from_local_datetime(&time.naive_local()) {
                    LocalResult::Ambiguous(first, _) if first == time => Hour::First,
                    LocalResult::Ambiguous(..) => Hour::Second,
                    _ => Hour::Usual,
                };
                Some(Local { time: time.naive_local(), hour })
            }
        }
    }
}

/// The zone of a name, or what it probably is.
pub(in crate::import) fn find(name: &str) -> Result<Tz, CohortError> {
    let name = name.trim();
    if let Ok(zone) = Tz::from_str(name) {
        return Ok(zone);
    }
    let plain_name = plain(name);
    let named = |zone: &&Tz| {
        let city = zone.name().rsplit('/').next().unwrap_or("");
        !plain_name.is_empty() && (plain(zone.name()) == plain_name || plain(city) == plain_name)
    };
    let reason = match TZ_VARIANTS.iter().find(named) {
        Some(zone) => format!("no such zone: did you mean '{zone}'?"),
        None => "no such zone; write a name like Europe/Madrid or America/New_York".into(),
    };
    let option = format!("--zone {}", shorten(name, 40));
    Err(CohortError::option(option, reason))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::table::stamp::DateOrder;

    fn local(clock: Clock, text: &str) -> Option<(String, Hour)> {
        let stamp = Stamp::parse(text, DateOrder::DayFirst).expect("a time");
        clock.local(stamp).map(|local| (local.time.to_string(), local.hour))
    }

    #[test]
    fn instants_follow_daylight_saving_time() {
        let madrid = Clock::new(Some("Europe/Madrid"), false).expect("a zone");
        for (text, expected, hour) in [
            ("2024-03-31T00:59:00Z", "2024-03-31 01:59:00", Hour::Usual),
            ("2024-03-31T01:00:00Z", "2024-03-31 03:00:00", Hour::Usual),
            ("2024-10-27T00:30:00Z", "2024-10-27 02:30:00", Hour::First),
            ("2024-10-27T01:30:00Z", "2024-10-27 02:30:00", Hour::Second),
            ("2024-10-27T02:30:00+01:00", "2024-10-27 02:30:00", Hour::Second),
            ("2024-03-31 02:30:00", "2024-03-31 02:30:00", Hour::Skipped),
            ("2024-10-27 02:30:00", "2024-10-27 02:30:00", Hour::FirstOrSecond),
            ("2024-07-01 12:00:00", "2024-07-01 12:00:00", Hour::Usual),
        ] {
            assert_eq!(local(madrid, text), Some((expected.to_owned(), hour)), "{text}");
        }
        let utc = Clock::new(Some("America/New_York"), true).expect("a zone");
        let expected = Some(("2024-07-01 08:00:00".to_owned(), Hour::Usual));
        assert_eq!(local(utc, "2024-07-01 12:00:00"), expected);
    }

    #[test]
    fn without_a_zone_an_instant_has_no_local_time() {
        let none = Clock::new(None, false).expect("no zone");
        assert_eq!(local(none, "2024-07-01T12:00:00Z"), None);
        let own = Some(("2024-07-01 12:00:00".to_owned(), Hour::Usual));
        assert_eq!(local(none, "2024-07-01T12:00:00+02:00"), own);
        assert_eq!(local(none, "2024-07-01 12:00"), own);
        assert!(Clock::new(None, true).is_err());
    }

    #[test]
    fn a_city_alone_is_enough_for_a_hint() {
        for (name, says) in [
            ("Madrid", "did you mean 'Europe/Madrid'?"),
            ("europe/madrid", "did you mean 'Europe/Madrid'?"),
            ("new york", "did you mean 'America/New_York'?"),
            ("CEST+1", "write a name like"),
        ] {
            let error = Clock::new(Some(name), false).expect_err("refused").to_string();
            assert!(error.contains(says), "{error}");
        }
    }
}
