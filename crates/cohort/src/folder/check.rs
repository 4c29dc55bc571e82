//! Everything that is wrong with a cohort folder, at once.

use std::path::Path;

use super::columns::ignored;
use super::record_table::RecordTable;
use super::{PEOPLE, people_table, read_records, record_table, records_format};
use crate::error::CohortError;
use crate::faults::{Fault, Faults};
use contract::import_report::{ImplausibleFigure, MassBalance};

use crate::mass_balance::mass_balance;
use crate::plausibility::findings;
use crate::record::Channel;

/// What [`check_folder`] found.
#[derive(Debug, Default)]
pub struct FolderCheck {
    /// What [`read_folder`](crate::read_folder) refuses, with file, row, column and remedy.
    pub faults: Vec<Fault>,
    /// What is ignored or counts as not recorded.
    pub remarks: Vec<String>,
    /// Figures that are unlikely; they are read as they are. Empty where there are faults.
    pub findings: Vec<ImplausibleFigure>,
    /// The daily figures of each person. Empty where there are faults.
    pub people: Vec<MassBalance>,
}

impl FolderCheck {
    /// Whether the folder can be read.
    #[must_use]
    pub fn passes(&self) -> bool {
        self.faults.is_empty()
    }
}

/// Checks a folder as [`read_folder`](crate::read_folder) does, but goes on after a fault.
///
/// A file that cannot be read as a table is one fault; nothing is then said of its rows. Of many
/// faults of a kind in one column the first twenty are listed and the others counted.
#[must_use]
pub fn check_folder(folder: &Path) -> FolderCheck {
    let mut faults = Faults::collecting();
    let mut found = FolderCheck::default();
    // Collecting keeps every fault: an error from here on is one that ends the reading of a file.
    if let Err(error) = check(folder, &mut faults, &mut found) {
        faults.add(error).expect("a collecting list takes every fault");
    }
    found.faults = faults.into_list();
    if !found.passes() {
        found.findings.clear();
        found.people.clear();
    }
    found
}

fn check(folder: &Path, faults: &mut Faults, found: &mut FolderCheck) -> Result<(), CohortError> {
    let people = people_table::read(folder, faults);
    let people = faults.pass(people)?;
    let table = RecordTable::read(folder, records_format(folder)?, faults)?;
    let known = record_table::columns();
    for name in ignored(table.header(), &known) {
        found.remarks.push(format!("{}: column '{name}' is unknown and ignored", table.file()));
    }
    for channel in Channel::ALL.iter().filter(|channel| **channel != Channel::Cgm) {
        let name = channel.name();
        if !table.header().iter().any(|column| column == name) {
            found.remarks.push(format!("{}: no column '{name}': not recorded", table.file()));
        }
    }
    // Without people every row would be one of an unknown person.
    let Some(mut people) = people else { return Ok(()) };
    read_records::fill(&mut people, &table, faults)?;
    if people.is_empty() {
        return Err(CohortError::empty(PEOPLE));
    }
    for person in &people {
        found.findings.extend(findings(person));
        found.people.push(mass_balance(person));
    }
    Ok(())
}
