//! Effects move glucose where they act.

use chrono::NaiveDate;
use physiology::MgPerDl;
use world::blind::{Nuisances, Plan, PlannedEffect, PlannedWorld};
use world::true_gap::{CellFactor, CourseUnit, PortCourse, Situation, TrueGap};
use world::{
    Amplitudes, Calendar, Effect, Generator, LivedDays, Port, Regime, Shapes, VirtualPerson,
};

/// A person in whom one effect acts, and their three weeks.
fn lived(generator: Generator, effect: Effect, amplitude: f64) -> (VirtualPerson, LivedDays) {
    let person = VirtualPerson::sample_from(generator, 17, 3, Regime::OpenLoopPump);
    let amplitudes = Amplitudes::NONE.with(effect, amplitude);
    let person = person.expect("a person");
    let person = VirtualPerson { amplitudes, shapes: Shapes::TYPICAL, ..person };
    let calendar = Calendar::new(NaiveDate::from_ymd_opt(2024, 1, 8).expect("a date"), 21);
    let days = person.live(calendar).expect("three weeks");
    (person, days)
}

fn gap(person: &VirtualPerson, days: &LivedDays, without: Amplitudes) -> TrueGap {
    TrueGap::of(&[(person.id.clone(), person.gap(days, &without).expect("a gap"))])
}

/// Levels of a factor, the largest mean after an hour first.
fn largest_first(gap: &TrueGap, factor: CellFactor) -> Vec<(String, f64)> {
    let cells = gap.cells.iter().filter(|cell| cell.factor == factor);
    let mut levels: Vec<(String, f64)> =
        cells.filter_map(|cell| Some((cell.level.clone(), cell.mean[0]?))).collect();
    levels.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    levels
}

#[test]
fn nothing_moves_where_nothing_is_switched_off() {
    for generator in Generator::ALL {
        let (person, days) = lived(generator, Effect::Dawn, 1.0);
        let none = gap(&person, &days, person.amplitudes);
        assert_eq!(none.mean_absolute, [0.0; 3], "{}", generator.name());
        assert!(none.cells.iter().all(|cell| cell.mean.iter().flatten().all(|mean| *mean == 0.0)));
    }
}

#[test]
fn dawn_raises_glucose_in_the_morning() {
    for generator in Generator::ALL {
        let (person, days) = lived(generator, Effect::Dawn, 2.0);
        let gap = gap(&person, &days, Amplitudes::NONE);
        let hours = largest_first(&gap, CellFactor::Hour);
        let hottest: usize = hours[0].0.parse().expect("an hour");
        assert!((3..10).contains(&hottest), "{}: {hours:?}", generator.name());
        assert!(hours[0].1 > 0.0, "{hours:?}");
        // In the afternoon the production is as drawn, so runs from the same state stay together.
        let afternoon = gap.cell(CellFactor::Hour, "16").and_then(|cell| cell.mean[0]);
        let afternoon = afternoon.expect("runs of every hour");
        assert!(afternoon.abs() < 0.1 * hours[0].1, "{afternoon} {hours:?}");
        // After five hours more has gathered than after one, and through whole days more still.
        let morning = gap.cell(CellFactor::Hour, "06").expect("an hour");
        let [one, five, day] = morning.mean.map(|mean| mean.expect("runs of every hour"));
        assert!(0.0 < one && one < five && day > 0.0, "{one} {five} {day}");
        assert!(gap.mean_absolute[0] < gap.mean_absolute[1]);
    }
}

#[test]
fn exercise_lowers_glucose_where_there_is_exercise() {
    for generator in Generator::ALL {
        let (person, days) = lived(generator, Effect::Exercise, 1.0);
        let gap = gap(&person, &days, Amplitudes::NONE);
        let contexts = largest_first(&gap, CellFactor::Context);
        assert_eq!(contexts[0].0, Situation::Exercise.name(), "{contexts:?}");
        assert!(contexts[0].1 < -5.0, "{contexts:?}");
        let of_person = gap.cell(CellFactor::Person, &person.id).expect("the person");
        assert_eq!(of_person.mean.map(Option::unwrap_or_default), gap.mean);
    }
}

#[test]
fn a_meal_that_nobody_logged_is_a_gap_after_meals() {
    let (person, days) = lived(Generator::Hovorka, Effect::MissedMeals, 5.0);
    let gap = gap(&person, &days, Amplitudes::NONE);
    let after_meal = gap.cell(CellFactor::Context, "after_meal").expect("a level");
    let (hour, five) = (after_meal.mean[0].expect("meals"), after_meal.mean[1].expect("meals"));
    // The meal is already in the state at the start; the later meal is still to come.
    assert!(five > 0.0 && hour < five, "{hour} {five}");
    assert!(gap.mean[2] > gap.mean[1] && gap.mean[1] > gap.mean[0]);
}

#[test]
fn a_sensor_is_compared_with_itself_and_the_body_left_alone() {
    let (person, days) = lived(Generator::Hovorka, Effect::CompressionLows, 1.0);
    let gap = gap(&person, &days, Amplitudes::NONE);
    let asleep = gap.cell(CellFactor::Context, "sleep").expect("a level");
    assert!(asleep.mean[0].is_some_and(|mean| mean < -0.2), "{asleep:?}");
    let lunch = gap.cell(CellFactor::Hour, "13").and_then(|cell| cell.mean[0]);
    assert_eq!(lunch, Some(0.0));
}

#[test]
fn courses_at_ports_have_the_size_that_was_set() {
    let course = |effect: Effect, amplitude: f64| {
        let (person, days) = lived(Generator::Hovorka, effect, amplitude);
        let gap = person.gap(&days, &Amplitudes::NONE).expect("a gap");
        PortCourse::of(PlannedEffect::Named(effect), &[(&person, &days, &gap)]).expect("a course")
    };
    let dawn = course(Effect::Dawn, 1.0);
    assert_eq!((dawn.port, dawn.unit), (Port::Egp, CourseUnit::Factor));
    let at = |hour: usize| dawn.by_hour[hour].expect("every hour");
    // Production up to 22 % higher around waking.
    let top = (0..24).map(at).fold(0.0, f64::max);
    assert!((0.1..0.23).contains(&top) && at(16) < 0.01, "{:?}", dawn.by_hour);

    let ageing = course(Effect::SetAgeing, 1.0);
    assert!(ageing.by_hour.iter().flatten().all(|change| (-0.2..0.0).contains(change)));
    let missed = course(Effect::MissedMeals, 5.0);
    assert_eq!((missed.port, missed.unit), (Port::CarbAmount, CourseUnit::Carbohydrate));
    assert!(missed.by_hour.iter().flatten().sum::<f64>() > 10.0); // g a day
    let sensor = course(Effect::CompressionLows, 1.0);
    assert_eq!(sensor.unit, CourseUnit::Reading);
    assert!(sensor.by_hour[3].is_some_and(|change| change < 0.0));
    let exercise = course(Effect::Exercise, 1.0);
    assert_eq!(exercise.unit, CourseUnit::GlucoseRate);
    assert!(exercise.by_hour.iter().flatten().sum::<f64>() < 0.0);
}

fn planned(effects: Vec<(PlannedEffect, f64)>) -> PlannedWorld {
    let drawn = Plan { nulls: 1, ..Plan::check(0, 0) }.worlds(1).swap_remove(0);
    PlannedWorld { effects, people: 2, days: 7, nuisances: Nuisances::default(), ..drawn }
}

#[test]
fn the_truth_of_a_world_holds_all_effects_and_that_of_a_null_none() {
    let null = planned(Vec::new()).realise().expect("a world");
    assert_eq!(null.true_where().expect("lived"), None);
    let two = [Effect::Dawn, Effect::SetAgeing].map(|effect| (PlannedEffect::Named(effect), 5.0));
    let world = planned(two.to_vec()).realise().expect("a world");
    let truth = world.true_where().expect("lived").expect("two effects act");
    assert_eq!(truth.courses.len(), 2);
    assert_eq!(truth.gap.cells.len(), 24 + Situation::ALL.len() + 3 + 2);
    assert!(truth.gap.mean_absolute.iter().all(|mean| *mean > 0.0));
}

#[test]
fn exact_courses_lie_along_the_records() {
    let dawn = PlannedEffect::Named(Effect::Dawn);
    let ageing = PlannedEffect::Named(Effect::SetAgeing);
    let lived = planned(vec![(dawn, 10.0)]).realise().expect("a world");
    let mut cohort = lived.cohort();
    let courses = lived.exact_courses(&cohort, &[dawn, ageing]).expect("courses");
    assert_eq!(
        courses.iter().map(|c| (c.effect, c.acts)).collect::<Vec<_>>(),
        [(dawn, true), (ageing, false)]
    );
    // The shift that was searched for, except for the sensor's gain and lost readings.
    assert!((8.0..13.0).contains(&courses[0].size()), "{}", courses[0].size());
    assert!(courses[1].size() > 0.5);
    let whole = courses[0].people[0].clone();
    let person = &mut cohort.people[0];
    assert_eq!(whole.len(), person.record.len());
    person.record = person.record.slice(288..1440).expect("days of the record");
    let part = lived.exact_courses(&cohort, &[]).expect("courses").swap_remove(0);
    assert_eq!(part.people[0], whole[288..1440]);
    // A reading minus its course is the reading of a life without the effect, except for rounding
    // and the display.
    let world = &lived.world;
    let without = VirtualPerson { amplitudes: Amplitudes::NONE, ..world.people[0].clone() };
    assert_ne!(without, world.people[0]);
    let lived = world.people[0].live(world.planned.calendar()).expect("a week");
    let other = world.people[0].counterfactual(&lived, &Amplitudes::NONE).expect("a week");
    let record = &lived.recorded.record;
    for (step, other) in other.sensed.iter().enumerate() {
        if let (Some(reading), Some(MgPerDl(other))) = (record.cgm()[step], other) {
            let course = whole.get(step).copied().flatten();
            assert!(course.is_none_or(|c| (reading - c - other).abs() <= 0.5 + 1e-9));
        }
    }
}
