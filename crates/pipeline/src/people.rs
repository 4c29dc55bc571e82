//! The people, days and channels of a cohort folder that every stage uses, and their list in its output.

use std::path::Path;

use ::report::count;
use anyhow::{Context as _, Result};
use cohort::{Cohort, findings, read_folder};
use contract::outcomes::ExclusionRow;
use contract::quality::{CheckOutcome, PersonInUse};
use contract::{DataInUse, Document as _, TwinRow};
use gap::InclusionRule;
use gap::quality::InUse;

use crate::{OutputFolder, note};

/// People whose checks are said one by one; the others are in the file.
const SAID: usize = 20;
/// Implausible figures of a cohort that are said.
const FINDINGS_SAID: usize = 10;

/// A cohort folder with the list of what is used of it.
pub(crate) struct People {
    /// Everybody, as recorded.
    pub(crate) recorded: Cohort,
    /// Who and what is used.
    pub(crate) data: InUse,
}

impl People {
    /// Reads a cohort folder and judges everybody in it.
    pub(crate) fn read(folder: &Path) -> Result<Self> {
        let recorded = read_cohort(folder)?;
        let data = InUse::of(&recorded, &InclusionRule::working())
            .with_context(|| format!("the cohort '{}'", folder.display()))?;
        Ok(Self { recorded, data })
    }

    /// The same, without telling what is implausible; for a look before the work.
    pub(crate) fn read_quietly(folder: &Path) -> Result<Self> {
        let cohort = || format!("the cohort '{}'", folder.display());
        let recorded = read_folder(folder).with_context(cohort)?;
        let data = InUse::of(&recorded, &InclusionRule::working()).with_context(cohort)?;
        Ok(Self { recorded, data })
    }

    /// The people who are used, with the values that are used.
    pub(crate) fn used(&self) -> Cohort {
        self.data.used(&self.recorded)
    }

    /// Writes the list and says, a line a person, what the checks found.
    pub(crate) fn write(&self, output: &OutputFolder) -> Result<()> {
        let table = self.data.table();
        say(&table);
        output.write_document(&table)
    }

    /// People who are left out, as tables of outcomes name them.
    pub(crate) fn left_out(&self) -> impl Iterator<Item = ExclusionRow> {
        self.data.left_out().map(|(person, reason)| ExclusionRow {
            person_id: person.to_owned(),
            reason: reason.to_owned(),
        })
    }

    /// Puts the people who are left out among rows of twins, in the order of the cohort.
    pub(crate) fn with_left_out(&self, mut rows: Vec<TwinRow>) -> Vec<TwinRow> {
        rows.extend(self.left_out().map(|out| TwinRow::left_out(out.person_id, out.reason)));
        rows.sort_by_key(|row| self.recorded.find(&row.person_id).map(|(index, _)| index));
        rows
    }
}

/// Says what the checks found, unless everybody passes all of them.
fn say(table: &DataInUse) {
    let found: Vec<&PersonInUse> = table
        .people
        .iter()
        .filter(|person| of(person, CheckOutcome::Pass) < person.checks.len())
        .collect();
    let left_out = table.people.iter().filter(|person| person.left_out.is_some()).count();
    if found.is_empty() {
        return;
    }
    note(format!(
        "data: {} of {} in use",
        table.people.len() - left_out,
        count(table.people.len(), "person", "people")
    ));
    for person in found.iter().take(SAID) {
        note(line(person));
    }
    if found.len() > SAID {
        let more = count(found.len() - SAID, "person", "people");
        note(format!("data: {more} more, in {}", DataInUse::FILE));
    }
}

/// Number of checks with an outcome.
fn of(person: &PersonInUse, outcome: CheckOutcome) -> usize {
    person.checks.iter().filter(|check| check.result == outcome).count()
}

/// One person's row of the table in words.
fn line(person: &PersonInUse) -> String {
    let mut line = format!("data: {}: {} pass", person.person_id, of(person, CheckOutcome::Pass));
    for outcome in [CheckOutcome::Warn, CheckOutcome::Fail] {
        let checks = person.checks.iter().filter(|check| check.result == outcome);
        let names: Vec<&str> = checks.map(|check| check.check.as_str()).collect();
        if !names.is_empty() {
            line += &format!("; {}: {}", outcome.name(), names.join(", "));
        }
    }
    match &person.left_out {
        Some(reason) => line += &format!("; left out: {reason}"),
        None if !person.days_left_out.is_empty() => {
            line += &format!("; {} of {} days not used", person.days_left_out.len(), person.days);
        }
        None => {}
    }
    line
}

/// A cohort folder.
///
/// What is implausible in it is said, a line each, up to a limit; nothing is changed.
pub fn read_cohort(folder: &Path) -> Result<Cohort> {
    let cohort =
        read_folder(folder).with_context(|| format!("the cohort '{}'", folder.display()))?;
    let found: Vec<_> = cohort.people.iter().flat_map(findings).collect();
    for finding in found.iter().take(FINDINGS_SAID) {
        note(format!("implausible: {finding}"));
    }
    if found.len() > FINDINGS_SAID {
        let more = count(found.len() - FINDINGS_SAID, "finding", "findings");
        note(format!("implausible: {more} more"));
    }
    Ok(cohort)
}
