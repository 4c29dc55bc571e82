//! Recorded days lived again.

use chrono::NaiveDate;
use cohort::{Channel, Person};
use world::replayed::{NotReplayed, Replayed, ReplayedPerson, available};
use world::{Amplitudes, Calendar, Effect, Generator, Regime, VirtualPerson};

/// Two weeks of a made person, the record cut to begin at 10:05, with gaps.
fn recorded() -> Person {
    let person = VirtualPerson::sample(31, 4, Regime::OpenLoopPump).expect("a person");
    let calendar = Calendar::new(NaiveDate::from_ymd_opt(2024, 1, 8).expect("a date"), 14);
    let mut person = person.live(calendar).expect("two weeks").recorded;
    let end = person.record.len();
    person.record = person.record.slice(121..end - 30).expect("inside");
    person.record.channel_mut(Channel::Cgm)[500..600].fill(None);
    person.record.channel_mut(Channel::Basal)[900..912].fill(None);
    person
}

fn fit(generator: Generator, person: &Person, amplitudes: Amplitudes) -> ReplayedPerson {
    ReplayedPerson::fit(generator, 8, 0, person, amplitudes).expect("a body fits")
}

#[test]
fn everything_but_the_readings_is_as_recorded() {
    let original = recorded();
    for generator in Generator::ALL {
        let replayed = fit(generator, &original, Amplitudes::NONE);
        assert_eq!(replayed.body.generator(), generator);
        let days = replayed.live().expect("two weeks");
        assert_eq!(days.recorded.record.start(), original.record.start());
        for channel in Channel::ALL {
            let (new, old) =
                (days.recorded.record.channel(channel), original.record.channel(channel));
            if channel == Channel::Cgm {
                assert!(new != old);
                assert!(new.iter().zip(old).all(|(new, old)| new.is_some() == old.is_some()));
            } else {
                assert!(new == old, "{channel:?}");
            }
        }
        assert_eq!(days.glucose.len(), original.record.len());
        // What acted is what was recorded; a counting error is always there.
        for (step, input) in days.inputs.iter().enumerate() {
            assert_eq!(Some(input.bolus.0), original.record.bolus()[step]);
            if let Some(rate) = original.record.basal()[step] {
                assert_eq!(input.basal.0, rate);
            }
            let logged = original.record.carbs()[step].expect("always recorded");
            assert_eq!(input.carbs.0 > 0.0, logged > 0.0, "step {step}");
        }
    }
}

#[test]
fn glucose_is_believable_on_doses_that_were_given_to_another_body() {
    let original = recorded();
    let mean = |person: &Person| {
        let readings: Vec<f64> = person.record.cgm().iter().flatten().copied().collect();
        readings.iter().sum::<f64>() / readings.len() as f64
    };
    for generator in Generator::ALL {
        for amplitudes in [Amplitudes::NONE, Amplitudes::NONE.with(Effect::Dawn, 1.2)] {
            let days = fit(generator, &original, amplitudes).live().expect("two weeks");
            let (new, old) = (mean(&days.recorded), mean(&original));
            // The search ends within 15 mg/dL, and sensors err by up to a tenth.
            assert!((new - old).abs() < 30.0, "{generator:?}: {new} for {old}");
            let within = days.glucose.iter().filter(|g| (40.0..=400.0).contains(&g.0)).count();
            assert!(within as f64 > 0.97 * days.glucose.len() as f64, "{generator:?}: {within}");
        }
    }
}

#[test]
fn a_replay_is_the_same_for_the_same_seed_and_differs_in_an_effect_alone() {
    let original = recorded();
    let amplitudes = Amplitudes::NONE.with(Effect::Exercise, 1.0);
    let with = fit(Generator::Padova, &original, amplitudes);
    assert_eq!(with, fit(Generator::Padova, &original, amplitudes));
    let off = ReplayedPerson { amplitudes: Amplitudes::NONE, ..with.clone() };
    let (with, off) = (with.live().expect("days"), off.live().expect("days"));
    assert!(with.glucose != off.glucose && with.life == off.life);
    // Until the first session nothing differs.
    let first = with.life.sessions.first().expect("sessions are found").start - 121;
    assert!(with.glucose[..=first] == off.glucose[..=first]);
    assert!(with.inputs == off.inputs);
}

#[test]
fn sessions_and_nights_are_found_in_the_record() {
    let person = VirtualPerson::sample(31, 4, Regime::OpenLoopPump).expect("a person");
    let calendar = Calendar::new(NaiveDate::from_ymd_opt(2024, 1, 8).expect("a date"), 14);
    let lived = person.live(calendar).expect("two weeks");
    let found = fit(Generator::Hovorka, &lived.recorded, Amplitudes::NONE).live().expect("days");
    let in_record = lived.life.sessions.iter().filter(|s| {
        // Sessions that the wearable saw: it is off for an hour now and then.
        (s.start..s.start + s.steps).all(|k| lived.life.wearable.heart_rate[k].is_some())
    });
    let (mut seen, mut all) = (0, 0);
    for session in in_record {
        all += 1;
        let near = |found: usize| found.abs_diff(session.start) <= 3;
        seen += usize::from(found.life.sessions.iter().any(|s| near(s.start)));
    }
    // Sessions at the lower end of what counts as exercise stay below the threshold.
    assert!(all >= 4 && 3 * seen >= 2 * all, "{seen} of {all}");
    assert!(found.life.sessions.len() <= lived.life.sessions.len() + 3);
    let near = found.life.nights.iter().zip(&lived.life.nights).filter(|(found, true_)| {
        (found.wake - true_.wake).abs() <= 3 && (found.onset - true_.onset).abs() <= 3
    });
    assert!(near.count() >= 11); // of 14 whole nights; one in fifteen was not worn
}

#[test]
fn what_cannot_be_replayed_is_said() {
    let original = recorded();
    let mut without_basal = original.clone();
    without_basal.record.channel_mut(Channel::Basal).fill(None);
    let mut unlogged = original.clone();
    unlogged.record.channel_mut(Channel::Carbs).fill(None);
    let mut short = original.clone();
    short.record = short.record.slice(0..400).expect("inside");
    let mut drowned = original.clone();
    for bolus in drowned.record.channel_mut(Channel::Bolus).iter_mut().step_by(500) {
        *bolus = Some(60.0);
    }
    let reason = |person: &Person| {
        ReplayedPerson::fit(Generator::Hovorka, 8, 0, person, Amplitudes::NONE)
            .expect_err("it cannot be replayed")
    };
    assert!(matches!(reason(&without_basal), NotReplayed::NoBasal { .. }));
    assert!(matches!(reason(&unlogged), NotReplayed::NoCarbohydrate { .. }));
    assert!(matches!(reason(&short), NotReplayed::TooShort { .. }));
    let why = reason(&drowned);
    assert!(matches!(why, NotReplayed::NoBody { .. }), "{why}");
}

#[test]
fn effects_need_the_channels_that_they_act_through() {
    let mut person = recorded();
    let of = |person: &Person| available(person);
    let all = of(&person);
    assert!(!all.contains(&Effect::Alcohol));
    for effect in [Effect::Exercise, Effect::SetAgeing, Effect::Dawn, Effect::CarbMiscount] {
        assert!(all.contains(&effect), "{effect:?}");
    }
    for (channel, effect) in [
        (Channel::HeartRate, Effect::Exercise),
        (Channel::SleepEfficiency, Effect::SleepLoss),
        (Channel::SetChange, Effect::SetAgeing),
    ] {
        person.record.channel_mut(channel).fill(None);
        assert!(!of(&person).contains(&effect), "{effect:?}");
    }
    assert!(of(&person).contains(&Effect::Dawn));
}

#[test]
fn the_shift_of_an_effect_grows_with_it_and_its_body_stays() {
    let original = recorded();
    let none = Amplitudes::NONE;
    for generator in Generator::ALL {
        let plain = fit(generator, &original, none);
        assert_eq!(plain.shift(&none).expect("days").0, 0.0);
        let mut last = 0.0;
        for amplitude in [0.5, 1.0, 2.0] {
            let with = none.with(Effect::Dawn, amplitude);
            let person = plain.with_amplitudes(with).expect("the body still fits");
            assert_eq!(person.restoring, plain.restoring);
            let shift = person.shift(&none).expect("days").0;
            assert!(shift > last + 1.0, "{generator:?} at {amplitude}: {shift} mg/dL");
            last = shift;
        }
        // An effect on the sensor moves what is shown; true glucose stays.
        let lagging = plain.with_amplitudes(none.with(Effect::SensorLag, 2.0)).expect("fits");
        assert!(lagging.shift(&none).expect("days").0 > 0.5);
    }
}

#[test]
fn miscounted_carbohydrate_is_eaten_and_not_logged() {
    let original = recorded();
    let plain = fit(Generator::Hovorka, &original, Amplitudes::NONE);
    let eaten = |effect: Effect| {
        let amplitudes = Amplitudes::NONE.with(effect, 1.0);
        let days = ReplayedPerson { amplitudes, ..plain.clone() }.live().expect("days");
        assert!(days.recorded.record.carbs() == original.record.carbs());
        days.inputs.iter().map(|input| input.carbs.0 + input.rescue.amount.0).sum::<f64>() / 14.0
    };
    let logged = original.record.carbs().iter().flatten().sum::<f64>() / 14.0;
    let without = eaten(Effect::Dawn);
    // Counts are without bias where no effect acts: within the error of 55 meals, 20 %/sqrt(55),
    // four times.
    assert!((without / logged - 1.0).abs() < 0.12, "{without} for {logged} g a day");
    assert!(eaten(Effect::CarbMiscount) > 1.15 * without); // a median of -28 % and more
    assert!(eaten(Effect::MissedMeals) > without + 3.0); // 0.25 a day of 35 g: 9 g a day
    assert!(eaten(Effect::UnloggedRescueCarbs) > without);
}

#[test]
fn the_label_holds_the_truth_and_the_record_does_not() {
    let original = recorded();
    let amplitudes = Amplitudes::NONE.with(Effect::Dawn, 0.8);
    let person = fit(Generator::Padova, &original, amplitudes);
    let label = serde_json::to_value(person.info()).expect("numbers and names");
    assert_eq!(label["person_id"], original.id);
    assert_eq!(label["generator"], "padova");
    assert_eq!(label["effects"]["dawn"], 0.8);
    assert_eq!(label["restoring"].as_array().map(Vec::len), Some(person.restoring.len()));
    assert!(label["parameters"]["k_max"].as_f64().is_some_and(|k| k > 0.0));
    assert_eq!(person.live().expect("days").recorded.id, original.id);
}

#[test]
fn a_cohort_is_replayed_alike_on_any_number_of_threads() {
    let mut cohort = cohort::Cohort { people: vec![recorded(), recorded(), recorded()] };
    cohort.people[1].id = "without-basal".into();
    cohort.people[1].record.channel_mut(Channel::Basal).fill(None);
    cohort.people[2].id = "other".into();
    let with_threads = |threads| {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads").install(
            || {
                let replayed = Replayed::fit(Generator::Padova, 4, &cohort, Amplitudes::NONE);
                (replayed.cohort().expect("days"), replayed.skipped)
            },
        )
    };
    let (alone, skipped) = with_threads(1);
    assert!((alone.clone(), skipped.clone()) == with_threads(3));
    assert_eq!(alone.people.len(), 2);
    assert_eq!(skipped[0].0, "without-basal");
    // The same record, but another body and other sensors.
    assert!(alone.people[0].record.cgm() != alone.people[1].record.cgm());
}
