//! The names in a header, beside those that a file can have.

use crate::error::CohortError;
use crate::faults::Faults;
use crate::near_name::near;

/// Refuses unknown names that are close to an absent column: what it holds would be taken for "not
/// recorded". Other unknown columns are ignored.
pub(super) fn check_names(
    file: &str,
    header: &[String],
    known: &[&'static str],
    faults: &mut Faults,
) -> Result<(), CohortError> {
    if let [one] = header
        && let Some(mark) = [';', '\t', '|'].into_iter().find(|mark| one.contains(*mark))
    {
        let reason = format!(
            "the header is one cell with {mark:?} in it; separate the cells by ',', or import the table"
        );
        return Err(CohortError::layout(file, "a table separated by ','", reason));
    }
    let absent: Vec<&'static str> =
        known.iter().copied().filter(|name| !header.iter().any(|column| column == name)).collect();
    for found in ignored(header, known) {
        if let Some(known) = near(found, absent.iter().copied()) {
            let (file, found) = (file.into(), found.into());
            faults.add(CohortError::NearColumn { file, found, known })?;
        }
    }
    Ok(())
}

/// The named columns that are none of `known`.
pub(super) fn ignored<'a>(
    header: &'a [String],
    known: &'a [&'static str],
) -> impl Iterator<Item = &'a str> {
    let names = header.iter().map(String::as_str);
    names.filter(move |name| !name.is_empty() && !known.contains(name))
}
