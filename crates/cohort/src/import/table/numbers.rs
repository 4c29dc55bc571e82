//! Numbers as people's tables write them: with a decimal point or comma, and groups of thousands.

use crate::error::{CohortError, Place};

/// How the numbers of a file are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Numbers {
    /// `.` or `,`.
    pub(super) decimal: char,
    /// Between groups of three digits.
    thousands: Option<char>,
}

/// What the marks in the cells of a file show.
#[derive(Default)]
pub(super) struct Evidence {
    /// First cell in which the mark can only be decimal.
    point: Option<Place>,
    comma: Option<Place>,
    /// First cell with one comma before three digits.
    open: Option<(Place, String)>,
    /// First cell in which the mark can only group thousands.
    grouping_point: bool,
    grouping_comma: bool,
}

impl Evidence {
    /// Looks at a cell.
    pub(super) fn see(&mut self, text: &str, place: impl Fn() -> Place) {
        let numeral = |c: char| c.is_ascii_digit() || matches!(c, '.' | ',' | '-' | '+' | ' ');
        if !text.chars().all(numeral) {
            return;
        }
        let (points, commas) = (text.matches('.').count(), text.matches(',').count());
        match (points, commas) {
            (0, 0) => {}
            (1, 0) => {
                self.point.get_or_insert_with(place);
            }
            (_, 0) => self.grouping_point = true,
            (0, 1) => {
                let (whole, fraction) = text.split_once(',').unwrap_or((text, ""));
                let whole = whole.trim_start_matches(['-', '+', ' ']);
                let group = fraction.len() == 3 && whole.len() <= 3 && whole != "0";
                if group && !whole.is_empty() {
                    self.open.get_or_insert_with(|| (place(), text.to_owned()));
                } else {
                    self.comma.get_or_insert_with(place);
                }
            }
            (0, _) => self.grouping_comma = true,
            _ if text.rfind('.') > text.rfind(',') => {
                self.point.get_or_insert_with(place);
                self.grouping_comma = true;
            }
            _ => {
                self.comma.get_or_insert_with(place);
                self.grouping_point = true;
            }
        }
    }

    /// How the numbers are written; `told` is what the user says.
    pub(super) fn decide(self, told: Option<char>) -> Result<Numbers, CohortError> {
        const REMEDY: &str = "say --decimal . or --decimal ,";
        let with = |decimal, grouped: bool| Numbers {
            decimal,
            thousands: grouped.then_some(if decimal == '.' { ',' } else { '.' }),
        };
        if let Some(told) = told {
            return Ok(with(told, true));
        }
        match (self.point, self.comma) {
            // A point before three digits may group thousands; `1.234,5` says that it does.
            (Some(_), Some(_)) if self.grouping_point => Ok(with(',', true)),
            (Some(point), Some(comma)) => Err(CohortError::Undecided {
                reason: format!("a number with a decimal comma, where {point} has a point"),
                place: comma,
                remedy: REMEDY,
            }),
            (None, Some(_)) => Ok(with(',', self.grouping_point)),
            (Some(_), None) => Ok(with('.', self.grouping_comma || self.open.is_some())),
            (None, None) => match self.open {
                Some(_) if self.grouping_comma => Ok(with('.', true)),
                Some((place, text)) => Err(CohortError::Undecided {
                    place,
                    reason: format!("'{text}' may be a fraction or thousands"),
                    remedy: REMEDY,
                }),
                None if self.grouping_point => Ok(with(',', true)),
                None => Ok(with('.', self.grouping_comma)),
            },
        }
    }
}

impl Numbers {
    /// The finite number in a text; `None` for anything else.
    pub(super) fn parse(self, text: &str) -> Option<f64> {
        let blank = |c: &char| !matches!(c, ' ' | '\u{a0}' | '\u{202f}' | '\'');
        let text: String = text.chars().filter(blank).collect();
        let (whole, fraction) = match text.split_once(self.decimal) {
            Some((whole, fraction)) => (whole, Some(fraction)),
            None => (text.as_str(), None),
        };
        let mut digits = match self.thousands {
            Some(mark) if whole.contains(mark) => ungrouped(whole, mark)?,
            _ => whole.to_owned(),
        };
        if let Some(fraction) = fraction {
            digits.push('.');
            digits.push_str(fraction);
        }
        let plain = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | 'e' | 'E');
        if !digits.chars().all(plain) {
            return None;
        }
        digits.parse::<f64>().ok().filter(|value| value.is_finite())
    }
}

/// A whole number without the mark between its groups of three digits; `None` where groups are of another length.
fn ungrouped(whole: &str, mark: char) -> Option<String> {
    let (sign, number) = match whole.strip_prefix(['-', '+']) {
        Some(number) => (&whole[..1], number),
        None => ("", whole),
    };
    let digits = |group: &str| group.bytes().all(|byte| byte.is_ascii_digit());
    let first = number.split(mark).next().unwrap_or("");
    let right = (1..=3).contains(&first.len())
        && digits(first)
        && number.split(mark).skip(1).all(|group| group.len() == 3 && digits(group));
    right.then(|| format!("{sign}{}", number.replace(mark, "")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decide(cells: &[&str]) -> Result<Numbers, String> {
        let mut evidence = Evidence::default();
        for (i, cell) in cells.iter().enumerate() {
            evidence.see(cell, || Place::row("t.csv", i + 2));
        }
        evidence.decide(None).map_err(|error| error.to_string())
    }

    #[test]
    fn the_cells_of_a_file_show_its_marks() {
        for (cells, text, value) in [
            (&["5.6", "7"][..], "5.6", 5.6),
            (&["5,6", "7"], "7,25", 7.25),
            (&["1,234", "5.5"], "1,234", 1234.0),
            (&["1.234,5"], "2.345,75", 2345.75),
            (&["1.234,5", "1.234"], "1.234", 1234.0),
            (&["1,234,567"], "1,234", 1234.0),
            (&["0,125"], "0,125", 0.125),
            (&["120"], "1 200", 1200.0),
            (&["5,6", "1,234"], "1,234", 1.234),
        ] {
            let numbers = decide(cells).expect("decided");
            assert_eq!(numbers.parse(text), Some(value), "{cells:?}");
        }
    }

    #[test]
    fn a_mark_that_groups_no_three_digits_makes_no_number() {
        let told = |mark| Evidence::default().decide(Some(mark)).expect("told");
        for (mark, text, value) in [
            (',', "5,6", Some(5.6)),
            (',', "0.5", None),
            (',', "-1.234,5", Some(-1234.5)),
            (',', "1.2345", None),
            (',', "1.234.56", None),
            (',', "1,234.5", None),
            ('.', "0,5", None),
            ('.', ",500", None),
            ('.', "1,234,567.8", Some(1_234_567.8)),
        ] {
            assert_eq!(told(mark).parse(text), value, "{mark} {text}");
        }
    }

    #[test]
    fn two_readings_of_a_file_are_said() {
        let open = decide(&["1,234", "2,500"]).expect_err("both are possible");
        assert!(
            open.starts_with("t.csv, row 2: '1,234' may be a fraction or thousands;"),
            "{open}"
        );
        let both = decide(&["5.6", "5,61"]).expect_err("contradicts itself");
        assert!(both.contains("t.csv, row 3: a number with a decimal comma, where t.csv, row 2"));
    }

    #[test]
    fn formulas_and_words_are_no_numbers() {
        let numbers = decide(&["1.5"]).expect("decided");
        for text in ["=1+1", "1.5 U", "inf", "NaN", "1e999", "--", "0x10", "1.5.2", ""] {
            assert_eq!(numbers.parse(text), None, "{text}");
        }
    }
}
