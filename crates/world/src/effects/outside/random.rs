//! Something that nobody has thought of: at one port, on occasions and in a direction that a world draws.
//!
//! An author's idea of an effect teaches a posterior that idea. These have no author: all people of a world share a form
//! that is drawn. The occasions on which an effect of the library acts at a port are left out there, so that few such
//! worlds hold that effect under another name. Gut times by the hour come near slow evening meals.

use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};
use rand::seq::IndexedRandom as _;
use rand::{Rng, RngExt};

use super::super::{Condition, Port};
use super::event::Event;
use crate::behaviour::{Life, MealKind};

/// Changes of logarithms at amplitude 1 (assumed; a world searches its own amplitude).
const ACTION: f64 = 0.3;
const PRODUCTION: f64 = 0.3;
const INSULIN_TIME: f64 = 0.4;
const GUT_TIME: f64 = 0.4;
const AMOUNT: f64 = 0.25;
/// Glucose that enters or leaves at amplitude 1, mmol/kg/min, and change of readings, mg/dL.
const FLUX: f64 = 0.004;
const READING: f64 = 25.0;
/// Shortest and longest time from an occasion to its event, and lengths of events that begin with one, h.
const LATE: (f64, f64) = (0.0, 4.0);
const LENGTHS: (f64, f64) = (1.5, 10.0);
/// Least share of the occasions on which it acts.
const LEAST_SHARE: f64 = 0.35;
/// Lengths of spells, days, and days of which each holds one.
const SPELLS: (f64, f64) = (1.0, 5.0);
const BETWEEN_SPELLS: (f64, f64) = (6.0, 14.0);

/// When it acts.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Occasion {
    /// At an hour of the clock.
    Hour,
    Waking,
    Meal,
    Session,
    /// As long as a set is worn.
    Set,
    Weekend,
    /// For days on end.
    Spell,
}

/// The occasions at a port that are not those of an effect of the library there.
fn occasions(port: Port) -> &'static [Occasion] {
    use Occasion::{Hour, Meal, Session, Set, Spell, Waking, Weekend};
    match port {
        // Not by the clock (`circadian_sensitivity`), nor with exercise (`post_exercise_sensitivity`).
        Port::InsulinAction => &[Waking, Meal, Weekend, Spell],
        // Neither about waking (`dawn`) nor in the night (`alcohol`): of meals after lunch alone.
        Port::Egp => &[Meal, Session, Weekend, Spell],
        // Not with exercise (`exercise`).
        Port::GlucoseFlux => &[Hour, Waking, Meal, Weekend],
        Port::GutAbsorption => &[Hour, Session, Weekend, Spell],
        // Not from day to day (`insulin_absorption`).
        Port::InsulinAbsorption => &[Hour, Waking, Meal, Session, Weekend],
        // Not late in the life of a set (`set_ageing`, `set_failure`).
        Port::InsulinInput => &[Hour, Session, Set, Weekend, Spell],
        // The sensor: neither in the night (`compression_lows`, see `events`) nor by its age (`sensor_drift`).
        _ => &[Waking, Meal, Session, Weekend, Spell],
    }
}

/// The form of a world.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Form {
    occasion: Occasion,
    /// The meal, where it acts after meals: any where none is named.
    meal: Option<MealKind>,
    /// Of the clock, where it acts by that.
    hour: f64,
    late: f64,
    hours: f64,
    edge: f64,
    share: f64,
    sign: f64,
    /// Length of spells and days of which each holds one.
    spell: (f64, f64),
}

impl Form {
    /// Every draw is made.
    fn sample(port: Port, rng: &mut (impl Rng + ?Sized)) -> Self {
        let occasion = *occasions(port).choose(rng).expect("every port has occasions");
        let meals =
            [None, Some(MealKind::Breakfast), Some(MealKind::Lunch), Some(MealKind::Dinner)];
        let meal = *meals.choose(rng).expect("four");
        let meal = match port {
            // After breakfast it would be `dawn`, after dinner `alcohol`.
            Port::Egp => Some(MealKind::Lunch),
            // What follows dinner is mostly in the night.
            Port::Sensor => meal.filter(|kind| *kind != MealKind::Dinner),
            _ => meal,
        };
        let hours = LENGTHS.0 * (LENGTHS.1 / LENGTHS.0).powf(rng.random());
        Self {
            occasion,
            meal,
            hour: rng.random_range(0.0..24.0),
            late: rng.random_range(LATE.0..LATE.1),
            hours,
            edge: (hours / 3.0).min(rng.random_range(0.25..2.0)),
            share: rng.random_range(LEAST_SHARE..1.0),
            sign: if rng.random_bool(0.5) { 1.0 } else { -1.0 },
            spell: (
                rng.random_range(SPELLS.0..SPELLS.1),
                rng.random_range(BETWEEN_SPELLS.0..BETWEEN_SPELLS.1),
            ),
        }
    }

    /// First steps and lengths, h, of all occasions of a life.
    fn of_life(&self, life: &Life, rng: &mut (impl Rng + ?Sized)) -> Vec<(i64, f64)> {
        let calendar = &life.calendar;
        let after =
            |step: i64| (step + (self.late * STEPS_PER_HOUR as f64).round() as i64, self.hours);
        let days = || 0..calendar.days();
        match self.occasion {
            Occasion::Hour => {
                days().map(|day| (calendar.signed_step(day, self.hour), self.hours)).collect()
            }
            Occasion::Waking => life.nights.iter().map(|night| after(night.wake)).collect(),
            Occasion::Meal => {
                let meals = life.meals.iter();
                let own = meals.filter(|meal| self.meal.is_none_or(|kind| meal.kind == kind));
                own.map(|meal| after(meal.step as i64)).collect()
            }
            Occasion::Session => {
                let sessions = life.sessions.iter();
                sessions.map(|session| after((session.start + session.steps) as i64)).collect()
            }
            Occasion::Set => {
                let changes = life.sets.changes();
                let ends = changes.iter().skip(1).copied().chain([calendar.steps() as i64]);
                let hours = |from: i64, until: i64| (until - from) as f64 / STEPS_PER_HOUR as f64;
                changes.iter().zip(ends).map(|(from, end)| (*from, hours(*from, end))).collect()
            }
            Occasion::Weekend => {
                let weekend = days().filter(|day| calendar.is_weekend(*day));
                weekend.map(|day| (calendar.signed_step(day, 0.0), 24.0)).collect()
            }
            Occasion::Spell => {
                let (length, between) = self.spell;
                let count = (calendar.days() as f64 / between).ceil() as usize;
                (0..count)
                    .map(|block| {
                        let within = rng.random_range(0.0..(between - length).max(0.1));
                        let day = between * block as f64 + within;
                        ((day * STEPS_PER_DAY as f64) as i64, 24.0 * length)
                    })
                    .collect()
            }
        }
    }
}

/// The events of a life; `of_world` draws what all people share.
pub(super) fn events(
    port: Port,
    life: &Life,
    of_world: &mut (impl Rng + ?Sized),
    rng: &mut (impl Rng + ?Sized),
) -> Vec<Event> {
    let form = Form::sample(port, of_world);
    let whole = matches!(form.occasion, Occasion::Weekend | Occasion::Set | Occasion::Spell);
    let edge = if whole { 0.0 } else { form.edge };
    let steps = life.calendar.steps();
    // Readings that are off for hours of the night would be those of `compression_lows`.
    let of_the_night = |event: &Event| {
        port == Port::Sensor && !whole && event.steps(steps).any(|step| life.is_asleep(step))
    };
    form.of_life(life, rng)
        .into_iter()
        .filter_map(|(from, hours)| {
            let (draw, size) = (rng.random::<f64>(), form.sign * rng.random_range(0.75..1.25));
            (draw < form.share).then_some(Event { from, hours, edge, size })
        })
        .filter(|event| !of_the_night(event))
        .collect()
}

/// Acts at a port of the body.
pub(super) fn act(port: Port, condition: &mut Condition, strength: f64) {
    let by = |change: f64| (change * strength).exp();
    match port {
        Port::InsulinAction => {
            condition.action *= by(ACTION);
            condition.liver_action *= by(0.5 * ACTION);
        }
        Port::Egp => condition.production *= by(PRODUCTION),
        Port::GlucoseFlux => condition.glucose_flux += FLUX * strength,
        Port::GutAbsorption => condition.gut_time *= by(GUT_TIME),
        Port::InsulinAbsorption => condition.insulin_time *= by(INSULIN_TIME),
        Port::InsulinInput => condition.bioavailability *= by(AMOUNT),
        _ => {} // acts on the sensor alone
    }
}

/// What is added to the reading, mg/dL.
pub(super) fn offset(strength: f64) -> f64 {
    READING * strength
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::behaviour::Habits;
    use crate::calendar::Calendar;
    use crate::effects::{Events, OutsideEffect};
    use crate::stream::{Concept, stream};

    fn life(person: usize) -> Life {
        let monday = chrono::NaiveDate::from_ymd_opt(2024, 1, 8).expect("a date");
        let habits = Habits::sample(&mut stream(3, person, Concept::Habits));
        Life::sample(&habits, Calendar::new(monday, 28), 3, person)
    }

    #[test]
    fn people_of_a_world_share_a_form_and_worlds_differ() {
        // Every event of a world has the direction and, but for weekends, sets and spells, the length of its form.
        let of = |world: u64, person: usize| {
            let events = Events::sample(&life(person), world, person);
            let own = events.of(OutsideEffect::RandomFlux).to_vec();
            own.first().map(|first| {
                assert!(own.iter().all(|e| e.size * first.size > 0.0 && e.hours == first.hours));
                (first.size > 0.0, first.hours.to_bits())
            })
        };
        let forms: Vec<_> = (0..30).map(|world| (of(world, 0), of(world, 1))).collect();
        assert!(forms.iter().all(|(one, other)| one == other && one.is_some()), "{forms:?}");
        let up = forms.iter().filter(|(form, _)| form.is_some_and(|form| form.0)).count();
        assert!((5..=25).contains(&up), "{up} of 30 add glucose");
    }

    #[test]
    fn every_port_acts_within_the_record_in_nearly_every_world() {
        let life = life(0);
        let steps = life.calendar.steps();
        for effect in OutsideEffect::RANDOM {
            let acts = |world: &u64| {
                let events = Events::sample(&life, *world, 0);
                events.of(effect).iter().any(|event| event.steps(steps).len() > 12)
            };
            // A person without exercise has no occasion after it.
            let share = (0..60).filter(acts).count();
            assert!(share >= 48, "{}: {share} of 60", effect.name());
        }
    }

    #[test]
    fn readings_are_not_off_for_hours_of_the_night() {
        let life = life(0);
        let steps = life.calendar.steps();
        let mut hours_of_nights = 0;
        for world in 0..60 {
            let events = Events::sample(&life, world, 0);
            let asleep = |event: &Event| event.steps(steps).any(|step| life.is_asleep(step));
            let (long, short): (Vec<&Event>, Vec<&Event>) =
                events.of(OutsideEffect::RandomReading).iter().partition(|e| e.hours >= 24.0);
            assert!(!short.into_iter().any(asleep), "world {world}");
            hours_of_nights += long.into_iter().filter(|event| asleep(event)).count();
        }
        assert!(hours_of_nights > 0, "spells of days hold their nights");
    }

    /// Events by the clock would all begin at the same hour.
    #[test]
    fn action_production_and_readings_do_not_follow_the_clock() {
        let life = life(0);
        for effect in [
            OutsideEffect::RandomAction,
            OutsideEffect::RandomProduction,
            OutsideEffect::RandomReading,
        ] {
            for world in 0..60 {
                let events = Events::sample(&life, world, 0);
                let own = events.of(effect).iter().filter(|event| event.hours < 12.0);
                let hours: std::collections::BTreeSet<i64> =
                    own.clone().map(|event| event.from.rem_euclid(STEPS_PER_DAY as i64)).collect();
                assert!(own.count() < 3 || hours.len() > 1, "{} in world {world}", effect.name());
            }
        }
    }
}
