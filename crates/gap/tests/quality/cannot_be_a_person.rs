//! Records that are no person's.

use cohort::{Channel, Cohort, Person, Therapy};
use gap::quality::{Consequence, identical_people};
use gap::{Diagnoser, DiagnosisConfig, GapError};

use crate::planted::{changed, checks, doubts, embedded};

/// Asserts that `check` finds what was done to everybody, and that they are left out for it.
fn check(check: &str, plant: impl Fn(&Person) -> Person) {
    for person in embedded() {
        let found = doubts(&plant(&person));
        let case = format!("{}: {found:?}", person.id);
        assert!(checks(&found).contains(&check), "{case}");
        let left_out = found.iter().any(|finding| {
            finding.reported.check == check && finding.consequence == Consequence::ExcludePerson
        });
        assert!(left_out, "{case}");
    }
}

#[test]
fn a_flat_line_and_readings_out_of_range_are_no_glucose() {
    check("flat_cgm", |p| changed(p, Channel::Cgm, |_, _| 120.0));
    check("flat_cgm", |p| changed(p, Channel::Cgm, |_, _| 401.0));
    check("flat_cgm", |p| changed(p, Channel::Cgm, |k, _| 120.0 + (k % 3) as f64));
    // Glucose in mmol/L, as it was exported.
    check("flat_cgm", |p| changed(p, Channel::Cgm, |_, glucose| glucose / 18.0));
}

#[test]
fn readings_out_of_order_are_no_course() {
    let shuffled = |within: usize| {
        move |person: &Person| {
            let old = person.record.cgm().to_vec();
            let mut mixed = person.clone();
            let values = mixed.record.channel_mut(Channel::Cgm);
            for (k, value) in values.iter_mut().enumerate() {
                let from = k / within * within + (k % within) * 7919 % within;
                *value = old.get(from).copied().unwrap_or(*value);
            }
            mixed
        }
    };
    // Over a fortnight, and within days.
    check("discontinuous_cgm", shuffled(14 * 288 - 1));
    check("discontinuous_cgm", shuffled(288));
}

#[test]
fn a_pump_without_basal_insulin_and_meals_without_boluses_are_incomplete() {
    check("insulin_incomplete", |p| changed(p, Channel::Basal, |_, _| 0.0));
    check("insulin_incomplete", |p| {
        let mut without = p.clone();
        without.record.channel_mut(Channel::Basal).fill(None);
        without
    });
    check("insulin_incomplete", |p| {
        let without = changed(p, Channel::Bolus, |_, _| 0.0);
        // A controller may give all insulin as basal; a programmed pump may not.
        Person { therapy: Therapy::OpenLoopPump, ..without }
    });
    for person in embedded() {
        // Injections are no pump.
        let mut injects = Person { therapy: Therapy::Mdi, ..person };
        injects.record.channel_mut(Channel::Basal).fill(None);
        assert!(!checks(&doubts(&injects)).contains(&"insulin_incomplete"), "{}", injects.id);
    }
}

#[test]
fn one_record_under_two_names_is_refused() {
    let mut cohort = Cohort { people: embedded() };
    assert_eq!(identical_people(&cohort), None);
    let mut twin = cohort.people[1].clone();
    twin.id = "another".to_owned();
    twin.weight = None;
    cohort.people.push(twin);
    let (one, other) = identical_people(&cohort).expect("a twin");
    assert_eq!((one, other), (cohort.people[1].id.as_str(), "another"));
    let refused = Diagnoser::new(&effects::library(), &DiagnosisConfig::working())
        .run(&cohort, 1)
        .expect_err("a twin");
    assert!(matches!(&refused, GapError::IdenticalPeople { other, .. } if other == "another"));
    let last = cohort.people.len() - 1;
    cohort.people[last].record.channel_mut(Channel::Cgm)[100] = Some(111.0);
    assert_eq!(identical_people(&cohort), None);
}
