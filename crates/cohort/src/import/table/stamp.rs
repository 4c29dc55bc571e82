//! Times as people's tables write them.
//!
//! `2024-03-01 08:05`, `01/03/2024 8:05 PM`, `13-Jun-2018 22:45:10`, an offset or `Z` behind it,
//! seconds or milliseconds since 1970, days since 1900 as Excel counts them.

use chrono::{DateTime, NaiveDate, NaiveDateTime, NaiveTime, TimeDelta};

/// Order of day and month where the year does not come first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DateOrder {
    /// 31/12/2024.
    DayFirst,
    /// 12/31/2024.
    MonthFirst,
}

impl DateOrder {
    /// The word on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::DayFirst => "day-first",
            Self::MonthFirst => "month-first",
        }
    }
}

/// A time as written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stamp {
    /// Date and time of day as written; midnight where only a date is written.
    pub(super) written: NaiveDateTime,
    /// Seconds ahead of UTC, where the text says so.
    pub(super) offset: Option<i32>,
    /// Whether there is a time of day.
    pub(super) timed: bool,
}

/// The date in a text, its numbers not yet ordered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Written {
    /// Year, month and day are certain.
    Certain(i32, u32, u32),
    /// Two numbers of which one is the day, and the year.
    Open(u32, u32, i32),
}

impl Stamp {
    /// Reads a text; `order` is used where the numbers alone do not tell day from month.
    pub(super) fn parse(text: &str, order: DateOrder) -> Option<Self> {
        let text = text.trim();
        if let Some(stamp) = counted(text) {
            return Some(stamp);
        }
        let (written, rest) = date(text)?;
        let date = match (written, order) {
            (Written::Certain(year, month, day), _) => NaiveDate::from_ymd_opt(year, month, day),
            (Written::Open(day, month, year), DateOrder::DayFirst)
            | (Written::Open(month, day, year), DateOrder::MonthFirst) => {
                NaiveDate::from_ymd_opt(year, month, day)
            }
        }?;
        let rest = rest.trim_start_matches(['T', 't', ',', ' ', '\u{a0}']);
        if rest.is_empty() {
            let written = date.and_time(NaiveTime::MIN);
            return Some(Self { written, offset: None, timed: false });
        }
        let (time, offset) = clock(rest)?;
        Some(Self { written: date.and_time(time), offset, timed: true })
    }

    /// The numbers of a date whose order is open; `None` where it is certain or no date.
    pub(super) fn open(text: &str) -> Option<(u32, u32, i32)> {
        match date(text.trim())?.0 {
            Written::Open(first, second, year) => Some((first, second, year)),
            Written::Certain(..) => None,
        }
    }
}

/// Seconds or milliseconds since 1970 (UTC), or days since 1900 (local, as Excel counts).
fn counted(text: &str) -> Option<Stamp> {
    if !text.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.') {
        return None;
    }
    let whole = text.split('.').next().unwrap_or("").len();
    if text.matches('.').count() > 1 {
        return None;
    }
    let value: f64 = text.parse().ok()?;
    let instant = match whole {
        9..=10 => DateTime::from_timestamp_millis((value * 1e3).round() as i64)?,
        12..=13 => DateTime::from_timestamp_millis(value.round() as i64)?,
        5 if (20_000.0..80_000.0).contains(&value) => {
            let seconds = TimeDelta::seconds((value * 86_400.0).round() as i64);
            let written = NaiveDate::from_ymd_opt(1899, 12, 30)?.and_time(NaiveTime::MIN) + seconds;
            return Some(Stamp { written, offset: None, timed: text.contains('.') });
        }
        _ => return None,
    };
    Some(Stamp { written: instant.naive_utc(), offset: Some(0), timed: true })
}

/// The date at the beginning of a text, and what follows.
fn date(text: &str) -> Option<(Written, &str)> {
    let (first, rest) = part(text)?;
    let (second, rest) = part(rest.trim_start_matches(SEPARATORS))?;
    let (third, rest) = part(rest.trim_start_matches(SEPARATORS))?;
    // Neither a longer number nor a word may follow.
    if rest.starts_with(|c: char| c.is_alphanumeric() && !matches!(c, 'T' | 't')) {
        return None;
    }
    let written = match (first, second, third) {
        (Part::Number(year, 4), Part::Number(month, 1..=2), Part::Number(day, 1..=2)) => {
            Written::Certain(year as i32, month, day)
        }
        (Part::Number(day, 1..=2), Part::Month(month), Part::Number(year, digits @ (2 | 4)))
        | (Part::Month(month), Part::Number(day, 1..=2), Part::Number(year, digits @ (2 | 4))) => {
            Written::Certain(full_year(year, digits), month, day)
        }
        (
            Part::Number(first, 1..=2),
            Part::Number(second, 1..=2),
            Part::Number(year, digits @ (2 | 4)),
        ) => Written::Open(first, second, full_year(year, digits)),
        _ => return None,
    };
    Some((written, rest))
}

const SEPARATORS: [char; 5] = ['/', '-', '.', ' ', ','];

fn full_year(year: u32, digits: usize) -> i32 {
    let century = if digits == 2 { 2000 } else { 0 };
    year as i32 + century
}

#[derive(Clone, Copy)]
enum Part {
    /// A number and its count of digits.
    Number(u32, usize),
    Month(u32),
}

/// A number of up to four digits, or the name of a month.
fn part(text: &str) -> Option<(Part, &str)> {
    let digits = text.bytes().take_while(u8::is_ascii_digit).count();
    if (1..=4).contains(&digits) {
        return Some((Part::Number(text[..digits].parse().ok()?, digits), &text[digits..]));
    }
    const MONTHS: [&str; 12] =
        ["jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"];
    let letters = text.bytes().take_while(u8::is_ascii_alphabetic).count();
    let name = text.get(..letters)?.to_ascii_lowercase();
    let month = MONTHS.iter().position(|month| name.len() >= 3 && name.starts_with(month))?;
    Some((Part::Month(month as u32 + 1), &text[letters..]))
}

/// A time of day, and its seconds ahead of UTC.
fn clock(text: &str) -> Option<(NaiveTime, Option<i32>)> {
    let (hour, rest) = number(text)?;
    let (minute, rest) = number(rest.strip_prefix([':', '.', 'h'])?)?;
    let (second, mut rest) = match rest.strip_prefix([':', '.']) {
        Some(rest) => number(rest)?,
        None => (0, rest),
    };
    if let Some(fraction) = rest.strip_prefix(['.', ',']) {
        rest = fraction.trim_start_matches(|c: char| c.is_ascii_digit());
    }
    let word: String = rest
        .chars()
        .filter(|c| !matches!(c, '.' | ' ' | '\u{a0}' | '\u{202f}'))
        .flat_map(char::to_lowercase)
        .collect();
    let (hour, word) = match (word.strip_prefix("am"), word.strip_prefix("pm")) {
        (Some(word), _) if (1..=12).contains(&hour) => (hour % 12, word),
        (_, Some(word)) if (1..=12).contains(&hour) => (hour % 12 + 12, word),
        (None, None) => (hour, word.as_str()),
        _ => return None,
    };
    let time = NaiveTime::from_hms_opt(hour, minute, second)?;
    Some((time, offset(word)?))
}

/// `Z`, `UTC`, `GMT`, `+02:00`, `-0500`, `+02`; `Some(None)` for nothing, `None` for anything else.
fn offset(word: &str) -> Option<Option<i32>> {
    let zone = word.strip_prefix("utc").or_else(|| word.strip_prefix("gmt"));
    let word = zone.unwrap_or(word);
    let sign = match word.chars().next() {
        None => return Some(zone.map(|_| 0)),
        Some('z') if word.len() == 1 => return Some(Some(0)),
        Some('+') => 1,
        Some('-' | '\u{2212}') => -1,
        Some(_) => return None,
    };
    let digits: String = word.chars().skip(1).filter(|c| *c != ':').collect();
    if !digits.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let (hours, minutes) = match digits.len() {
        1 | 2 => (digits.parse::<i32>().ok()?, 0),
        4 => (digits[..2].parse().ok()?, digits[2..].parse().ok()?),
        _ => return None,
    };
    (hours <= 14 && minutes < 60).then_some(Some(sign * (hours * 3600 + minutes * 60)))
}

/// One or two digits.
fn number(text: &str) -> Option<(u32, &str)> {
    let digits = text.bytes().take_while(u8::is_ascii_digit).count();
    if !(1..=2).contains(&digits) {
        return None;
    }
    Some((text[..digits].parse().ok()?, &text[digits..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_ways_to_write_one_time() {
        for text in [
            "2024-03-01 08:05",
            "2024-03-01T08:05:00",
            "2024/3/1 8:05:00.250",
            "01/03/2024 08:05",
            "1.3.2024 08:05",
            "01-03-24 8:05 AM",
            "01/03/2024, 8:05 a. m.",
            "1-Mar-2024 08:05",
            "March 1, 2024 8:05 am",
            "45352.336805555555",
        ] {
            let stamp = Stamp::parse(text, DateOrder::DayFirst).unwrap_or_else(|| panic!("{text}"));
            assert_eq!(stamp.written.to_string(), "2024-03-01 08:05:00", "{text}");
            assert_eq!((stamp.offset, stamp.timed), (None, true), "{text}");
        }
        let month_first = Stamp::parse("03/01/2024 12:05 AM", DateOrder::MonthFirst);
        assert_eq!(month_first.expect("a time").written.to_string(), "2024-03-01 00:05:00");
    }

    #[test]
    fn offsets_and_instants_are_kept_apart_from_the_clock() {
        for (text, offset) in [
            ("2024-03-01T08:05:00Z", 0),
            ("2024-03-01 08:05:00 UTC", 0),
            ("2024-03-01T08:05:00+02:00", 7200),
            ("2024-03-01T08:05:00.000-0530", -19_800),
            ("1709280300", 0),
            ("1709280300000", 0),
        ] {
            let stamp = Stamp::parse(text, DateOrder::DayFirst).unwrap_or_else(|| panic!("{text}"));
            assert_eq!(stamp.written.to_string(), "2024-03-01 08:05:00", "{text}");
            assert_eq!(stamp.offset, Some(offset), "{text}");
        }
    }

    #[test]
    fn what_is_no_time_is_none() {
        for text in [
            "",
            "7.1",
            "120",
            "08:05",
            "2024-13-01 08:05",
            "31/02/2024 08:05",
            "1/2/3/4",
            "hello",
            "2024-03-01 25:00",
            "2024-03-01 08:05 XM",
            "2024-03-01 13:05 PM",
            "é1/03/2024",
            "01/03/2024x08:05",
            "=NOW()",
            "99999999999999999999",
        ] {
            assert_eq!(Stamp::parse(text, DateOrder::DayFirst), None, "{text}");
        }
        let day = Stamp::parse("01/03/2024", DateOrder::DayFirst).expect("a date");
        assert!(!day.timed);
        assert_eq!(Stamp::open("13/06/2018 22:45"), Some((13, 6, 2018)));
        assert_eq!(Stamp::open("2018-06-13 22:45"), None);
    }
}
