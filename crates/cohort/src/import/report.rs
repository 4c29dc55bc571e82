//! The account of an import.

use contract::import_report::{ImportReport, Inference, Note, PersonImport, Totals};

use crate::error::{CohortError, Place};
use crate::mass_balance::mass_balance;
use crate::person::{Cohort, Person};
use crate::plausibility::findings;
use crate::record::GridSteps;

/// What was concluded of a person's unit or meaning at `place`, from which figures.
pub(super) fn inference(
    person: &str,
    place: Place,
    conclusion: impl Into<String>,
    evidence: impl Into<String>,
) -> Inference {
    let Place { file, row, column } = place;
    let (conclusion, evidence) = (conclusion.into(), evidence.into());
    Inference { person: person.to_owned(), file, row, column, conclusion, evidence }
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
            let Note { file, row, column, what, count, .. } = note;
            self.add_many(person, Place { file, row, column }, &what, count);
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
                && note.file == place.file
                && note.column == place.column
        });
        match known {
            Some(note) => note.count += count,
            None => {
                let Place { file, row, column } = place;
                let (person, what) = (Some(person.into()), what.into());
                self.notes.push(Note { person, file, row, column, what, count });
            }
        }
    }
}

/// Combines people and their accounts: who, of which file, and the person if there is a sensor
/// reading. Who has none is left out and named.
pub(super) fn assemble_measured(
    format: &'static str,
    source: &str,
    people: impl IntoIterator<Item = Result<(String, String, Option<Imported>), CohortError>>,
) -> Result<super::Import, CohortError> {
    let (mut imported, mut without, mut steps) = (Vec::new(), Vec::new(), GridSteps::default());
    for person in people {
        match person? {
            (_, file, Some(person)) => {
                steps.add(person.person.record.len(), &file)?;
                imported.push(person);
            }
            (id, file, None) => without.push(Note {
                person: Some(id),
                file,
                row: None,
                column: None,
                what: "no sensor reading: the person is left out".into(),
                count: 1,
            }),
        }
    }
    if imported.is_empty() {
        return Err(CohortError::WrongLayout {
            file: source.into(),
            expected: format,
            reason: "no sensor reading of anyone".into(),
        });
    }
    let days_are = "the span from the first to the last sensor reading";
    let mut import = assemble(format, days_are, imported);
    import.report.notes.extend(without);
    Ok(import)
}

/// Combines people and their accounts.
pub(super) fn assemble(format: &str, days_are: &str, imported: Vec<Imported>) -> super::Import {
    let (mut people, mut all_inferences, mut all_notes) = (vec![], vec![], vec![]);
    let mut cohort = Cohort::default();
    for Imported { person, totals, inferences, notes } in imported {
        let balance = mass_balance(&person);
        people.push(PersonImport {
            line: balance.to_string(),
            balance,
            therapy: Some(person.therapy.name().to_owned()),
            totals: Some(totals),
            findings: findings(&person).iter().map(Into::into).collect(),
        });
        all_inferences.extend(inferences);
        all_notes.extend(notes.notes);
        cohort.people.push(person);
    }
    let report = ImportReport {
        format: format.to_owned(),
        days_are: Some(days_are.to_owned()),
        people,
        inferences: Some(all_inferences),
        notes: all_notes,
    };
    super::Import { cohort, report }
}
