//! `identical_people`: one record under several names.
//!
//! People are the unit of every interval. One person counted three times makes evidence that is not there, and
//! which of the names is right nobody can tell: such a cohort is refused.

use cohort::{Channel, Cohort, Record};

/// The first two people of a cohort whose readings and doses are the same, value by value.
#[must_use]
pub fn identical_people(cohort: &Cohort) -> Option<(&str, &str)> {
    let people = &cohort.people;
    people.iter().enumerate().find_map(|(index, person)| {
        let other = people[..index].iter().find(|other| same(&other.record, &person.record))?;
        Some((other.id.as_str(), person.id.as_str()))
    })
}

fn same(one: &Record, other: &Record) -> bool {
    let channels = [Channel::Cgm, Channel::Basal, Channel::Bolus, Channel::Carbs];
    one.cgm().iter().any(Option::is_some)
        && channels.iter().all(|channel| one.channel(*channel) == other.channel(*channel))
}
