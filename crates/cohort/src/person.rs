//! A cohort and its people.

use physiology::{BeatsPerMinute, Kilograms};

use crate::record::Record;

/// Weights that a cohort folder can hold, kg.
pub(crate) const WEIGHTS: std::ops::RangeInclusive<f64> = 1.0..=500.0;
/// Kilograms in a pound.
pub(crate) const KG_PER_LB: f64 = 0.453_592_37;

/// People observed in one study or made in one world.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cohort {
    /// The people, in the order of `people.csv`.
    pub people: Vec<Person>,
}

/// One person and the record of their days.
#[derive(Debug, Clone, PartialEq)]
pub struct Person {
    /// Unique within the cohort: letters, digits, `_`, `-` and `.`, starting with a letter or
    /// digit, because it also names files.
    pub id: String,
    /// Body weight; `None` if unknown.
    pub weight: Option<Kilograms>,
    /// How insulin is given, by the word in the column `therapy`.
    pub therapy: Therapy,
    /// Resting heart rate; `None` where it is estimated from the record
    /// ([`Person::resting_heart_rate`]), 0 where the record holds differences from the baseline.
    pub heart_rate_baseline: Option<BeatsPerMinute>,
    /// The five-minute record.
    pub record: Record,
}

named::named_in_json! {
    /// How insulin is given, by the word in the column `therapy`.
    #[derive(serde::Serialize)]
    Therapy {
        /// A pump that follows a programmed basal profile.
        OpenLoopPump: "open_loop_pump",
        /// Automated insulin delivery: the pump's rate reacts to the sensor.
        Aid: "aid",
        /// Multiple daily injections.
        Mdi: "mdi",
        /// Not stated by the source.
        Unknown: "unknown",
    }
}

impl Cohort {
    /// The index and the person with identifier `id`.
    #[must_use]
    pub fn find(&self, id: &str) -> Option<(usize, &Person)> {
        self.people.iter().enumerate().find(|(_, person)| person.id == id)
    }
}

/// What a cell must hold that names a person.
pub(crate) const ID_EXPECTED: &str = "a person's identifier; use letters, digits, '_', '-' and '.'";

/// Whether `id` may name a person (and their files).
pub(crate) fn is_person_id(id: &str) -> bool {
    id.len() <= 64
        && id.starts_with(|c: char| c.is_ascii_alphanumeric())
        && id.chars().all(is_id_letter)
}

fn is_id_letter(c: char) -> bool {
    c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.')
}

/// A name in the letters of an identifier.
pub(crate) fn with_id_letters(name: &str) -> String {
    name.chars().map(|c| if is_id_letter(c) { c } else { '_' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn therapies_are_read_as_they_are_written() {
        for therapy in Therapy::ALL {
            assert_eq!(Therapy::from_name(therapy.name()), Some(therapy));
        }
        assert_eq!(Therapy::from_name("Pump"), None);
    }

    #[test]
    fn identifiers_cannot_leave_a_folder_or_start_a_formula() {
        for good in ["2301", "HUPA0002P", "world-3_a.1"] {
            assert!(is_person_id(good), "{good}");
        }
        for bad in ["", "../x", ".x", "=1+1", "-2", "a/b", "a b", "x\u{0}"] {
            assert!(!is_person_id(bad), "{bad:?}");
        }
    }
}
