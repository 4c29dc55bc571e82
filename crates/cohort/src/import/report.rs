//! The account of an import.

use crate::error::Place;
use crate::mass_balance::MassBalance;
use crate::person::{Cohort, Person, Therapy};
use crate::plausibility::{Finding, findings};

/// Everything that a reader must know to trust an imported cohort.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ImportReport {
    /// Name of the format.
    pub format: &'static str,
    /// What "per day" means in `people`.
    pub days_are: &'static str,
    /// One entry per person, in the cohort's order.
    pub people: Vec<PersonImport>,
    /// Units and meanings that were inferred, with the evidence.
    pub inferences: Vec<Inference>,
    /// What was changed, merged, left out or looks odd.
    pub notes: Vec<Note>,
}

/// One person's part of an import.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct PersonImport {
    /// Daily figures.
    pub balance: MassBalance,
    /// The same in one line.
    pub line: String,
    /// Therapy as stated or inferred.
    pub therapy: Therapy,
    /// Amounts in the source, in the record, and left out.
    pub totals: Vec<Totals>,
    /// Implausible figures; they changed nothing.
    pub findings: Vec<Finding>,
}

/// The account of one amount: `source = record + left_out`.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Totals {
    /// Column of `records.csv`.
    pub column: &'static str,
    /// Unit of the three amounts.
    pub unit: &'static str,
    /// Sum over the source.
    pub source: f64,
    /// Sum over the record.
    pub record: f64,
    /// Sum over what the notes list as left out.
    pub left_out: f64,
}

/// A unit or meaning that the source does not state.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Inference {
    /// The person.
    pub person: String,
    /// Where.
    #[serde(flatten)]
    pub place: Place,
    /// What was concluded.
    pub conclusion: String,
    /// The figures that support it.
    pub evidence: String,
}

/// Something that was changed, merged, left out or looks odd.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Note {
    /// The person, if it concerns one.
    pub person: Option<String>,
    /// Where; the first place if there are several.
    #[serde(flatten)]
    pub place: Place,
    /// What.
    pub what: String,
    /// How many times.
    pub count: usize,
}

impl ImportReport {
    /// The daily figures, one line per person.
    pub fn lines(&self) -> impl Iterator<Item = &str> {
        self.people.iter().map(|person| person.line.as_str())
    }
}

impl Totals {
    /// Whether the account closes, within rounding: 1e-9 of the source's amount.
    #[must_use]
    pub fn closes(&self) -> bool {
        (self.source - self.record - self.left_out).abs() <= 1e-9 * self.source.abs().max(1.0)
    }
}

impl std::fmt::Display for Note {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(person) = &self.person {
            write!(f, "{person}: ")?;
        }
        write!(f, "{}: {} ({}x)", self.place, self.what, self.count)
    }
}

impl std::fmt::Display for Inference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}: {}; {}", self.person, self.place, self.conclusion, self.evidence)
    }
}

/// One person as an importer read them.
pub(super) struct Imported {
    pub(super) person: Person,
    pub(super) totals: Vec<Totals>,
    pub(super) inferences: Vec<Inference>,
    pub(super) notes: Notes,
}

/// Notes of one person; the same note is counted, not repeated.
#[derive(Default)]
pub(super) struct Notes {
    notes: Vec<Note>,
}

impl Notes {
    /// Adds one occurrence of `what` at `place`; later ones raise the count of the first.
    pub(super) fn add(&mut self, person: &str, place: Place, what: &str) {
        self.add_many(person, place, what, 1);
    }

    /// Takes the notes of another, as of `person`.
    pub(super) fn take(&mut self, person: &str, other: Self) {
        for note in other.notes {
            self.add_many(person, note.place, &note.what, note.count);
        }
    }

    /// Adds `count` occurrences; nothing if that is 0.
    pub(super) fn add_many(&mut self, person: &str, place: Place, what: &str, count: usize) {
        if count == 0 {
            return;
        }
        let known = self.notes.iter_mut().find(|note| {
            note.what == what
                && note.person.as_deref() == Some(person)
                && note.place.file == place.file
                && note.place.column == place.column
        });
        match known {
            Some(note) => note.count += count,
            None => self.notes.push(Note {
                person: Some(person.into()),
                place,
                what: what.into(),
                count,
            }),
        }
    }
}

/// Combines people and their accounts.
pub(super) fn assemble(
    format: &'static str,
    days_are: &'static str,
    imported: Vec<Imported>,
) -> super::Import {
    let mut report =
        ImportReport { format, days_are, people: vec![], inferences: vec![], notes: vec![] };
    let mut cohort = Cohort::default();
    for Imported { person, totals, inferences, notes } in imported {
        let balance = MassBalance::of(&person);
        report.people.push(PersonImport {
            line: balance.to_string(),
            balance,
            therapy: person.therapy,
            totals,
            findings: findings(&person),
        });
        report.inferences.extend(inferences);
        report.notes.extend(notes.notes);
        cohort.people.push(person);
    }
    super::Import { cohort, report }
}
