//! Numbers as text: fixed digits, a true minus sign, and never "NaN".

use contract::blind_check::Share;
use contract::{Spread, WithInterval};

/// The text where there is no number.
pub(crate) const ABSENT: &str = "\u{2013}";

/// `value` with `digits` after the point.
pub(crate) fn fixed(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return ABSENT.to_owned();
    }
    let text = format!("{:.digits$}", value.abs());
    // "-0.0" says no more than "0.0".
    let is_zero = text.bytes().all(|b| b == b'0' || b == b'.');
    if value < 0.0 && !is_zero { format!("\u{2212}{text}") } else { text }
}

/// `value` with `digits` after the point, or a dash.
pub(crate) fn optional(value: impl Into<Option<f64>>, digits: usize) -> String {
    value.into().map_or_else(|| ABSENT.to_owned(), |value| fixed(value, digits))
}

/// A small number with three significant digits, in powers of ten where that is shorter.
pub(crate) fn significant(value: impl Into<Option<f64>>) -> String {
    let value = value.into().unwrap_or(f64::NAN);
    let exponent = value.abs().log10().floor() as i32;
    match value.abs() {
        0.0 => "0".to_owned(),
        1e-3..1e4 => fixed(value, (2 - exponent).clamp(0, 5) as usize),
        size if size.is_finite() => {
            let mantissa = fixed(value / 10_f64.powi(exponent), 2);
            format!("{mantissa}e{exponent}").replace("e-", "e\u{2212}")
        }
        _ => ABSENT.to_owned(),
    }
}

/// A number with at most three digits after the point and no trailing zeros.
pub(crate) fn compact(value: f64) -> String {
    fixed(value, 3).trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A share or probability as a percentage, or a dash; never 0 or 100 where it only rounds to that.
pub(crate) fn percent(share: impl Into<Option<f64>>) -> String {
    let size = 100.0 * share.into().unwrap_or(f64::NAN);
    match fixed(size, 0).as_str() {
        ABSENT => ABSENT.to_owned(),
        "0" if size > 0.0 => "<1\u{a0}%".to_owned(),
        "100" if size < 100.0 => ">99\u{a0}%".to_owned(),
        text => format!("{text}\u{a0}%"),
    }
}

/// A counted share with its interval: `12 of 20: 60 % (36 to 81)`.
pub(crate) fn share(share: &Share) -> String {
    let Share { count, of, .. } = share;
    let Some(value) = share.value else { return format!("{count} of {of}") };
    let ends = ends(100.0 * share.lower, 100.0 * share.upper, 0);
    format!("{count} of {of}: {}{ends}", percent(value))
}

/// A p-value as papers print it.
pub(crate) fn p_value(p: f64) -> String {
    if p.is_finite() && p < 0.001 { "<0.001".to_owned() } else { fixed(p, 3) }
}

/// Mean and SD.
pub(crate) fn spread(spread: Spread, digits: usize) -> String {
    format!("{} \u{b1} {}", fixed(spread.mean, digits), fixed(spread.sd, digits))
}

/// Estimate and interval.
pub(crate) fn interval(x: WithInterval, digits: usize) -> String {
    format!("{}{}", fixed(x.value, digits), ends(x.lower, x.upper, digits))
}

/// The ends of an interval behind its estimate: ` (36 to 81)`.
pub(crate) fn ends(lower: f64, upper: f64, digits: usize) -> String {
    format!(" ({} to {})", fixed(lower, digits), fixed(upper, digits))
}

/// Minutes since midnight as `HH:MM`.
pub(crate) fn clock(minutes: f64) -> String {
    // Whole minutes first: hours and minutes that are rounded apart can read 01:60.
    let minutes = minutes.round() as u32;
    format!("{:02}:{:02}", minutes / 60, minutes % 60)
}

/// A count with its noun: `1 person`, `3 people`.
#[must_use]
pub fn count(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_as_numbers() {
        let counted = |count: usize, of: usize, value: Option<f64>| Share {
            count,
            of,
            value,
            lower: 0.36,
            upper: 0.81,
            wilson_lower: 0.39,
            wilson_upper: 0.78,
        };
        assert_eq!(share(&counted(12, 20, Some(0.6))), "12 of 20: 60\u{a0}% (36 to 81)");
        for (text, expected) in [
            (fixed(-1.25, 1), "\u{2212}1.2"),
            (fixed(-0.04, 1), "0.0"),
            (fixed(f64::NAN, 1), ABSENT),
            (optional(None, 2), ABSENT),
            (significant(Some(0.0236161)), "0.0236"),
            (significant(Some(-0.0108953)), "\u{2212}0.0109"),
            (significant(Some(1.715e-4)), "1.71e\u{2212}4"),
            (significant(Some(0.0)), "0"),
            (significant(Some(123.4)), "123"),
            (compact(12.5), "12.5"),
            (compact(120.0), "120"),
            (p_value(0.0004), "<0.001"),
            (p_value(0.0123), "0.012"),
            (ends(-0.5, 2.0, 1), " (\u{2212}0.5 to 2.0)"),
            (clock(119.999), "02:00"),
            (clock(735.0), "12:15"),
            (clock(1440.0), "24:00"),
            (count(1, "person", "people"), "1 person"),
            (percent(0.973), "97\u{a0}%"),
            (percent(0.0), "0\u{a0}%"),
            (percent(0.001), "<1\u{a0}%"),
            (percent(0.999), ">99\u{a0}%"),
            (percent(1.0), "100\u{a0}%"),
            (share(&counted(0, 0, None)), "0 of 0"),
        ] {
            assert_eq!(text, expected);
        }
    }
}
