//! Every effect can be switched off with all else equal.

use chrono::NaiveDate;
use physiology::STEPS_PER_HOUR;
use world::{Calendar, Effect, LivedDays, Port, Regime, Shapes, VirtualPerson};

fn calendar() -> Calendar {
    Calendar::new(NaiveDate::from_ymd_opt(2024, 1, 8).expect("a date"), 28)
}

fn person(regime: Regime) -> VirtualPerson {
    let person = VirtualPerson::sample(17, 3, regime).expect("a person");
    // Every third set fails, so that one does in four weeks.
    let amplitudes = person.amplitudes.with(Effect::SetFailure, 10.0);
    VirtualPerson { amplitudes, shapes: Shapes::TYPICAL, ..person }
}

fn without(person: &VirtualPerson, effect: Effect) -> VirtualPerson {
    VirtualPerson { amplitudes: person.amplitudes.without(effect), ..person.clone() }
}

/// Mean reading between two hours of the day, mg/dL.
fn mean_between(days: &LivedDays, from: usize, to: usize) -> f64 {
    let hours = from * STEPS_PER_HOUR..to * STEPS_PER_HOUR;
    let within: Vec<f64> = days
        .recorded
        .record
        .cgm()
        .iter()
        .enumerate()
        .filter(|(step, _)| hours.contains(&(step % physiology::STEPS_PER_DAY)))
        .filter_map(|(_, reading)| *reading)
        .collect();
    within.iter().sum::<f64>() / within.len() as f64
}

#[test]
fn each_effect_acts_and_changes_nothing_that_chance_brings() {
    let person = person(Regime::OpenLoopPump);
    let with = person.live(calendar()).expect("four weeks");
    for effect in Effect::ALL {
        let off = without(&person, effect).live(calendar()).expect("four weeks");
        let (a, b) = (&with.recorded.record, &off.recorded.record);
        let acts = match effect {
            Effect::UnloggedRescueCarbs => with.glucose == off.glucose && a.carbs() != b.carbs(),
            _ if effect.port() == Port::Sensor => a.cgm() != b.cgm(),
            _ => with.glucose != off.glucose,
        };
        assert!(acts, "{} does nothing, or what it should not", effect.name());
        assert!(with.life == off.life, "{} changes the life", effect.name());
        assert!(a.heart_rate() == b.heart_rate() && a.set_change() == b.set_change());
        for (x, y) in a.cgm().iter().zip(b.cgm()) {
            assert_eq!(x.is_some(), y.is_some(), "{} changes lost readings", effect.name());
        }
    }
}

#[test]
fn dawn_shows_in_the_readings_of_the_morning() {
    for regime in [Regime::OpenLoopPump, Regime::Aid] {
        let person = person(regime);
        let with = person.live(calendar()).expect("four weeks");
        let off = without(&person, Effect::Dawn).live(calendar()).expect("four weeks");
        let difference = |from, to| mean_between(&with, from, to) - mean_between(&off, from, to);
        let morning = difference(3, 8);
        let evening = difference(20, 24);
        assert!(morning > 5.0, "{regime:?}: {morning} mg/dL in the morning");
        assert!(morning > 2.0 * evening.abs(), "{regime:?}: {morning} and {evening} mg/dL");
    }
}

#[test]
fn exercise_lowers_glucose_in_its_sessions() {
    let person = person(Regime::OpenLoopPump);
    let with = person.live(calendar()).expect("four weeks");
    let off = without(&person, Effect::Exercise).live(calendar()).expect("four weeks");
    let fall = |days: &LivedDays| {
        let falls: Vec<f64> = days
            .life
            .sessions
            .iter()
            .filter(|s| s.start + s.steps < days.glucose.len())
            .map(|s| days.glucose[s.start].0 - days.glucose[s.start + s.steps].0)
            .collect();
        falls.iter().sum::<f64>() / falls.len() as f64
    };
    assert!(fall(&with) > fall(&off) + 15.0, "{} and {}", fall(&with), fall(&off));
}

#[test]
fn a_person_without_any_effect_is_still_alive() {
    let mut person = person(Regime::Aid);
    person.amplitudes = world::Amplitudes::NONE;
    let days = person.live(calendar()).expect("four weeks");
    assert!(days.glucose.iter().all(|g| (20.0..600.0).contains(&g.0)));
}
