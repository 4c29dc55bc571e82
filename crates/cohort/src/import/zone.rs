//! From instants to the wall clock of a person.

use chrono::offset::LocalResult;
use chrono::{DateTime, Datelike as _, FixedOffset, NaiveDateTime, TimeDelta, TimeZone as _, Utc};
use chrono_tz::{TZ_VARIANTS, Tz};

/// The wall clock that shows an instant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Clock {
    /// A named zone, with its daylight-saving time.
    Zone(Tz),
    /// Minutes ahead of UTC.
    Offset(i32),
}

impl Clock {
    /// The local time of an instant.
    pub(super) fn local(self, instant: DateTime<Utc>) -> NaiveDateTime {
        match self {
            Self::Zone(zone) => instant.with_timezone(&zone).naive_local(),
            Self::Offset(minutes) => instant
                .naive_utc()
                .checked_add_signed(TimeDelta::minutes(i64::from(minutes)))
                .unwrap_or(NaiveDateTime::MAX),
        }
    }

    /// Whether the clock showed the local time of an instant before: it was set back in between.
    pub(super) fn shows_again(self, instant: DateTime<Utc>) -> bool {
        let Self::Zone(zone) = self else { return false };
        let local = instant.with_timezone(&zone);
        let instants = zone.from_local_datetime(&local.naive_local());
        matches!(instants, LocalResult::Ambiguous(first, _) if first != local)
    }
}

impl std::fmt::Display for Clock {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Zone(zone) => f.write_str(zone.name()),
            Self::Offset(minutes) => write!(f, "UTC {minutes:+} min"),
        }
    }
}

/// The zone of a name like `Europe/Madrid`, in either case: some sites write `ETC/GMT+5`.
pub(super) fn zone(name: &str) -> Option<Tz> {
    TZ_VARIANTS.iter().copied().find(|zone| zone.name().eq_ignore_ascii_case(name.trim()))
}

/// An instant as JSON files write it: `2024-03-01T07:00:00.000Z` or with another offset, which
/// xDrip writes without a colon (`+0100`); within the years 1900 to 2199.
pub(super) fn instant(text: &str) -> Option<DateTime<FixedOffset>> {
    let text = text.trim();
    let loose = || DateTime::parse_from_str(text, "%Y-%m-%dT%H:%M:%S%.f%z");
    let instant = DateTime::parse_from_rfc3339(text).or_else(|_| loose()).ok()?;
    // Chrono also reads years of more digits, whose local time it cannot hold.
    (1900..2200).contains(&instant.naive_utc().year()).then_some(instant)
}

/// The instant of milliseconds since 1970.
pub(super) fn from_millis(millis: f64) -> Option<DateTime<Utc>> {
    // The years 1900 to 2199, as for every record.
    let range = -2.3e12..7.3e12;
    range.contains(&millis).then(|| DateTime::from_timestamp_millis(millis as i64))?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zone_has_its_daylight_saving_time() {
        let madrid = Clock::Zone(zone("europe/madrid").expect("known"));
        let local = |text: &str| madrid.local(instant(text).expect("a time").to_utc()).to_string();
        assert_eq!(local("2024-03-31T00:59:00Z"), "2024-03-31 01:59:00");
        assert_eq!(local("2024-03-31T01:00:00Z"), "2024-03-31 03:00:00");
        assert_eq!(local("2024-10-27T02:30:00+02:00"), "2024-10-27 02:30:00");
        assert_eq!(local("2024-10-27T02:30:00+01:00"), "2024-10-27 02:30:00");
        let again = |text: &str| madrid.shows_again(instant(text).expect("a time").to_utc());
        assert!(again("2024-10-27T02:30:00+01:00") && !again("2024-10-27T02:30:00+02:00"));
        assert!(!again("2024-10-27T03:00:00+01:00") && !again("2024-10-27T01:59:00+02:00"));
        assert_eq!(local("2023-11-17T03:32:37.089+0100"), "2023-11-17 03:32:37.089");
        assert_eq!(zone("Mars/Olympus"), None);
        let at = from_millis(1_709_280_000_000.0).expect("a time");
        assert_eq!(Clock::Offset(-300).local(at).to_string(), "2024-03-01 03:00:00");
        assert_eq!(from_millis(1e300), None);
    }

    #[test]
    fn instants_lie_within_the_years_of_records() {
        for text in [
            "+262142-12-31T23:59:59.000+0000",
            "-262143-01-01T00:00:00.000+0000",
            "1899-12-31T23:59:59Z",
            "2200-01-01T00:00:00Z",
        ] {
            assert_eq!(instant(text), None, "{text}");
        }
        assert!(instant("1900-01-01T00:00:00Z").is_some());
        assert!(instant("2199-12-31T23:59:59Z").is_some());
    }
}
