//! Local times as files write them.

use chrono::{NaiveDate, NaiveDateTime};

/// Reads `YYYY-MM-DDTHH:MM:SS`, and nothing else.
pub(crate) fn parse_iso(text: &str) -> Option<NaiveDateTime> {
    let date = NaiveDate::from_ymd_opt(
        i32::try_from(digits(text, b"dddd-dd-ddTdd:dd:dd", 0..4)?).ok()?,
        number(text, 5..7)?,
        number(text, 8..10)?,
    )?;
    date.and_hms_opt(number(text, 11..13)?, number(text, 14..16)?, number(text, 17..19)?)
}

/// The same at the start of a text, also with a blank for the `T`.
pub(crate) fn parse_iso_start(text: &str) -> Option<NaiveDateTime> {
    parse_iso(&text.get(..19)?.replace(' ', "T"))
}

/// Reads `DD/MM/YYYY`, and nothing else.
pub(crate) fn parse_day_first_date(text: &str) -> Option<NaiveDate> {
    let day = digits(text, b"dd/dd/dddd", 0..2)?;
    let year = i32::try_from(number(text, 6..10)?).ok()?;
    NaiveDate::from_ymd_opt(year, number(text, 3..5)?, day)
}

/// Reads `DD/MM/YYYY HH:MM`, and nothing else.
pub(crate) fn parse_day_first(text: &str) -> Option<NaiveDateTime> {
    digits(text, b"dd/dd/dddd dd:dd", 0..2)?;
    let date = parse_day_first_date(&text[..10])?;
    date.and_hms_opt(number(text, 11..13)?, number(text, 14..16)?, 0)
}

/// The number at `range` if the text has the shape, in which `d` stands for a digit.
fn digits(text: &str, shape: &[u8], range: std::ops::Range<usize>) -> Option<u32> {
    let fits = text.len() == shape.len()
        && text.bytes().zip(shape).all(|(byte, mark)| match mark {
            b'd' => byte.is_ascii_digit(),
            mark => byte == *mark,
        });
    if fits { number(text, range) } else { None }
}

fn number(text: &str, range: std::ops::Range<usize>) -> Option<u32> {
    text.get(range)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_documented_shapes_are_times() {
        let shown = |time: Option<NaiveDateTime>| time.map(|time| time.to_string());
        let expected = Some("2024-03-01 08:05:00".to_owned());
        assert_eq!(shown(parse_iso("2024-03-01T08:05:00")), expected);
        assert_eq!(shown(parse_day_first("01/03/2024 08:05")), expected);
        for bad in [
            "2024-03-01 08:05:00",
            "2024-03-01T08:05:00Z",
            "2024-13-01T08:05:00",
            "2024é03-01T08:05:0",
        ] {
            assert_eq!(parse_iso(bad), None, "{bad}");
        }
        for bad in ["1/3/2024 08:05", "31/02/2024 08:05", "01/03/2024", "01/03/2024 24:00"] {
            assert_eq!(parse_day_first(bad), None, "{bad}");
        }
    }
}
