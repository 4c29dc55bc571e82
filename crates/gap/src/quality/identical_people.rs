//! `identical_people`: one record under several names.
//!
//! People are the unit of every interval. One person counted three times makes evidence that is not there, and
//! which of the names is right nobody can tell: such a cohort is refused. So is one in which two people share a day of
//! readings, whatever else differs: names, doses, dates, or where their records begin and end.

use std::collections::HashMap;

use cohort::{Channel, Cohort, Record};
use physiology::STEPS_PER_DAY;

/// Values of a day that lie on no line between their neighbours and were therefore read: half of those of a
/// sensor that reads every 15 min. Another person has the same next reading in one case of four at most, so that
/// chance makes two days equal once in 4^48 = 8e28 pairs; 500 people of four weeks have 8e12.
const READ: usize = STEPS_PER_DAY / 6;
/// Second difference up to which a value lies on the line between its neighbours, mg/dL: sensors report whole
/// mg/dL or tenths of a mmol/L.
const ON_LINE: f64 = 1e-6;
/// Base of the number that stands for a day's values; any large odd number will do.
const BASE: u64 = 0x9E37_79B9_7F4A_7C15;

/// The first two people of a cohort who are one.
///
/// Two records that differ in doses or dates are found from two days in common on.
#[must_use]
pub fn identical_people(cohort: &Cohort) -> Option<(&str, &str)> {
    let people = &cohort.people;
    let mut known: HashMap<u64, usize> = HashMap::new();
    people.iter().enumerate().find_map(|(index, person)| {
        let days = days_from_every_step(person.record.cgm());
        let shared = || days.iter().flatten().find_map(|day| known.get(day).copied());
        let whole = people[..index].iter().position(|other| same(&other.record, &person.record));
        let other = whole.or_else(shared);
        known.extend(days.iter().step_by(STEPS_PER_DAY).flatten().map(|day| (*day, index)));
        Some((people[other?].id.as_str(), person.id.as_str()))
    })
}

fn same(one: &Record, other: &Record) -> bool {
    let channels = [Channel::Cgm, Channel::Basal, Channel::Bolus, Channel::Carbs];
    one.cgm().iter().any(Option::is_some)
        && channels.iter().all(|channel| one.channel(*channel) == other.channel(*channel))
}

/// A number for the day of values from each step on; `None` where too few of them were read.
fn days_from_every_step(cgm: &[Option<f64>]) -> Vec<Option<u64>> {
    let read: Vec<bool> = (0..cgm.len())
        .map(|k| match cgm.get(k.wrapping_sub(1)..k.saturating_add(2)) {
            Some(&[Some(a), Some(b), Some(c)]) => (a - 2.0 * b + c).abs() > ON_LINE,
            _ => false,
        })
        .collect();
    let first = (1..STEPS_PER_DAY).fold(1, |power: u64, _| power.wrapping_mul(BASE));
    let (mut number, mut count) = (0u64, 0);
    let mut days = Vec::new();
    for k in 0..cgm.len() {
        if let Some(gone) = k.checked_sub(STEPS_PER_DAY) {
            number = number.wrapping_sub(mixed(cgm[gone]).wrapping_mul(first));
            count -= usize::from(read[gone]);
        }
        number = number.wrapping_mul(BASE).wrapping_add(mixed(cgm[k]));
        count += usize::from(read[k]);
        if k + 1 >= STEPS_PER_DAY {
            days.push((count >= READ).then_some(number));
        }
    }
    days
}

/// A value as a number whose bits depend on all of its bits (the finaliser of MurmurHash3).
fn mixed(value: Option<f64>) -> u64 {
    let mut bits = value.map_or(u64::MAX, f64::to_bits);
    for factor in [0xFF51_AFD7_ED55_8CCD, 0xC4CE_B9FE_1A85_EC53] {
        bits = (bits ^ (bits >> 33)).wrapping_mul(factor);
    }
    bits ^ (bits >> 33)
}
