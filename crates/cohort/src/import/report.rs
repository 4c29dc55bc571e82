//! The account of an import.

use std::collections::HashMap;

use contract::import_report::{ImportReport, Inference, Note, PersonImport, Totals};

use crate::error::{CohortError, Place};
use crate::mass_balance::mass_balance;
use crate::person::{Cohort, Person};
use crate::plausibility::findings;
use crate::record::{Channel, GridSteps};

/// What the days of a person are where glucose spans the record.
pub(super) const DAYS_OF_READINGS: &str = "the span from the first to the last sensor reading";

/// One person as an importer read them, and how.
pub(super) struct Imported {
    /// `None` without a sensor reading.
    pub(super) person: Option<Person>,
    pub(super) account: Account,
}

/// The account of one person while they are read.
#[derive(Default)]
pub(super) struct Account {
    pub(super) id: String,
    /// The file that is named where something concerns all of the person.
    pub(super) file: String,
    pub(super) totals: Vec<Totals>,
    inferences: Vec<Inference>,
    notes: Vec<Note>,
}

impl Account {
    /// An account of nothing yet.
    pub(super) fn new(id: &str, file: &str) -> Self {
        Self { id: id.into(), file: file.into(), ..Self::default() }
    }

    /// Adds `count` occurrences of `what` at `place`, if there are any; later ones in the same
    /// column raise the count of the first.
    pub(super) fn note(&mut self, place: Place, what: &str, count: usize) {
        if count == 0 {
            return;
        }
        let known = self.notes.iter_mut().find(|note| {
            note.what == what && note.file == place.file && note.column == place.column
        });
        match known {
            Some(note) => note.count += count,
            None => {
                let Place { file, row, column } = place;
                let (person, what) = (Some(self.id.clone()), what.into());
                self.notes.push(Note { person, file, row, column, what, count });
            }
        }
    }

    /// Adds what was concluded of the unit or meaning at `place`, from which figures.
    pub(super) fn infer(
        &mut self,
        place: Place,
        conclusion: impl Into<String>,
        evidence: impl Into<String>,
    ) {
        let Place { file, row, column } = place;
        let (person, conclusion, evidence) = (self.id.clone(), conclusion.into(), evidence.into());
        self.inferences.push(Inference { person, file, row, column, conclusion, evidence });
    }

    /// Adds the account of an amount in a channel.
    pub(super) fn total(
        &mut self,
        channel: Channel,
        unit: &str,
        source: f64,
        record: f64,
        left_out: f64,
    ) {
        let (column, unit) = (channel.name().into(), unit.into());
        self.totals.push(Totals { column, unit, source, record, left_out });
    }

    /// Takes what was noted and concluded in another file of the person.
    pub(super) fn take(&mut self, other: Self) {
        for Note { file, row, column, what, count, .. } in other.notes {
            self.note(Place { file, row, column }, &what, count);
        }
        for Inference { file, row, column, conclusion, evidence, .. } in other.inferences {
            self.infer(Place { file, row, column }, conclusion, evidence);
        }
    }
}

/// Combines people and their accounts. Who has no sensor reading is left out and named. Refuses
/// more steps than a cohort may have, and two people of one name.
pub(super) fn assemble(
    format: &'static str,
    source: impl std::fmt::Display,
    days_are: &str,
    imported: impl IntoIterator<Item = Result<Imported, CohortError>>,
) -> Result<super::Import, CohortError> {
    assemble_after(GridSteps::default(), format, source, days_are, imported)
}

/// The same, after other people of so many steps.
fn assemble_after(
    mut steps: GridSteps,
    format: &'static str,
    source: impl std::fmt::Display,
    days_are: &str,
    imported: impl IntoIterator<Item = Result<Imported, CohortError>>,
) -> Result<super::Import, CohortError> {
    let (mut people, mut inferences, mut notes, mut without) = (vec![], vec![], vec![], vec![]);
    let mut cohort = Cohort::default();
    let mut files: HashMap<String, String> = HashMap::new();
    for one in imported {
        let Imported { person, mut account } = one?;
        let file = account.file.clone();
        let Some(person) = person else {
            account.notes.clear();
            account.note(Place::file(file), "no sensor reading: the person is left out", 1);
            without.extend(account.notes);
            continue;
        };
        steps.add(person.record.len(), &file)?;
        if let Some(other) = files.insert(person.id.clone(), account.file) {
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
            totals: Some(account.totals),
            findings: findings(&person),
        });
        inferences.extend(account.inferences);
        notes.extend(account.notes);
        cohort.people.push(person);
    }
    if people.is_empty() {
        return Err(CohortError::layout(source, format, "no sensor reading of anyone"));
    }
    notes.extend(without);
    let report = ImportReport {
        format: format.to_owned(),
        days_are: Some(days_are.to_owned()),
        people,
        inferences: Some(inferences),
        notes,
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
        let person = Person {
            id: id.into(),
            weight: None,
            therapy: Therapy::Unknown,
            heart_rate_baseline: None,
            record: Record::new(start, 2)?,
        };
        Ok(Imported { person: Some(person), account: Account::new(id, file) })
    }

    #[test]
    fn a_cohort_of_any_format_has_so_many_steps_and_no_more() {
        let after = |others: usize| {
            let mut steps = GridSteps::default();
            steps.add(others, "others.csv").expect("not too many");
            assemble_after(steps, "f", "", "", [person("a", "a.csv"), person("b", "b.csv")])
        };
        assert_eq!(after((1 << 25) - 4).expect("as many as there may be").cohort.people.len(), 2);
        let error = after((1 << 25) - 3).expect_err("one more").to_string();
        assert!(error.contains("b.csv: the records span more than"), "{error}");
    }

    #[test]
    fn two_people_of_one_name_are_refused() {
        let people = [person("a-1", "a#1.csv"), person("a-1", "a-1.csv")];
        let error = assemble("f", "", "", people).expect_err("one name").to_string();
        assert!(error.contains("a-1.csv: not in the layout of f"), "{error}");
        assert!(error.contains("called 'a-1', as that of 'a#1.csv'"), "{error}");
    }
}
