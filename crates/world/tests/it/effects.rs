//! Each effect moves glucose in its own way and by its amplitude, and changes nothing else.

use chrono::NaiveDate;
use physiology::STEPS_PER_DAY;
use rayon::prelude::*;
use world::{
    Amplitudes, Background, Calendar, Effect, Generator, LivedDays, OutsideEffect, Port, Regime,
    Shapes, VirtualPerson,
};

fn calendar() -> Calendar {
    Calendar::new(NaiveDate::from_ymd_opt(2024, 1, 8).expect("a date"), 14)
}

/// An effect of either kind.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Switch {
    Named(Effect),
    Outside(OutsideEffect),
}

impl Switch {
    fn all() -> impl Iterator<Item = Self> {
        let named = Effect::ALL.into_iter().map(Self::Named);
        named.chain(OutsideEffect::ALL.into_iter().map(Self::Outside))
    }

    fn at(self, amplitude: f64) -> Amplitudes {
        // One set in thirty fails at amplitude 1 and a person wears five: too few for a test.
        match self {
            Self::Named(Effect::SetFailure) => {
                Amplitudes::NONE.with(Effect::SetFailure, 15.0 * amplitude)
            }
            Self::Named(effect) => Amplitudes::NONE.with(effect, amplitude),
            Self::Outside(effect) => Amplitudes::NONE.with_outside(effect, amplitude),
        }
    }

    fn port(self) -> Port {
        match self {
            Self::Named(effect) => effect.port(),
            Self::Outside(effect) => effect.port(),
        }
    }
}

fn people(generator: Generator) -> Vec<VirtualPerson> {
    so_many(3, generator)
}

fn so_many(people: usize, generator: Generator) -> Vec<VirtualPerson> {
    (0..people)
        .map(|index| {
            VirtualPerson::sample_from(generator, 21, index, Regime::OpenLoopPump)
                .expect("a person")
        })
        .collect()
}

fn with(person: &VirtualPerson, amplitudes: Amplitudes) -> VirtualPerson {
    VirtualPerson { amplitudes, ..person.clone() }
}

fn live(person: &VirtualPerson) -> LivedDays {
    person.live(calendar()).expect("two weeks")
}

/// Glucose as lived less glucose without the effects, step by step; readings for the sensor.
fn moved(person: &VirtualPerson, lived: &LivedDays, port: Port) -> Vec<Option<f64>> {
    let without = person.counterfactual(lived, &Amplitudes::NONE).expect("finite");
    if port == Port::Sensor {
        let shown = lived.recorded.record.cgm();
        return shown.iter().zip(&without.sensed).map(|(a, b)| Some((*a)? - (*b)?.0)).collect();
    }
    lived.glucose.iter().zip(&without.glucose).map(|(a, b)| Some(a.0 - b.0)).collect()
}

fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, n) = values.into_iter().fold((0.0, 0), |(sum, n), v| (sum + v, n + 1));
    sum / f64::from(n)
}

#[test]
fn shifts_grow_with_the_amplitude_from_nothing() {
    for generator in Generator::ALL {
        // So many people that some of their lows are treated without being logged.
        let people = so_many(5, generator);
        Switch::all().collect::<Vec<_>>().into_par_iter().for_each(|switch| {
            let shifts = [0.0, 0.5, 1.0, 2.0].map(|amplitude| {
                mean(people.iter().map(|person| {
                    let person = with(person, switch.at(amplitude));
                    person.shift(&live(&person), &Amplitudes::NONE).expect("finite").0
                }))
            });
            assert_eq!(shifts[0], 0.0, "{switch:?}");
            assert!(shifts.is_sorted_by(|a, b| a < b), "{generator:?} {switch:?}: {shifts:?}");
            assert!(shifts[2] > 0.05, "{generator:?} {switch:?}: {shifts:?}");
        });
    }
}

/// What is compared to find a shift is what a record would hold: between readings that are 15 min apart, a line.
#[test]
fn a_counterfactual_of_the_same_life_shows_its_record() {
    let mut of_15_min = 0;
    for seed in 0..6 {
        let person =
            VirtualPerson::sample_widely(Generator::Saturating, seed, 0, Regime::OpenLoopPump)
                .expect("a person");
        of_15_min += usize::from(person.everyday.sensor.noise == world::Noise::Quarterly);
        let lived = live(&person);
        let again = person.counterfactual(&lived, &person.amplitudes).expect("finite");
        for (shown, again) in lived.recorded.record.cgm().iter().zip(&again.sensed) {
            assert_eq!(shown.is_some(), again.is_some(), "world {seed}");
            // Readings are rounded before lines are drawn through them, and then again.
            let far = shown.zip(*again).map_or(0.0, |(shown, again)| (shown - again.0).abs());
            assert!(far <= 1.0, "world {seed}: {far} mg/dL");
        }
    }
    assert!(of_15_min > 0, "no sensor of 15 min among these");
}

#[test]
fn glucose_moves_the_right_way() {
    use Effect::{
        Alcohol, CarbMiscount, CompressionLows, CounterRegulation, Dawn, Exercise, MissedMeals,
        PostExerciseSensitivity, SensorDrift, SetAgeing, SetFailure, SleepLoss,
        UnloggedRescueCarbs,
    };
    use OutsideEffect::{
        FattyEvenings, HardenedSites, Illness, LateProtein, MenstrualCycle, Paracetamol, Stress,
    };
    let up = [Dawn, SleepLoss, SetAgeing, SetFailure, CarbMiscount, MissedMeals];
    let up = up.into_iter().chain([UnloggedRescueCarbs, CounterRegulation]).map(Switch::Named);
    let up = up.chain(
        [Stress, MenstrualCycle, Illness, LateProtein, FattyEvenings, HardenedSites, Paracetamol]
            .map(Switch::Outside),
    );
    let down = [Exercise, PostExerciseSensitivity, Alcohol, SensorDrift, CompressionLows];
    let down = down.map(Switch::Named);
    let cases: Vec<_> = up.map(|s| (s, 1.0)).chain(down.map(|s| (s, -1.0))).collect();
    for generator in Generator::ALL {
        let people = people(generator);
        for &(switch, sign) in &cases {
            let change = mean(people.iter().flat_map(|person| {
                let person = with(person, switch.at(1.0));
                let moved = moved(&person, &live(&person), switch.port());
                moved.into_iter().flatten().collect::<Vec<_>>()
            }));
            assert!(sign * change > 0.02, "{generator:?} {switch:?}: {change} mg/dL");
        }
    }
}

/// Mean change in the hours after a clock hour.
fn change_after(person: &VirtualPerson, switch: Switch, hour: f64, hours: f64) -> f64 {
    let lived = live(person);
    let moved = moved(person, &lived, switch.port());
    let from = (hour.rem_euclid(24.0) * 12.0) as usize;
    let within = |step: &usize| {
        (step % STEPS_PER_DAY + STEPS_PER_DAY - from) % STEPS_PER_DAY < (12.0 * hours) as usize
    };
    mean((0..moved.len()).filter(within).filter_map(|step| moved[step]))
}

#[test]
fn circadian_action_raises_glucose_about_its_trough() {
    let switch = Switch::Named(Effect::CircadianSensitivity);
    for person in people(Generator::Hovorka) {
        let person = with(&person, switch.at(1.0));
        let trough = person.shapes.circadian.trough_hour;
        let (at, away) = (
            change_after(&person, switch, trough, 6.0),
            change_after(&person, switch, trough + 12.0, 6.0),
        );
        assert!(at > away + 3.0, "trough at {trough}: {at} and {away} mg/dL");
    }
}

#[test]
fn a_bath_takes_insulin_from_the_night_to_the_evening() {
    let switch = Switch::Outside(OutsideEffect::HotBath);
    for person in people(Generator::Hovorka) {
        let person = with(&person, switch.at(1.0));
        let (evening, night) =
            (change_after(&person, switch, 20.5, 2.5), change_after(&person, switch, 2.0, 4.0));
        assert!(evening < -0.5 && night > 0.5, "{evening} and {night} mg/dL");
    }
}

#[test]
fn slow_guts_lower_glucose_early_after_meals() {
    let slow = [Switch::Named(Effect::SlowMeals), Switch::Outside(OutsideEffect::SlowStomach)];
    for switch in slow {
        for person in people(Generator::Hovorka) {
            let person = with(&person, switch.at(1.0));
            let lived = live(&person);
            let moved = moved(&person, &lived, switch.port());
            let rich = lived.life.meals.iter().filter(|m| m.richness > 0.0);
            let early: Vec<f64> =
                rich.filter_map(|m| moved.get(m.step + 12).copied().flatten()).collect();
            assert!(mean(early.iter().copied()) < -1.0, "{switch:?}: {early:?}");
        }
    }
}

#[test]
fn kidneys_with_a_higher_threshold_keep_glucose_and_others_lose_it() {
    let switch = Switch::Named(Effect::RenalThreshold);
    for person in people(Generator::Hovorka) {
        let person = with(&person, switch.at(1.0));
        let lived = live(&person);
        let change = mean(moved(&person, &lived, switch.port()).into_iter().flatten());
        assert!(change * person.shapes.renal.threshold > 0.0, "{change} mg/dL");
    }
}

#[test]
fn a_lagging_sensor_reads_low_in_a_rise_and_high_in_a_fall() {
    let switch = Switch::Named(Effect::SensorLag);
    for person in people(Generator::Hovorka) {
        let person = with(&person, switch.at(1.0));
        let lived = live(&person);
        let moved = moved(&person, &lived, switch.port());
        let slope = |step: usize| lived.glucose[step].0 - lived.glucose[step - 6].0;
        let when = |pick: &dyn Fn(f64) -> bool| {
            mean((6..moved.len()).filter(|s| pick(slope(*s))).filter_map(|s| moved[s]))
        };
        let (rising, falling) = (when(&|s| s > 20.0), when(&|s| s < -20.0));
        // 20 mg/dL in half an hour and a lag of 4.5 min or more: 3 mg/dL.
        assert!(rising < -3.0 && falling > 3.0, "{rising} {falling} mg/dL");
    }
}

#[test]
fn insulin_is_absorbed_faster_on_some_days_and_slower_on_others() {
    let switch = Switch::Named(Effect::InsulinAbsorption);
    let person = with(&people(Generator::Hovorka)[0], switch.at(1.0));
    let lived = live(&person);
    let moved = moved(&person, &lived, switch.port());
    let by_day: Vec<f64> =
        moved.chunks(STEPS_PER_DAY).map(|day| mean(day.iter().flatten().copied())).collect();
    assert!(by_day.iter().any(|d| *d > 1.0) && by_day.iter().any(|d| *d < -1.0), "{by_day:?}");
}

#[test]
fn an_effect_that_is_off_has_no_form() {
    for generator in Generator::ALL {
        for regime in [Regime::OpenLoopPump, Regime::Aid] {
            let person = VirtualPerson::sample_from(generator, 22, 1, regime).expect("a person");
            let person = with(&person, Amplitudes::NONE);
            let typical = VirtualPerson { shapes: Shapes::TYPICAL, ..person.clone() };
            assert_ne!(person.shapes, typical.shapes);
            assert!(live(&person) == live(&typical));
        }
    }
}

#[test]
fn worlds_with_and_without_an_effect_share_every_chance() {
    let person = with(&people(Generator::Hovorka)[2], Amplitudes::NONE);
    let null = live(&person);
    for switch in Switch::all() {
        let lived = live(&with(&person, switch.at(1.0)));
        assert!(lived.life == null.life, "{switch:?}");
        let (a, b) = (&lived.recorded.record, &null.recorded.record);
        assert!(a.heart_rate() == b.heart_rate() && a.set_change() == b.set_change());
        assert!(a.cgm().iter().zip(b.cgm()).all(|(x, y)| x.is_some() == y.is_some()));
        // The sensor adds the same noise, so the two readings differ by what the effect does to
        // glucose and to the sensor. The counterfactual of the one is the input of the other.
        let replayed = person.counterfactual(&null, &Amplitudes::NONE).expect("finite");
        assert!(replayed.glucose == null.glucose);
        let shown = replayed.sensed.iter().zip(b.cgm());
        assert!(shown.into_iter().all(|(x, y)| x.map(|x| x.0.round()) == *y));
    }
}

#[test]
fn counting_errs_without_bias_in_a_null_world_and_low_with_the_effect() {
    let ratios = |amplitude: f64, background: Background, large: bool| {
        let people = (0..12).map(|index| {
            let person = VirtualPerson::sample(23, index, Regime::OpenLoopPump).expect("drawn");
            let amplitudes = Amplitudes::NONE.with(Effect::CarbMiscount, amplitude);
            VirtualPerson { amplitudes, background, ..person }
        });
        let mut ratios: Vec<f64> = Vec::new();
        for person in people {
            let lived = live(&person);
            let logged = lived.recorded.record.carbs();
            for meal in lived.life.meals.iter().filter(|m| m.eaten.0 > 25.0) {
                // Alone in its step: nothing was eaten against a low or before exercise.
                let alone = lived.inputs[meal.step].carbs == meal.eaten
                    && lived.inputs[meal.step].rescue.amount.0 == 0.0;
                if alone && (meal.eaten.0 > 80.0) == large {
                    ratios.push(logged[meal.step].expect("always recorded") / meal.eaten.0);
                }
            }
        }
        ratios.sort_by(f64::total_cmp);
        ratios
    };
    let null = ratios(0.0, Background::REALISTIC, false);
    let n = null.len() as f64;
    assert!(n > 250.0, "{n}");
    let average = mean(null.iter().copied());
    let sd = mean(null.iter().map(|r| (r - average).powi(2))).sqrt();
    // Draws beyond two standard deviations are cut: 0.2 becomes 0.19. Four standard errors.
    assert!((average - 1.0).abs() < 4.0 * 0.2 / n.sqrt() + 0.005, "{average}");
    assert!((0.16..0.22).contains(&sd), "{sd}");
    let exact = ratios(0.0, Background::ERRORS_IN_EFFECT, false);
    assert!(exact.iter().all(|r| (r - 1.0).abs() < 0.5 / 25.0)); // whole grams
    let median = |ratios: &[f64]| ratios[ratios.len() / 2];
    let (ordinary, large) = (
        median(&ratios(1.0, Background::REALISTIC, false)),
        median(&ratios(1.0, Background::REALISTIC, true)),
    );
    // Medians of some hundred counts with a spread of a quarter, and of twelve biases with 20 %.
    assert!((ordinary - 0.72).abs() < 0.07, "{ordinary}");
    assert!((large - 0.66).abs() < 0.07 && large < ordinary, "{large}");
}

#[test]
fn a_tenth_more_sets_fail_for_three_amplitudes_more() {
    let failing = |amplitude: f64| {
        let amplitudes = Amplitudes::NONE.with(Effect::SetFailure, amplitude);
        let (mut failed, mut sets) = (0.0, 0.0);
        for index in 0..10 {
            let person = VirtualPerson::sample(24, index, Regime::OpenLoopPump).expect("drawn");
            let calendar = Calendar::new(calendar().start(), 84);
            let life = world::Life::sample(&person.habits, calendar, 24, index);
            let happenings = world::Happenings::sample(&life, 24, index);
            let course = world::conditions(&life, &happenings, &person.shapes, &amplitudes);
            let starts = |step: usize| {
                course[step].bioavailability < 0.3 && course[step - 1].bioavailability == 1.0
            };
            failed += (1..course.len()).filter(|step| starts(*step)).count() as f64;
            sets += happenings.set_failures.len() as f64;
        }
        failed / sets
    };
    // 280 sets: standard errors of 1.1 % and 2.8 %, three of them.
    assert!((failing(1.0) - 0.033).abs() < 0.033, "{}", failing(1.0));
    assert!((failing(10.0) - 0.33).abs() < 0.084, "{}", failing(10.0));
    assert_eq!(failing(0.0), 0.0);
}
