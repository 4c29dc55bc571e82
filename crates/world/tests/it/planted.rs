//! What is planted into a record, and what stays unchanged.

use std::path::Path;

use cohort::{Channel, Cohort, Person};
use world::planted::{Planting, Truth, plant};

/// A week of each person of the embedded cohort.
fn people() -> Cohort {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/embedded/cohort");
    let cohort = cohort::read_folder(&folder).expect("the embedded cohort reads");
    let week = |person: Person| {
        let record = person.record.slice(0..7 * 288).expect("inside the record");
        Person { record, ..person }
    };
    Cohort { people: cohort.people.into_iter().map(week).collect() }
}

/// The channels that a planting may change.
fn touched(planting: Planting) -> Vec<Channel> {
    use Planting::*;
    match planting {
        MissedMeals | CarbMiscount | UnloggedRescueCarbs | SlowMeals => vec![Channel::Carbs],
        SetFailure | SetAgeing | InsulinAbsorption => vec![Channel::Basal, Channel::Bolus],
        LateBoluses => vec![Channel::Bolus],
        SensorLag | SensorDrift | CompressionLows => vec![Channel::Cgm],
        ExerciseStruck | ExerciseMoved => vec![Channel::HeartRate, Channel::Steps],
        SleepStruck | SleepMoved => vec![Channel::SleepEfficiency],
    }
}

fn sum(person: &Person, channel: Channel) -> f64 {
    person.record.channel(channel).iter().flatten().sum()
}

fn size(planting: Planting, times: f64) -> f64 {
    times * planting.usual_size().0
}

#[test]
fn only_the_channels_of_a_planting_change_and_what_was_missing_stays_missing() {
    let cohort = people();
    for planting in Planting::ALL {
        let planted = plant(&cohort, planting, size(planting, 2.0), 7);
        let touched = touched(planting);
        let mut differ = 0;
        for (before, after) in cohort.people.iter().zip(&planted.cohort.people) {
            assert_eq!((&before.id, before.weight), (&after.id, after.weight));
            assert_eq!(before.record.start(), after.record.start());
            for channel in Channel::ALL {
                let pairs =
                    before.record.channel(channel).iter().zip(after.record.channel(channel));
                let changed = pairs.clone().filter(|(a, b)| a != b).count();
                differ += changed;
                assert!(changed == 0 || touched.contains(&channel), "{planting:?} {channel:?}");
                let struck = matches!(planting, Planting::ExerciseStruck | Planting::SleepStruck);
                let moved = matches!(planting, Planting::ExerciseMoved | Planting::SleepMoved);
                if !(struck || moved) {
                    let same = pairs.clone().all(|(a, b)| a.is_some() == b.is_some());
                    assert!(same, "{planting:?} {channel:?}");
                }
                for value in after.record.channel(channel).iter().flatten() {
                    assert!(value.is_finite() && *value >= 0.0, "{planting:?} {channel:?} {value}");
                }
            }
        }
        assert_eq!(planted.changed, differ, "{planting:?}");
        let struck = matches!(planting, Planting::MissedMeals | Planting::UnloggedRescueCarbs);
        let now_and_then = struck || planting == Planting::SetFailure;
        assert_eq!(planted.happenings.is_some(), now_and_then, "{planting:?}");
        if let Some(happenings) = planted.happenings {
            assert!(happenings.count <= happenings.places, "{planting:?} {happenings:?}");
            assert!(!struck || happenings.count == differ, "{planting:?} {happenings:?}");
        }
        // People of the embedded cohort log rescues seldom, and record what the others need.
        assert!(differ > 0 || planting == Planting::UnloggedRescueCarbs, "{planting:?}");
    }
}

#[test]
fn a_seed_says_what_is_planted() {
    let cohort = people();
    for planting in Planting::ALL {
        let with = |seed| plant(&cohort, planting, size(planting, 1.0), seed);
        assert_eq!(with(7), with(7), "{planting:?}");
        if matches!(planting, Planting::MissedMeals | Planting::SetFailure | Planting::SensorDrift)
        {
            assert_ne!(with(7), with(8), "{planting:?}");
        }
        // One more person changes nothing in those before.
        let fewer = Cohort { people: cohort.people[..2].to_vec() };
        let alone = plant(&fewer, planting, size(planting, 1.0), 7).cohort;
        assert_eq!(alone.people, with(7).cohort.people[..2], "{planting:?}");
    }
}

#[test]
fn a_size_of_nothing_changes_nothing_and_a_larger_one_changes_more() {
    let cohort = people();
    for planting in Planting::ALL.into_iter().filter(|planting| planting.has_sizes()) {
        let distance = |times: f64| -> f64 {
            let planted = plant(&cohort, planting, size(planting, times), 7).cohort;
            let pairs = cohort.people.iter().zip(&planted.people);
            let of_person = |(before, after): (&Person, &Person)| -> f64 {
                let channels = touched(planting).into_iter();
                channels
                    .flat_map(|c| before.record.channel(c).iter().zip(after.record.channel(c)))
                    .filter_map(|(a, b)| Some((a.as_ref()? - b.as_ref()?).abs()))
                    .sum()
            };
            pairs.map(of_person).sum()
        };
        let (none, small, large) = (distance(0.0), distance(1.0), distance(2.0));
        // Rounding of a scaled or moved number.
        assert!(none < 1e-6, "{planting:?}: {none}");
        // A dose that is moved twice as far is the same dose; another test checks how far.
        let moves = matches!(planting, Planting::SlowMeals | Planting::LateBoluses);
        if planting != Planting::UnloggedRescueCarbs {
            let more = large > small || moves;
            assert!(small > 1.0 && more, "{planting:?}: {small} {large}");
        }
    }
}

#[test]
fn meals_struck_are_as_many_as_said() {
    let cohort = people();
    let planted = plant(&cohort, Planting::MissedMeals, 1.0, 7).cohort;
    for (before, after) in cohort.people.iter().zip(&planted.people) {
        let meals = |person: &Person| {
            person.record.carbs().iter().flatten().filter(|grams| **grams >= 15.0).count()
        };
        assert_eq!(meals(before) - meals(after), 7.min(meals(before) / 2), "{}", before.id);
    }
}

#[test]
fn miscounts_keep_the_mean_and_flatten_the_sizes() {
    let cohort = people();
    let planted = plant(&cohort, Planting::CarbMiscount, 0.6, 7).cohort;
    for (before, after) in cohort.people.iter().zip(&planted.people) {
        let (old, new) = (sum(before, Channel::Carbs), sum(after, Channel::Carbs));
        assert!((new / old - 1.0).abs() < 1e-9, "{}", before.id);
        let pairs = before.record.carbs().iter().zip(after.record.carbs());
        let logs: Vec<(f64, f64)> = pairs
            .filter_map(|(a, b)| Some(((*a)?, (*b)?)))
            .filter(|(a, _)| *a > 0.0)
            .map(|(a, b)| (a.ln(), b.ln()))
            .collect();
        let slope = (logs[1].1 - logs[0].1) / (logs[1].0 - logs[0].0);
        let level = (logs[1].0 - logs[0].0).abs() < 1e-9;
        assert!(level || (slope - 1.0 / 1.6).abs() < 1e-9, "{}: {slope}", before.id);
    }
}

#[test]
fn what_arrives_of_raised_insulin_is_what_was_recorded() {
    let cohort = people();
    for (planting, size, shares) in
        [(Planting::SetFailure, 0.5, (0.4, 1.0)), (Planting::SetAgeing, 0.2, (0.3, 1.0))]
    {
        let planted = plant(&cohort, planting, size, 7).cohort;
        for (before, after) in cohort.people.iter().zip(&planted.people) {
            for channel in [Channel::Basal, Channel::Bolus] {
                let pairs =
                    before.record.channel(channel).iter().zip(after.record.channel(channel));
                for (given, recorded) in pairs.filter_map(|(a, b)| Some(((*a)?, (*b)?))) {
                    let share = if recorded > 0.0 { given / recorded } else { 1.0 };
                    let can_be = shares.0 - 1e-9 <= share && share <= shares.1 + 1e-9;
                    assert!(can_be, "{planting:?} {}: {share}", before.id);
                }
            }
        }
    }
}

#[test]
fn moved_doses_are_all_still_there() {
    let cohort = people();
    for (planting, channel) in [
        (Planting::SlowMeals, Channel::Carbs),
        (Planting::LateBoluses, Channel::Bolus),
        (Planting::InsulinAbsorption, Channel::Bolus),
    ] {
        let planted = plant(&cohort, planting, size(planting, 2.0), 7).cohort;
        for (before, after) in cohort.people.iter().zip(&planted.people) {
            let (old, new) = (sum(before, channel), sum(after, channel));
            assert!((old - new).abs() < 1e-6, "{planting:?} {}: {old} {new}", before.id);
            let mean_step = |person: &Person| {
                let doses = person.record.channel(channel).iter().enumerate();
                doses.filter_map(|(k, dose)| Some(k as f64 * (*dose)?)).sum::<f64>() / old
            };
            let earlier = 5.0 * (mean_step(before) - mean_step(after));
            match planting {
                // A part of the doses, moved by 40 and by 30 min.
                Planting::SlowMeals => assert!((0.0..=40.0).contains(&earlier), "{earlier}"),
                Planting::LateBoluses => assert!((1.0..=30.0).contains(&earlier), "{earlier}"),
                _ => {}
            }
        }
    }
}

#[test]
fn truths_are_names_of_the_library_or_none() {
    for planting in Planting::ALL {
        match planting.truth() {
            Truth::Effect(name) => assert_eq!(name, planting.name()),
            Truth::OutsideTheLibrary => assert_eq!(planting, Planting::LateBoluses),
            Truth::EvidenceLost(names) => assert!(!names.is_empty() && !planting.has_sizes()),
        }
    }
}
