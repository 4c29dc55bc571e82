//! `cohort`: what is wrong with a cohort folder, and a template of one.

use std::path::Path;

use anyhow::{Context as _, Result, bail};
use cohort::{check_folder, new_folder};

use crate::next_step::wrote;
use crate::progress::{note, say};

/// Lists everything that is wrong with a folder; an error if anything is.
pub fn check(folder: &Path) -> Result<()> {
    let found = check_folder(folder);
    for fault in &found.faults {
        say(&fault.to_string());
    }
    found.remarks.iter().for_each(note);
    for finding in &found.findings {
        note(format!("unlikely: {finding}"));
    }
    for person in &found.people {
        note(person.to_string());
    }
    let faults: usize = found.faults.iter().map(|fault| 1 + fault.more).sum();
    match faults {
        0 => {
            note(format!(
                "cohort: '{}' can be read; {} unlikely figures",
                folder.display(),
                found.findings.len()
            ));
            wrote("cohort check", folder, None);
        }
        1 => bail!("'{}' has the fault above", folder.display()),
        faults => bail!("'{}' has the {faults} faults above", folder.display()),
    }
    Ok(())
}

/// Writes a template with three example rows.
pub fn new(folder: &Path) -> Result<()> {
    new_folder(folder).context("writing the template")?;
    note(format!("cohort: a template in '{}'", folder.display()));
    wrote("cohort new", folder, None);
    Ok(())
}
