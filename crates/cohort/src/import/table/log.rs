//! What a person's rows hold, before it is laid on the grid.

use std::collections::BTreeMap;

use super::clock::Hour;
use super::options::Role;
use crate::error::Place;
use crate::import::report::Account;

/// A value at a local time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Event {
    /// Local seconds since 1970.
    pub(super) second: i64,
    /// In the record's unit, but for basal amounts.
    pub(super) value: f64,
    pub(super) hour: Hour,
}

/// One person's events and the account of how they were read.
#[derive(Default)]
pub(super) struct Log {
    pub(super) account: Account,
    /// The name of the person as the file writes it.
    pub(super) written: String,
    pub(super) events: BTreeMap<Role, Vec<Event>>,
    /// Column of each role, for notes.
    pub(super) columns: BTreeMap<Role, Place>,
    /// Amounts of rows that give no event, by role.
    pub(super) left_out: BTreeMap<Role, f64>,
}

impl Log {
    /// A log of nothing yet; `file` is the first one with rows of this person.
    pub(super) fn new(id: &str, file: &str) -> Self {
        Self { account: Account::new(id, file), ..Self::default() }
    }

    /// Counts occurrences in the column of a role.
    pub(super) fn note_of(&mut self, role: Role, what: &str, count: usize) {
        self.account.note(self.place(role), what, count);
    }

    /// Records what was concluded about the column of a role.
    pub(super) fn infer(&mut self, role: Role, conclusion: &str, evidence: String) {
        self.account.infer(self.place(role), conclusion, evidence);
    }

    /// The column of a role.
    pub(super) fn place(&self, role: Role) -> Place {
        self.columns.get(&role).cloned().unwrap_or_else(|| Place::file(&self.account.file))
    }

    /// Takes the rows of another file of the same person.
    pub(super) fn take(&mut self, other: Self) {
        for (role, events) in other.events {
            self.events.entry(role).or_default().extend(events);
        }
        for (role, place) in other.columns {
            self.columns.entry(role).or_insert(place);
        }
        for (role, amount) in other.left_out {
            *self.left_out.entry(role).or_default() += amount;
        }
        self.account.take(other.account);
    }
}
