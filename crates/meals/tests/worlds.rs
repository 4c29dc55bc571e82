//! Detection and reconciliation of people whose meals are known, end to end.
//!
//! The people come from `world`, which this crate does not know. `cargo xtask bench --what meals`
//! measures on more of them; bounds here lie well outside of what it prints, so that they fail for
//! a fault and not for a change of a digit.

use chrono::NaiveDate;
use cohort::{Channel, Cohort, Person};
use meals::reconcile::{
    EventKind, Fate, ReconcileSettings, Rule, logged, reconcile, reconcile_cohort,
};
use meals::score::{Eaten, Score, Tally, Tolerance, sittings};
use meals::{Detected, Detector, GridSettings, PlantSettings};
use world::{Amplitudes, Calendar, Effect, Generator, Regime, VirtualPerson};

/// Seed of the people; another one than that of the thresholds.
const SEED: u64 = 4_711;
const DAYS: usize = 7;

const PLANT: Detector = Detector::Plant(PlantSettings::working());
const GRID: Detector = Detector::Grid(GridSettings::published());

/// Two people of each of two generators with what they ate; `missed` is the amplitude of missed meals.
fn people(missed: f64) -> Vec<(Person, Vec<Eaten>)> {
    let calendar = Calendar::new(NaiveDate::from_ymd_opt(2024, 1, 8).expect("a date"), DAYS);
    let mut people = Vec::new();
    for generator in [Generator::Hovorka, Generator::Padova] {
        for (index, regime) in [(0, Regime::Aid), (1, Regime::OpenLoopPump)] {
            let person = VirtualPerson::sample_from(generator, SEED, index, regime)
                .expect("a body can be drawn");
            let amplitudes = Amplitudes::NONE.with(Effect::MissedMeals, missed);
            let days = VirtualPerson { amplitudes, ..person }.live(calendar).expect("days");
            let eaten = days.inputs.iter().map(|i| i.carbs.0 + i.rescue.amount.0);
            let truth = sittings(eaten);
            let id = format!("{}-{}", generator.name(), days.recorded.id);
            people.push((Person { id, ..days.recorded }, truth));
        }
    }
    people
}

fn log(person: &Person) -> Vec<Eaten> {
    sittings(person.record.carbs().iter().map(|grams| grams.unwrap_or(0.0)))
}

fn claimed(found: &Detected) -> Vec<Eaten> {
    found.meals.iter().map(|m| Eaten { step: m.step, carbs: m.carbs }).collect()
}

fn score(people: &[(Person, Vec<Eaten>)], claims: impl Fn(&Person) -> Vec<Eaten>) -> Score {
    let tally = |(person, truth): &(Person, Vec<Eaten>)| {
        Tally::of(truth, &claims(person), person.record.len(), Tolerance::usual())
    };
    people.iter().map(tally).fold(Tally::default(), Tally::merge).score()
}

fn found(detector: &Detector, person: &Person) -> Detected {
    detector.detect(person).expect("a record that can be")
}

fn mended(person: &Person, rule: Rule) -> Person {
    reconcile(person, &found(&PLANT, person), &ReconcileSettings::new(rule)).expect("mended").person
}

#[test]
fn the_plant_finds_more_meals_than_the_rate_of_rise_and_knows_when() {
    let people = people(0.0);
    let grid = score(&people, |person| claimed(&found(&GRID, person)));
    let plant = score(&people, |person| claimed(&found(&PLANT, person)));
    let (g, p) = (grid.sensitivity.expect("meals"), plant.sensitivity.expect("meals"));
    assert!(p > g + 0.1, "{p} {g}");
    assert!(p > 0.55, "{p}");
    for score in [&grid, &plant] {
        assert!(score.false_per_day.is_some_and(|rate| rate < 0.6), "{score:?}");
    }
    let of_large = plant.classes[3].sensitivity.expect("large meals");
    assert!(of_large > 0.9, "{of_large}");
    let (grid, plant) = (grid.time.expect("found"), plant.time.expect("found"));
    assert!(plant.median.abs() <= 10.0 && grid.median >= 20.0, "{plant:?} {grid:?}");
}

#[test]
fn what_was_logged_is_not_looked_at() {
    let (mut person, _) = people(0.0).swap_remove(2);
    for detector in [PLANT, GRID] {
        let before = found(&detector, &person);
        assert!(!before.meals.is_empty());
        let mut scrambled = person.clone();
        scrambled.record.channel_mut(Channel::Carbs).reverse();
        assert_eq!(found(&detector, &scrambled), before);
        scrambled.record.channel_mut(Channel::Carbs).fill(None);
        assert_eq!(found(&detector, &scrambled), before);
    }
    // But at insulin, which tells a meal's fall from none.
    let before = found(&PLANT, &person);
    person.record.channel_mut(Channel::Bolus).fill(Some(0.0));
    assert_ne!(found(&PLANT, &person).meals, before.meals);
}

#[test]
fn logs_with_holes_gain_and_whole_logs_lose_by_the_published_rule() {
    let (holes, whole) = (people(3.0), people(0.0));
    let explained = |people: &[_], rule: Option<Rule>| {
        let claims =
            |person: &Person| rule.map_or_else(|| log(person), |r| log(&mended(person, r)));
        let score = score(people, claims);
        (score.explained.expect("meals"), score.on_board_error_g.expect("steps"))
    };
    let logged = explained(&holes, None);
    let added = explained(&holes, Some(Rule::Additive));
    assert!(added.0 > logged.0 + 0.03 && added.1 < logged.1, "{added:?} {logged:?}");
    // The price of the published rule where nothing was wrong with the log.
    let logged = explained(&whole, None);
    let published = explained(&whole, Some(Rule::Published));
    assert!(published.1 > logged.1, "{published:?} {logged:?}");
    let added = explained(&whole, Some(Rule::Additive));
    assert!(added.0 >= logged.0 && added.1 < 1.5 * logged.1, "{added:?} {logged:?}");
}

#[test]
fn every_event_has_its_row_and_every_gram_its_event() {
    let (person, _) = people(1.0).swap_remove(0);
    let detected = found(&PLANT, &person);
    let settings = ReconcileSettings::new(Rule::Published);
    let after = reconcile(&person, &detected, &settings).expect("mended");
    let of = |kind| after.events.iter().filter(move |event| event.kind == kind);
    assert_eq!(of(EventKind::Detection).count(), detected.meals.len());
    let reports = person.record.carbs().iter().flatten().filter(|g| **g > 0.0).count();
    assert_eq!(of(EventKind::Report).count(), reports);
    let kept: f64 = after
        .events
        .iter()
        .filter(|e| {
            matches!(e.fate, Fate::MealAtBolus | Fate::MovedToDetection | Fate::KeptWithBolus)
        })
        .filter_map(|e| e.size)
        .sum();
    let log = logged(&after.person).0;
    assert!((kept - log).abs() < 1e-6, "{kept} {log}"); // rounding of a sum of some fifty numbers
    assert!(after.events.windows(2).all(|pair| pair[0].time <= pair[1].time));
    let row = serde_json::to_value(contract::meals::MealEvent::from(&after.events[0]))
        .expect("numbers and words");
    assert_eq!(row["person_id"], person.id);
    assert!(row["time"].as_str().is_some_and(|time| time.starts_with("2024-01-08T")), "{row}");
}

#[test]
fn a_cohort_gives_the_same_on_any_number_of_threads() {
    let cohort = Cohort { people: people(1.0).into_iter().map(|(person, _)| person).collect() };
    let settings = ReconcileSettings::new(Rule::Published);
    let told = std::sync::Mutex::new(Vec::new());
    let done = |id: &str| told.lock().expect("no test panics here").push(id.to_owned());
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| reconcile_cohort(&cohort, &PLANT, &settings, &done)).expect("mended")
    };
    let alone = run(1);
    assert_eq!(alone, run(3));
    assert!(alone.iter().zip(&cohort.people).all(|(after, before)| after.person.id == before.id));
    assert_eq!(told.lock().expect("no test panics here").len(), 2 * cohort.people.len());
}

#[test]
fn values_that_cannot_be_are_said_with_person_step_and_column() {
    let (person, _) = people(0.0).swap_remove(1);
    for (channel, value, says) in [
        (Channel::Cgm, 0.0, "step 40, column cgm_mg_dl: 0 is not a finite number above 0"),
        (Channel::Bolus, -1.0, "step 40, column bolus_u: -1 is not"),
        (Channel::Basal, f64::INFINITY, "step 40, column basal_u_h: inf is not"),
    ] {
        let mut broken = person.clone();
        broken.record.channel_mut(channel)[40] = Some(value);
        let message = PLANT.detect(&broken).expect_err("refused").to_string();
        assert!(message.contains(&person.id) && message.contains(says), "{message}");
    }
    let weightless = Person { weight: Some(physiology::Kilograms(0.0)), ..person };
    let message = GRID.detect(&weightless).expect_err("refused").to_string();
    assert!(message.contains("a weight of 0 kg"), "{message}");
}
