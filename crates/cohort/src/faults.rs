//! Faults of files: the first ends the reading, or all are collected.
//!
//! Readers hand every fault to [`Faults`] and go on if they may, so that one code decides what is
//! wrong whether a folder is read or checked.

use std::mem::{Discriminant, discriminant};

use crate::error::CohortError;

/// Faults of one kind in one column that are kept; more are counted.
const KEPT: usize = 20;

/// What happens to a fault.
pub(crate) struct Faults {
    /// `None`: the first fault is returned.
    collected: Option<Vec<Fault>>,
}

/// A fault, or the last of many alike.
#[derive(Debug)]
pub struct Fault {
    /// What is wrong, where, and what mends it.
    pub error: CohortError,
    /// Further faults of the kind in the same column, beyond those that are listed.
    pub more: usize,
}

impl Faults {
    /// Every fault is returned to the caller at once.
    pub(crate) const fn strict() -> Self {
        Self { collected: None }
    }

    /// Every fault is kept.
    pub(crate) const fn collecting() -> Self {
        Self { collected: Some(Vec::new()) }
    }

    /// Takes a fault: an error again if it must end the reading.
    pub(crate) fn add(&mut self, error: CohortError) -> Result<(), CohortError> {
        let Some(faults) = &mut self.collected else { return Err(error) };
        let key = key(&error);
        let alike = |fault: &&mut Fault| self::key(&fault.error) == key;
        if faults.iter_mut().filter(alike).count() < KEPT {
            faults.push(Fault { error, more: 0 });
        } else if let Some(last) = faults.iter_mut().rev().find(|fault| alike(fault)) {
            last.more += 1;
        }
        Ok(())
    }

    /// The value of a result; `None` where its error was kept.
    pub(crate) fn pass<T>(
        &mut self,
        result: Result<T, CohortError>,
    ) -> Result<Option<T>, CohortError> {
        match result {
            Ok(value) => Ok(Some(value)),
            Err(error) => self.add(error).map(|()| None),
        }
    }

    /// What was kept, in the order in which it was found.
    pub(crate) fn into_list(self) -> Vec<Fault> {
        self.collected.unwrap_or_default()
    }
}

type Key = (Discriminant<CohortError>, Option<(String, Option<String>)>);

fn key(error: &CohortError) -> Key {
    (discriminant(error), error.place().map(|place| (place.file, place.column)))
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.error)?;
        match self.more {
            0 => Ok(()),
            more => write!(f, " (and {more} more like it)"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Place;

    fn wrong(row: usize, column: &str) -> CohortError {
        let place = Place::cell("a.csv", row, column);
        CohortError::Cell { place, value: "x".into(), expected: "a number" }
    }

    #[test]
    fn the_first_fault_ends_a_strict_reading_and_many_alike_are_counted() {
        assert!(Faults::strict().add(wrong(2, "b")).is_err());
        let mut faults = Faults::collecting();
        for row in 2..102 {
            faults.add(wrong(row, "b")).expect("kept");
        }
        faults.add(wrong(7, "c")).expect("kept");
        let list = faults.into_list();
        assert_eq!(list.len(), KEPT + 1);
        assert_eq!(list[KEPT - 1].more, 80);
        let last = list[KEPT - 1].to_string();
        assert_eq!(last, "a.csv, row 21, column b: 'x' is not a number (and 80 more like it)");
        assert_eq!(list[KEPT].more, 0);
    }
}
