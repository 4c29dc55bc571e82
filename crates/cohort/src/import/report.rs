//! The account of an import.

use std::collections::HashMap;

use contract::import_report::{ImportReport, Inference, Note, PersonImport, Totals};

use crate::error::{CohortError, Place};
use crate::mass_balance::mass_balance;
use crate::person::{Cohort, Person};
use crate::plausibility::findings;
use crate::record::{Channel, GridSteps};

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

/// The account of an amount in a channel.
pub(super) fn totals_of(
    channel: Channel,
    unit: &str,
    source: f64,
    record: f64,
    left_out: f64,
) -> Totals {
    Totals { column: channel.column().into(), unit: unit.into(), source, record, left_out }
}

/// One person as an importer read them.
pub(super) struct Imported {
    pub(super) person: Person,
    /// The file that is named where something concerns all of the person.
    pub(super) file: String,
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
    let mut without = Vec::new();
    let measured = people.into_iter().filter_map(|person| match person {
        Ok((_, _, Some(person))) => Some(Ok(person)),
        Ok((id, file, None)) => {
            without.push(Note {
                person: Some(id),
                file,
                row: None,
                column: None,
                what: "no sensor reading: the person is left out".into(),
                count: 1,
            });
            None
        }
        Err(error) => Some(Err(error)),
    });
    let days_are = "the span from the first to the last sensor reading";
    let mut import = assemble(format, days_are, measured)?;
    if import.cohort.people.is_empty() {
        return Err(CohortError::layout(source, format, "no sensor reading of anyone"));
    }
    import.report.notes.extend(without);
    Ok(import)
}

/// Combines people and their accounts. Refuses more steps than a cohort may have, and two people
/// of one name.
pub(super) fn assemble(
    format: &'static str,
    days_are: &str,
    imported: impl IntoIterator<Item = Result<Imported, CohortError>>,
) -> Result<super::Import, CohortError> {
    assemble_after(GridSteps::default(), format, days_are, imported)
}

/// The same, after other people of so many steps.
fn assemble_after(
    mut steps: GridSteps,
    format: &'static str,
    days_are: &str,
    imported: impl IntoIterator<Item = Result<Imported, CohortError>>,
) -> Result<super::Import, CohortError> {
    let (mut people, mut all_inferences, mut all_notes) = (vec![], vec![], vec![]);
    let mut cohort = Cohort::default();
    let mut files: HashMap<String, String> = HashMap::new();
    for one in imported {
        let Imported { person, file, totals, inferences, notes } = one?;
        steps.add(person.record.len(), &file)?;
        if let Some(other) = files.insert(person.id.clone(), file.clone()) {
            let reason = format!(
                "its person would be called '{}', as that of '{other}'; rename one of the files",
                person.id
            );
            return Err(CohortError::layout(file, format, reason));
        }
        let balance = mass_balance(&person);
        people.push(PersonImport {
            line: balance.to_string(),
            balance,
            therapy: Some(person.therapy.name().to_owned()),
            totals: Some(totals),
            findings: findings(&person),
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
    Ok(super::Import { cohort, report })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::person::Therapy;
    use crate::record::Record;

    /// A person of two steps in `file`.
    fn person(id: &str, file: &str) -> Result<Imported, CohortError> {
        let start = "2024-03-01T08:00:00".parse().expect("a literal time");
        Ok(Imported {
            person: Person {
                id: id.into(),
                weight: None,
                therapy: Therapy::Unknown,
                heart_rate_baseline: None,
                record: Record::new(start, 2)?,
            },
            file: file.into(),
            totals: Vec::new(),
            inferences: Vec::new(),
            notes: Notes::default(),
        })
    }

    #[test]
    fn a_cohort_of_any_format_has_so_many_steps_and_no_more() {
        let after = |others: usize| {
            let mut steps = GridSteps::default();
            steps.add(others, "others.csv").expect("not too many");
            assemble_after(steps, "f", "", [person("a", "a.csv"), person("b", "b.csv")])
        };
        assert_eq!(after((1 << 25) - 4).expect("as many as there may be").cohort.people.len(), 2);
        let error = after((1 << 25) - 3).expect_err("one more").to_string();
        assert!(error.contains("b.csv: the records span more than"), "{error}");
    }

    #[test]
    fn two_people_of_one_name_are_refused() {
        let people = [person("a-1", "a#1.csv"), person("a-1", "a-1.csv")];
        let error = assemble("f", "", people).expect_err("one name").to_string();
        assert!(error.contains("a-1.csv: not in the layout of f"), "{error}");
        assert!(error.contains("called 'a-1', as that of 'a#1.csv'"), "{error}");
    }
}
