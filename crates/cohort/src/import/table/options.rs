//! What a user says about a table: which column is what, in which unit, on which clock.

use std::collections::BTreeMap;

use super::stamp::DateOrder;
use crate::error::{CohortError, shorten};
use crate::near_name::near;
use crate::record::Channel;

named::named_in_json! {
    /// What a column of a foreign table holds, by the word in a map.
    #[derive(serde::Serialize)]
    Role {
        /// The person's identifier.
        Person: "person",
        /// Date and time of day.
        Time: "time",
        /// The date alone; the time of day is in [`Role::Clock`].
        Date: "date",
        /// The time of day alone.
        Clock: "clock",
        /// Sensor glucose.
        Glucose: "glucose",
        /// Basal insulin of a pump.
        Basal: "basal",
        /// Bolus insulin.
        Bolus: "bolus",
        /// Injections of long-acting insulin, which no basal rate describes.
        LongActing: "long_acting",
        /// Carbohydrate.
        Carbs: "carbs",
        /// Heart rate.
        HeartRate: "heart_rate",
        /// Steps walked.
        Steps: "steps",
        /// Share of the time asleep.
        Sleep: "sleep",
        /// Changes of the infusion set.
        SetChange: "set_change",
    }
}

impl Role {
    /// The channel whose values the column holds.
    pub(super) const fn channel(self) -> Option<Channel> {
        match self {
            Self::Person | Self::Time | Self::Date | Self::Clock => None,
            Self::Glucose => Some(Channel::Cgm),
            Self::Basal => Some(Channel::Basal),
            Self::Bolus | Self::LongActing => Some(Channel::Bolus),
            Self::Carbs => Some(Channel::Carbs),
            Self::HeartRate => Some(Channel::HeartRate),
            Self::Steps => Some(Channel::Steps),
            Self::Sleep => Some(Channel::SleepEfficiency),
            Self::SetChange => Some(Channel::SetChange),
        }
    }

    fn of(word: &str, option: &str) -> Result<Self, CohortError> {
        let word = word.trim();
        if let Some(role) = Self::from_name(word) {
            return Ok(role);
        }
        let words = Self::ALL.map(Self::name);
        let hint = near(word, words).map_or_else(
            || format!("write one of {}", words.join(", ")),
            |near| format!("did you mean '{near}'?"),
        );
        let word = shorten(word, 40);
        Err(CohortError::option(option, format!("'{word}' is not what a column can hold: {hint}")))
    }
}

/// Rows of a role: those in which `column` holds one of `values`.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Only {
    /// The role.
    pub role: Role,
    /// The column that decides.
    pub column: String,
    /// Its texts.
    pub values: Vec<String>,
}

/// What a user says about foreign tables.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize)]
pub struct TableOptions {
    /// Columns by role, `COLUMN` or `FILE:COLUMN`. Of several for a role, each file has its own.
    pub columns: Vec<(Role, String)>,
    /// Units by role, where they are not the record's own.
    pub units: Vec<(Role, String)>,
    /// Rows by role, where not every row counts.
    pub only: Vec<Only>,
    /// Time zone in which the people lived, like `Europe/Madrid`.
    pub zone: Option<String>,
    /// Times without an offset are UTC.
    pub utc: bool,
    /// Order of day and month, where the file leaves it open.
    pub dates: Option<DateOrder>,
    /// The decimal mark, where the file leaves it open.
    pub decimal: Option<char>,
    /// The sheet of an Excel workbook; without it the first that is seen.
    pub sheet: Option<String>,
}

/// The TOML form of the options.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    #[serde(default)]
    map: BTreeMap<String, OneOrMore>,
    #[serde(default)]
    unit: BTreeMap<String, String>,
    #[serde(default)]
    only: BTreeMap<String, BTreeMap<String, OneOrMore>>,
    zone: Option<String>,
    #[serde(default)]
    utc: bool,
    dates: Option<DateOrder>,
    decimal: Option<char>,
    sheet: Option<String>,
}

#[derive(serde::Deserialize)]
#[serde(untagged)]
enum OneOrMore {
    One(String),
    More(Vec<String>),
}

impl OneOrMore {
    fn into_vec(self) -> Vec<String> {
        match self {
            Self::One(text) => vec![text],
            Self::More(texts) => texts,
        }
    }
}

impl TableOptions {
    /// The options in a TOML file: tables `map`, `unit` and `only`, keys `zone`, `utc`, `dates`,
    /// `decimal` and `sheet`.
    ///
    /// # Errors
    /// If it is not TOML or has an unknown key.
    pub fn from_toml(text: &str, file: &str) -> Result<Self, CohortError> {
        let settings: Settings = toml::from_str(text)
            .map_err(|error| CohortError::option(file, error.to_string().trim_end()))?;
        let mut options = Self {
            zone: settings.zone,
            utc: settings.utc,
            dates: settings.dates,
            decimal: settings.decimal,
            sheet: settings.sheet,
            ..Self::default()
        };
        for (word, columns) in settings.map {
            let role = Role::of(&word, file)?;
            options.columns.extend(columns.into_vec().into_iter().map(|column| (role, column)));
        }
        for (word, unit) in settings.unit {
            options.units.push((Role::of(&word, file)?, unit));
        }
        for (word, rows) in settings.only {
            let role = Role::of(&word, file)?;
            options.only.extend(rows.into_iter().map(|(column, values)| Only {
                role,
                column,
                values: values.into_vec(),
            }));
        }
        options.check_decimal(file)?;
        Ok(options)
    }

    /// Adds `ROLE=COLUMN,ROLE=COLUMN,...`. A comma ends a column only where a role follows it.
    ///
    /// # Errors
    /// If there is no such role, or no column behind it.
    pub fn add_map(&mut self, text: &str) -> Result<(), CohortError> {
        pairs(text, "--map").map(|pairs| self.columns.extend(pairs))
    }

    /// Adds `ROLE=UNIT,...`.
    ///
    /// # Errors
    /// As [`TableOptions::add_map`].
    pub fn add_unit(&mut self, text: &str) -> Result<(), CohortError> {
        pairs(text, "--unit").map(|pairs| self.units.extend(pairs))
    }

    /// Refuses a map for a format whose columns are known.
    pub(in crate::import) fn refuse_columns(&self, format: &str) -> Result<(), CohortError> {
        if self.columns.is_empty() && self.only.is_empty() {
            return Ok(());
        }
        let reason =
            format!("the columns of {format} are known; leave it out, or use --from table");
        Err(CohortError::option("--map", reason))
    }

    /// Whether nothing is said.
    #[must_use]
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    pub(super) fn check_decimal(&self, option: &str) -> Result<(), CohortError> {
        match self.decimal {
            None | Some('.' | ',') => Ok(()),
            Some(mark) => {
                let reason = format!("decimal mark '{mark}' is neither . nor ,");
                Err(CohortError::option(option, reason))
            }
        }
    }

    /// The unit of a role; the last one said counts.
    pub(in crate::import) fn unit(&self, role: Role) -> Option<&str> {
        self.units.iter().rev().find(|(of, _)| *of == role).map(|(_, unit)| unit.as_str())
    }
}

pub(super) fn pairs(text: &str, option: &str) -> Result<Vec<(Role, String)>, CohortError> {
    let mut parts: Vec<String> = Vec::new();
    for part in text.split(',') {
        let begins = part.split_once('=').is_some_and(|(word, _)| {
            let word = word.trim();
            !word.is_empty() && word.chars().all(|c| c.is_ascii_lowercase() || c == '_')
        });
        match parts.last_mut() {
            Some(last) if !begins => {
                last.push(',');
                last.push_str(part);
            }
            _ => parts.push(part.to_owned()),
        }
    }
    parts
        .iter()
        .map(|part| {
            let (word, column) = part.split_once('=').unwrap_or((part, ""));
            let role = Role::of(word, option)?;
            if column.trim().is_empty() {
                let reason = format!("nothing behind '{}='", role.name());
                return Err(CohortError::option(option, reason));
            }
            Ok((role, column.trim().to_owned()))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_are_read_from_a_line_and_from_toml_alike() {
        let mut line = TableOptions::default();
        line.add_map("glucose=Glucose, mg/dL,time=a.csv:Date (d/m, h:m),bolus=Dose").expect("good");
        line.add_unit("glucose=mmol/L").expect("good");
        assert_eq!(line.columns[0], (Role::Glucose, "Glucose, mg/dL".into()));
        assert_eq!(line.columns[1], (Role::Time, "a.csv:Date (d/m, h:m)".into()));
        assert_eq!(line.unit(Role::Glucose), Some("mmol/L"));
        let toml = TableOptions::from_toml(
            "zone = 'Europe/Madrid'\ndates = 'day-first'\n[map]\ntime = ['a', 'b']\n\
             glucose = 'Glucose, mg/dL'\n[unit]\nglucose = 'mmol/L'\n[only.glucose]\nType = 'EGV'\n",
            "map.toml",
        )
        .expect("good");
        assert_eq!(toml.columns.len(), 3);
        assert_eq!(toml.dates, Some(DateOrder::DayFirst));
        assert_eq!(toml.only[0].values, ["EGV"]);
    }

    #[test]
    fn what_cannot_be_meant_is_said() {
        let add =
            |text: &str| TableOptions::default().add_map(text).expect_err("wrong").to_string();
        assert_eq!(
            add("glucos=x"),
            "--map: 'glucos' is not what a column can hold: did you mean 'glucose'?"
        );
        assert!(add("insulin=x").contains("write one of person, time"), "{}", add("insulin=x"));
        assert_eq!(add("glucose="), "--map: nothing behind 'glucose='");
        for (text, says) in [
            ("[map\n", "map.toml: "),
            ("zon = 'x'\n", "unknown field `zon`"),
            ("decimal = ';'\n", "decimal mark ';' is neither"),
            ("dates = 'first'\n", "day-first"),
        ] {
            let error = TableOptions::from_toml(text, "map.toml").expect_err("wrong").to_string();
            assert!(error.contains(says), "{error}");
        }
    }
}
