//! Records that are no person's.

use cohort::{Channel, Cohort, ImportFormat, Person, Therapy, import};
use contract::quality::CheckOutcome;
use gap::quality::{CHECKS, Consequence, InUse, identical_people};
use gap::{Diagnoser, DiagnosisConfig, GapError, InclusionRule};
use rand::SeedableRng as _;
use rand::seq::SliceRandom as _;
use rand_chacha::ChaCha8Rng;

use crate::planted::{MEALS, changed, checks, doubts, embedded, estimate, late};

/// What is used of people.
fn in_use(people: Vec<Person>) -> InUse {
    InUse::of(&Cohort { people }, &InclusionRule::working()).expect("people who differ")
}

/// Asserts that `check` finds what was done to everybody, that they are left out of every stage for it, by name, and
/// that the sound people beside them are used as they are recorded.
fn check(check: &str, plant: impl Fn(&Person) -> Person) {
    for person in embedded() {
        let beside = embedded().into_iter().find(|other| other.id != person.id).expect("six");
        let people = vec![beside.clone(), plant(&person)];
        let data = in_use(people.clone());
        let found = &data.of_person(&person.id).expect("judged").findings;
        let left_out = found.iter().any(|finding| {
            finding.reported.check == check && finding.consequence == Consequence::ExcludePerson
        });
        assert!(left_out, "{}: {found:?}", person.id);
        let (id, reason) = data.left_out().next().expect("one");
        assert!(id == person.id && reason.starts_with(&format!("{check}: ")), "{id}: {reason}");
        assert!(data.used(&Cohort { people }).people == [beside], "{}", person.id);
        let table = data.table();
        let rows = &table.people[1].checks;
        let row = rows.iter().find(|row| row.check == check).expect("a row a check");
        assert_eq!((row.result, row.findings.is_empty()), (CheckOutcome::Fail, false));
        let other = &table.people[0];
        assert!(other.left_out.is_none() && other.days_left_out.is_empty(), "{other:?}");
        assert!(other.checks.iter().all(|row| row.result != CheckOutcome::Fail), "{other:?}");
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
            let mut mixed = person.clone();
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            let values = mixed.record.channel_mut(Channel::Cgm);
            values.chunks_mut(within).for_each(|part| part.shuffle(&mut rng));
            mixed
        }
    };
    // Over a fortnight, and within days.
    check("discontinuous_cgm", shuffled(14 * 288));
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
    for therapy in [Therapy::OpenLoopPump, Therapy::Aid, Therapy::Unknown] {
        check("insulin_incomplete", |p| Person {
            therapy,
            ..changed(p, Channel::Basal, |_, _| 0.0)
        });
        // The controllers of these people give boluses: their basal rate alone answers no meal.
        check("insulin_incomplete", |p| Person {
            therapy,
            ..changed(p, Channel::Bolus, |_, _| 0.0)
        });
    }
    for person in embedded() {
        // Injections are no pump.
        let mut injects = Person { therapy: Therapy::Mdi, ..person };
        injects.record.channel_mut(Channel::Basal).fill(None);
        assert!(!checks(&doubts(&injects)).contains(&"insulin_incomplete"), "{}", injects.id);
    }
}

/// The person with insulin of one channel given by the other.
fn moved(person: &Person, from: Channel, amounts: impl Fn(&Person, usize) -> (f64, f64)) -> Person {
    let mut moved = person.clone();
    for k in 0..person.record.len() {
        let (basal, bolus) = amounts(person, k);
        moved.record.channel_mut(Channel::Basal)[k] = Some(basal);
        moved.record.channel_mut(Channel::Bolus)[k] = Some(bolus);
    }
    let other = if from == Channel::Basal { Channel::Bolus } else { Channel::Basal };
    assert!(moved.record.channel(other).iter().flatten().any(|dose| *dose > 0.0));
    Person { therapy: Therapy::Aid, ..moved }
}

#[test]
fn a_controller_may_give_all_insulin_as_boluses_or_as_basal() {
    for person in embedded() {
        let doses = |p: &Person, k: usize| {
            (p.record.basal()[k].unwrap_or(0.0), p.record.bolus()[k].unwrap_or(0.0))
        };
        let boluses = moved(&person, Channel::Basal, |p, k| {
            let (basal, bolus) = doses(p, k);
            (0.0, bolus + basal / 12.0)
        });
        let rates = moved(&person, Channel::Bolus, |p, k| {
            let (basal, bolus) = doses(p, k);
            (basal + 12.0 * bolus, 0.0)
        });
        // Two days on which nothing was recorded are not two days without insulin.
        let mut gap = boluses.clone();
        for channel in [Channel::Basal, Channel::Bolus] {
            gap.record.channel_mut(channel)[5 * 288..7 * 288].fill(None);
        }
        for sound in [boluses, rates, gap] {
            let found = doubts(&sound);
            assert!(!checks(&found).contains(&"insulin_incomplete"), "{}: {found:?}", sound.id);
        }
    }
}

#[test]
fn meals_moved_by_half_a_day_are_a_clock() {
    for hours in [-12, 12] {
        for person in embedded() {
            let found = doubts(&late(&person, &MEALS, 60 * hours, 0));
            let case = format!("{} {hours}: {found:?}", person.id);
            let (value, lower, upper) = estimate(&found, "meal_clock_offset").expect(&case);
            assert!((value.abs() - 720.0).abs() <= 15.0 && lower < upper, "{case}");
            assert!(found.iter().all(|f| f.consequence == Consequence::ExcludePerson), "{case}");
        }
    }
}

#[test]
fn drawn_lines_are_no_readings() {
    check("interpolated_cgm", |person| {
        // A reading every four hours, and lines between: 98 % of the values.
        let old = person.record.cgm().to_vec();
        changed(person, Channel::Cgm, |k, _| {
            let (from, to) = (k / 48 * 48, (k / 48 * 48 + 48).min(old.len() - 1));
            let read = |k: usize| old[k].unwrap_or(120.0);
            let part = (k - from) as f64 / (to - from).max(1) as f64;
            read(from) + part * (read(to) - read(from))
        })
    });
}

#[test]
fn two_sensors_over_the_whole_record_are_named() {
    check("interleaved_cgm", |p| {
        changed(p, Channel::Cgm, |k, glucose| if k % 2 == 1 { glucose + 60.0 } else { glucose })
    });
}

#[test]
fn hours_of_two_sensors_and_finger_sticks_are_not_used() {
    let person = &embedded()[0];
    let faulty = changed(person, Channel::Cgm, |k, glucose| {
        if k < 2 * 288 && k % 2 == 1 { glucose + 25.0 } else { glucose }
    });
    let cohort = Cohort { people: vec![faulty] };
    let data = in_use(cohort.people.clone());
    let table = &data.table().people[0];
    assert_eq!(table.left_out, None);
    let channel = &table.channels_left_out[0];
    assert_eq!(
        (channel.channel.as_str(), channel.reason.as_str()),
        ("cgm_mg_dl", "interleaved_cgm")
    );
    assert!(!table.days_left_out.is_empty(), "{table:?}");
    assert!(table.days_left_out.iter().all(|day| day.reason == "interleaved_cgm"), "{table:?}");
    let used = data.used(&cohort).people.remove(0);
    let left = used.record.cgm()[..2 * 288].iter().flatten().count();
    assert!(left < 192, "{left} readings of two days");
    assert_eq!(used.record.cgm()[3 * 288..], person.record.cgm()[3 * 288..]);
}

#[test]
fn sound_people_are_used_as_they_are_recorded() {
    let cohort = Cohort { people: embedded() };
    let data = in_use(cohort.people.clone());
    for (used, person) in data.used(&cohort).people.iter().zip(&cohort.people) {
        for channel in Channel::ALL {
            let pairs = used.record.channel(channel).iter().zip(person.record.channel(channel));
            let changed: Vec<_> = pairs.enumerate().filter(|(_, (a, b))| a != b).collect();
            assert!(changed.is_empty(), "{} {}: {changed:?}", used.id, channel.name());
        }
    }
    for person in &data.table().people {
        let names: Vec<&str> = person.checks.iter().map(|row| row.check.as_str()).collect();
        assert_eq!(names, [&CHECKS[..], &["enough_data"]].concat());
        assert!(person.channels_left_out.is_empty(), "{person:?}");
    }
}

#[test]
fn of_the_reference_people_only_known_faults_leave_somebody_out() {
    for (format, name) in [(ImportFormat::HupaUcm, "hupa_ucm"), (ImportFormat::T1dUom, "t1d_uom")] {
        let Some(folder) = reference_data::find(name, "people in use") else { continue };
        let data = in_use(import(format, &folder).expect("imports").cohort.people);
        for (id, reason) in data.left_out() {
            let known = match id {
                // 98 % of the values on lines, three quarters of them longer than 25 min.
                "HUPA0009P" => "interpolated_cgm: ",
                "HUPA0019P" | "2310" => "no carbohydrate on record",
                _ => "",
            };
            assert!(!known.is_empty() && reason.starts_with(known), "{id}: {reason}");
        }
        let expected = if format == ImportFormat::HupaUcm { 2 } else { 1 };
        assert_eq!(data.left_out().count(), expected, "{name}");
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
    // Three times, in parts, under other dates and with other doses.
    let one = &embedded()[0];
    let parts = (0..3).map(|k| {
        let record = one.record.slice(50 * k..one.record.len() - 100).expect("inside the record");
        let part = Person { id: format!("part {k}"), record, ..one.clone() };
        changed(&part, Channel::Bolus, |_, dose| dose + 0.1 * k as f64)
    });
    let parts = Cohort { people: parts.collect() };
    assert_eq!(identical_people(&parts), Some(("part 0", "part 1")));
    let refused = InUse::of(&parts, &InclusionRule::working()).expect_err("one person");
    assert!(refused.to_string().contains("part 0 and part 1 have the same readings"), "{refused}");
    // Two flat lines are no person's, and no one person's either.
    let flat = |p: &Person| changed(p, Channel::Cgm, |_, _| 120.0);
    let flat = Cohort { people: embedded().iter().map(flat).collect() };
    assert_eq!(identical_people(&flat), None);
}
