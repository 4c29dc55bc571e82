//! Units of a column, and how they become those of the record.

use physiology::MG_PER_DL_PER_MMOL_PER_L;

use super::options::{Role, TableOptions};
use crate::error::{CohortError, shorten};
use crate::near_name::plain;
use crate::range::MMOL_MEDIAN;

/// The unit of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Unit {
    /// The record's unit, times a factor.
    Times(f64),
    /// An amount of insulin, U, over a number of minutes that is known or to be found out.
    PerMinutes(Option<f64>),
    /// Not said: found out by the column's name and values.
    Open,
}

impl Unit {
    /// The unit that the options say of a role.
    pub(super) fn of(role: Role, options: &TableOptions) -> Result<Self, CohortError> {
        let Some(text) = options.unit(role) else {
            return Ok(match role {
                Role::Glucose | Role::Sleep => Self::Open,
                _ => Self::Times(1.0),
            });
        };
        let word: String =
            text.chars().filter(|c| *c != ' ').flat_map(char::to_lowercase).collect();
        let unit = match (role, word.as_str()) {
            (Role::Glucose, "mg/dl") => Some(Self::Times(1.0)),
            (Role::Glucose, "mmol/l") => Some(Self::Times(MG_PER_DL_PER_MMOL_PER_L)),
            (Role::Basal, "u/h" | "u/hr" | "iu/h") => Some(Self::Times(1.0)),
            (Role::Basal, "u/min") => Some(Self::Times(60.0)),
            (Role::Basal, "u/day" | "u/d") => Some(Self::Times(1.0 / 24.0)),
            (Role::Basal, "u") => Some(Self::PerMinutes(None)),
            (Role::Basal, word) => word
                .strip_prefix("u/")
                .and_then(|rest| rest.strip_suffix("min"))
                .and_then(|minutes| minutes.parse::<f64>().ok())
                .filter(|minutes| (0.5..=1440.0).contains(minutes))
                .map(|minutes| Self::PerMinutes(Some(minutes))),
            (Role::Bolus | Role::LongActing, "u" | "iu") => Some(Self::Times(1.0)),
            (Role::Bolus | Role::LongActing, "mu") => Some(Self::Times(0.001)),
            // Servings: "10 g" says what one of them holds.
            (Role::Carbs, word) => word.strip_suffix('g').and_then(|count| match count {
                "" => Some(Self::Times(1.0)),
                count => count
                    .parse::<f64>()
                    .ok()
                    .filter(|grams| (0.1..=100.0).contains(grams))
                    .map(Self::Times),
            }),
            (Role::HeartRate, "1/min" | "bpm") => Some(Self::Times(1.0)),
            (Role::Steps, "count" | "steps") => Some(Self::Times(1.0)),
            (Role::Sleep, "%") => Some(Self::Times(0.01)),
            (Role::Sleep, "share" | "1") => Some(Self::Times(1.0)),
            _ => None,
        };
        unit.ok_or_else(|| {
            let option = format!("--unit {}={}", role.name(), shorten(text, 40));
            let reason = format!("not a unit of {}; write {}", role.name(), known(role));
            CohortError::option(option, reason)
        })
    }
}

const fn known(role: Role) -> &'static str {
    match role {
        Role::Glucose => "mg/dL or mmol/L",
        Role::Basal => "U/h, U/min, U/day, or an amount: U/5min, U/15min, U",
        Role::Bolus | Role::LongActing => "U or mU",
        Role::Carbs => "g, or what one serving holds: 10 g",
        Role::HeartRate => "1/min",
        Role::Steps => "count",
        Role::Sleep => "share or %",
        Role::Person | Role::Time | Role::Date | Role::Clock | Role::SetChange => {
            "none: it has no unit"
        }
    }
}

/// The unit of glucose that a column's name states.
pub(super) fn glucose_unit_in(name: &str) -> Option<&'static str> {
    let name = plain(name);
    if name.contains("mmol") {
        Some("mmol/L")
    } else if name.contains("mgdl") || name.contains("mgperdl") {
        Some("mg/dL")
    } else {
        None
    }
}

/// The unit of glucose that values have, by their median.
pub(super) fn glucose_unit_of(median: f64) -> &'static str {
    if median < MMOL_MEDIAN { "mmol/L" } else { "mg/dL" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_those_of_their_role() {
        let unit = |text: &str| {
            let mut options = TableOptions::default();
            options.add_unit(text).expect("a role");
            Unit::of(options.units[0].0, &options)
        };
        for (text, expected) in [
            ("glucose=mmol/L", Unit::Times(18.0)),
            ("basal=U/h", Unit::Times(1.0)),
            ("basal=U/5min", Unit::PerMinutes(Some(5.0))),
            ("basal=U", Unit::PerMinutes(None)),
            ("carbs=10 g", Unit::Times(10.0)),
            ("carbs=g", Unit::Times(1.0)),
            ("sleep=%", Unit::Times(0.01)),
        ] {
            assert_eq!(unit(text).ok(), Some(expected), "{text}");
        }
        for (text, says) in [
            ("glucose=g/L", "--unit glucose=g/L: not a unit of glucose; write mg/dL or mmol/L"),
            ("carbs=oz", "write g, or what one serving holds: 10 g"),
            ("carbs=1e9 g", "not a unit of carbs"),
            ("time=h", "it has no unit"),
        ] {
            let error = unit(text).expect_err("refused").to_string();
            assert!(error.contains(says), "{error}");
        }
    }
}
