//! What varies, as a person could point at it: meals, boluses, nights, days, bouts of exercise, infusion sets, lows.

use std::ops::Range;

use effects::Course;
use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

use super::doses::Doses;
use crate::context::{Situation, Situations, since};

/// Least carbohydrate of a meal, g, and least dose of a bolus, U.
const MEAL: f64 = 10.0;
const BOLUS: f64 = 1.0;
/// Rise of glucose in 15 min that a meal would make, mg/dL.
const RISE: f64 = 9.0;
/// Logarithm of an amount of insulin over the usual one that is much; one below it by as much is little.
const MUCH: f64 = 0.4;
/// Steps of half an hour.
const HALF_HOUR: usize = STEPS_PER_HOUR / 2;
/// Hours of the day at which a meal is a dinner.
const DINNER_HOURS: Range<f64> = 17.0..22.0;

/// What may explain how units of a kind differ: its name, and what it is of a unit.
pub(super) type Covariate = (&'static str, fn(&Life<'_>, &Unit) -> f64);

/// A kind of unit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kind {
    pub(super) name: &'static str,
    pub(super) covariates: &'static [Covariate],
    /// Whether a person's day and response to glucose are left in the innovations: they are what the kind asks about.
    pub(super) plain: bool,
    /// Periods at which units may come and go, by name: units each.
    pub(super) rhythms: &'static [(&'static str, usize)],
    /// A person's units; none where the record does not show the kind.
    pub(super) units: fn(&Life<'_>) -> Vec<Unit>,
}

const fn kind(
    name: &'static str,
    covariates: &'static [Covariate],
    units: fn(&Life<'_>) -> Vec<Unit>,
) -> Kind {
    Kind { name, covariates, plain: false, rhythms: &[], units }
}

const fn plain(name: &'static str, units: fn(&Life<'_>) -> Vec<Unit>) -> Kind {
    Kind { name, covariates: &[], plain: true, rhythms: &[], units }
}

const SIZE: Covariate = ("size", |life, meal| life.course.carbs[meal.event.start].ln());
const DOSE: Covariate = ("dose", |life, bolus| life.course.bolus[bolus.event.start].ln());
const DINNER: Covariate =
    ("dinner", |life, meal| life.within_hours(meal.event.start, &DINNER_HOURS));
const CORRECTION: Covariate = ("correction", |life, bolus| {
    flag(life.eaten(life.around(bolus.event.start, STEPS_PER_HOUR, STEPS_PER_HOUR)) <= 0.0)
});
const MEALTIME: Covariate = ("mealtime", |life, bolus| {
    let mealtimes = [7.0..10.0, 12.0..15.0, 18.0..21.0];
    mealtimes.iter().map(|hours| life.within_hours(bolus.event.start, hours)).sum()
});
const CARBOHYDRATE: Covariate = ("carbohydrate", |life, low| life.eaten(low.steps.clone()));
const GLUCOSE: Covariate = ("glucose", |life, unit| life.course.glucose[unit.event.start]);
const RATE: Covariate = ("rate", |life, unit| life.rate(unit.event.start));
const LOW_BEFORE: Covariate = ("low before", |life, rise| {
    let before = life.around(rise.event.start, STEPS_PER_HOUR, 1);
    flag(life.course.glucose[before].iter().any(|glucose| *glucose < 75.0))
});
const DEPTH: Covariate = ("depth", |life, low| 70.0 - life.course.glucose[low.steps.start]);
const GREATEST_DEPTH: Covariate = ("depth", |life, low| {
    let glucose = life.course.glucose[low.steps.clone()].iter().copied();
    70.0 - glucose.fold(f64::MAX, f64::min)
});
const HEIGHT: Covariate = ("height", |life, high| {
    let glucose = life.course.glucose[high.steps.clone()].iter().copied();
    glucose.fold(0.0, f64::max) - 200.0
});
const INSULIN: Covariate = ("insulin", |life, unit| life.doses.over_usual(&unit.steps));
const SET_AGE: Covariate = ("set age", |life, unit| life.set_age[unit.event.start]);
const AGE_OF_SET: Covariate = ("age", SET_AGE.1);
const AGE_OF_SENSOR: Covariate = ("age", |life, unit| life.sensor_age[unit.event.start]);
const WEEKEND: Covariate = ("weekend", |life, unit| flag(life.course.weekend[unit.event.start]));
const LENGTH: Covariate = ("length", |_, bout| (bout.event.len() as f64).ln());

const OF_MEALS: &[Covariate] = &[
    SIZE,
    ("breakfast", |life, meal| life.within_hours(meal.event.start, &(5.0..10.0))),
    DINNER,
    GLUCOSE,
    WEEKEND,
    ("no bolus", |life, meal| flag(life.bolus_beside(meal) <= 0.0)),
    ("exercise", |life, meal| life.exercised(meal.event.start, 10 * STEPS_PER_HOUR)),
    // Finite where either is small.
    ("insulin per carbohydrate", |life, meal| {
        let carbs = life.course.carbs[meal.event.start];
        ((life.bolus_beside(meal) + 0.5) / (carbs / 10.0 + 0.5)).ln()
    }),
];
const OF_NIGHTS: &[Covariate] = &[
    ("hours asleep", |life, night| {
        let asleep = night.steps.clone().filter(|k| life.asleep(*k)).count();
        asleep as f64 / STEPS_PER_HOUR as f64
    }),
    ("exercise", |life, night| life.exercised(night.steps.start, STEPS_PER_DAY)),
    ("evening carbohydrate", |life, night| life.eaten(night.evening()..night.steps.start)),
    ("weekend", |life, night| flag(life.course.weekend[night.evening()])),
    GLUCOSE,
    INSULIN,
];
const OF_DAYS: &[Covariate] = &[
    ("short night", |life, day| {
        flag(day.steps.clone().any(|k| life.situations.holds(Situation::DayAfterShortSleep, k)))
    }),
    ("exercise before", |life, day| life.exercised(day.steps.start, STEPS_PER_DAY)),
    ("weekend", |life, day| flag(life.course.weekend[life.noon(day)])),
    ("date", |_, day| usize::midpoint(day.steps.start, day.steps.end) as f64),
    ("set age", |life, day| life.set_age[life.noon(day)]),
    INSULIN,
];

/// The kinds.
pub(super) const KINDS: [Kind; 40] = [
    kind("meal", OF_MEALS, |life| life.meals(0..3 * STEPS_PER_HOUR)),
    kind("late meal", &[SIZE, DINNER], |life| life.meals(3 * STEPS_PER_HOUR..8 * STEPS_PER_HOUR)),
    kind("dinner", &[SIZE], |life| {
        let mut dinners = life.meals(0..8 * STEPS_PER_HOUR);
        dinners.retain(|unit| DINNER_HOURS.contains(&life.course.hour[unit.steps.start]));
        dinners
    }),
    kind("bolus", &[DOSE, CORRECTION, SET_AGE, GLUCOSE], |life| {
        life.after(|k| life.course.bolus[k] >= BOLUS, 0..5 * STEPS_PER_HOUR)
    }),
    kind("bolus without meal", &[DOSE, GLUCOSE, MEALTIME], |life| life.boluses_without_meal()),
    kind("rise without meal", &[RATE, LOW_BEFORE], |life| life.rises()),
    kind("much insulin", &[INSULIN], |life| life.doses_that(|over| over >= MUCH)),
    kind("little insulin", &[INSULIN], |life| life.doses_that(|over| over <= -MUCH)),
    kind("night", OF_NIGHTS, |life| life.clock(23.0, 8.0)),
    kind("late night", OF_NIGHTS, |life| life.clock(3.0, 5.0)),
    Kind {
        rhythms: &[("3 days", 3), ("7 days", 7), ("10 days", 10)],
        ..kind("day", OF_DAYS, |life| life.blocks(STEPS_PER_DAY))
    },
    kind("quarter", &[SET_AGE, INSULIN], |life| life.blocks(STEPS_PER_DAY / 4)),
    kind("three days", &[], |life| life.blocks(3 * STEPS_PER_DAY)),
    kind("hour", &[RATE, GLUCOSE], |life| life.blocks(STEPS_PER_HOUR)),
    kind("half hour low", &[DEPTH], |life| life.half_hours(|k| life.course.glucose[k] < 70.0)),
    kind("half hour asleep", &[RATE], |life| life.half_hours(|k| life.asleep(k))),
    kind("half hour awake", &[RATE], |life| life.half_hours(|k| !life.asleep(k))),
    kind("set day", &[AGE_OF_SET], |life| life.half_days_with(life.course.set_changed.is_some())),
    kind("old set", &[], |life| life.stretches_in(Situation::SetDay3Plus)),
    kind("sensor day", &[AGE_OF_SENSOR], |life| life.half_days_with(!life.sensor_age.is_empty())),
    kind("first sensor day", &[], |life| {
        life.stretches(|k| life.sensor_age.get(k).is_some_and(|age| *age < 1.0))
    }),
    kind("bout", &[LENGTH], |life| life.stretches_in(Situation::Exercise)),
    kind("after bout", &[LENGTH], |life| life.after_bouts(0, 2 * STEPS_PER_HOUR)),
    kind("long after bout", &[LENGTH], |life| {
        life.after_bouts(2 * STEPS_PER_HOUR, 14 * STEPS_PER_HOUR)
    }),
    kind("after short night", &[], |life| life.stretches_in(Situation::DayAfterShortSleep)),
    kind("after low", &[GREATEST_DEPTH, CARBOHYDRATE], |life| {
        let mut lows = life.stretches(|k| life.course.glucose[k] < 70.0);
        for low in &mut lows {
            low.steps.end = (low.steps.end + 2 * STEPS_PER_HOUR).min(life.n);
        }
        lows
    }),
    kind("high", &[HEIGHT], |life| life.stretches(|k| life.course.glucose[k] > 200.0)),
    kind("evening", &[WEEKEND], |life| life.clock(18.0, 5.0)),
    kind("morning after weekend", &[], |life| {
        let mut mornings = life.clock(4.0, 8.0);
        mornings.retain(|unit| {
            let evening = unit.steps.start.checked_sub(6 * STEPS_PER_HOUR);
            evening.is_some_and(|evening| life.course.weekend[evening])
        });
        mornings
    }),
    plain("00-03", |life| life.clock(0.0, 3.0)),
    plain("03-06", |life| life.clock(3.0, 3.0)),
    plain("06-09", |life| life.clock(6.0, 3.0)),
    plain("09-12", |life| life.clock(9.0, 3.0)),
    plain("12-15", |life| life.clock(12.0, 3.0)),
    plain("15-18", |life| life.clock(15.0, 3.0)),
    plain("18-21", |life| life.clock(18.0, 3.0)),
    plain("21-24", |life| life.clock(21.0, 3.0)),
    plain("below 70", |life| life.half_hours(|k| life.course.glucose[k] < 70.0)),
    plain("70-180", |life| life.half_hours(|k| (70.0..=180.0).contains(&life.course.glucose[k]))),
    plain("above 180", |life| life.half_hours(|k| life.course.glucose[k] > 180.0)),
];

/// One unit.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Unit {
    /// What makes it: the step of a meal or a dose, a bout, or the steps themselves.
    event: Range<usize>,
    /// Over which it is scored.
    pub(super) steps: Range<usize>,
}

impl Unit {
    fn of(steps: Range<usize>) -> Self {
        Self { event: steps.clone(), steps }
    }

    /// The step six hours before.
    fn evening(&self) -> usize {
        self.steps.start.saturating_sub(6 * STEPS_PER_HOUR)
    }
}

/// What defines the units.
pub(super) struct Life<'a> {
    course: &'a Course,
    situations: &'a Situations,
    doses: &'a Doses,
    recorded: &'a [bool],
    n: usize,
    /// Days since the last change of a set; 0 where none is on record.
    set_age: Vec<f64>,
    /// Days since the sensor was inserted; empty where the record does not tell.
    sensor_age: &'a [f64],
}

impl<'a> Life<'a> {
    /// `recorded` says in which steps every dose is on record.
    pub(super) fn of(
        course: &'a Course,
        situations: &'a Situations,
        doses: &'a Doses,
        recorded: &'a [bool],
    ) -> Self {
        let n = course.len();
        let changed = |k: usize| course.set_changed.as_ref().is_some_and(|changes| changes[k]);
        let days = |steps: usize| steps as f64 / STEPS_PER_DAY as f64;
        let set_age = since((0..n).map(changed)).map(|steps| steps.map_or(0.0, days)).collect();
        let sensor_age = course.sensor_age.as_deref().unwrap_or_default();
        Self { course, situations, doses, recorded, n, set_age, sensor_age }
    }

    fn within_hours(&self, k: usize, hours: &Range<f64>) -> f64 {
        flag(hours.contains(&self.course.hour[k]))
    }

    /// From so many steps before one to so many after, as far as the record goes.
    fn around(&self, k: usize, before: usize, after: usize) -> Range<usize> {
        k.saturating_sub(before)..(k + after).min(self.n)
    }

    /// Carbohydrate, g.
    fn eaten(&self, steps: Range<usize>) -> f64 {
        self.course.carbs[steps].iter().sum()
    }

    /// Whether it is on record that nothing was eaten from so many steps before to so many after.
    fn nothing_eaten(&self, k: usize, before: usize, after: usize) -> bool {
        let steps = self.around(k, before, after);
        self.recorded[steps.clone()].iter().all(|recorded| *recorded) && self.eaten(steps) <= 0.0
    }

    /// Insulin within half an hour of a meal, U.
    fn bolus_beside(&self, meal: &Unit) -> f64 {
        let steps = self.around(meal.event.start, HALF_HOUR, HALF_HOUR);
        self.course.bolus[steps].iter().sum()
    }

    /// Hours of exercise in the steps before.
    fn exercised(&self, k: usize, before: usize) -> f64 {
        let steps = self.around(k, before, 0);
        let now = steps.filter(|k| self.situations.holds(Situation::Exercise, *k));
        now.count() as f64 / STEPS_PER_HOUR as f64
    }

    fn asleep(&self, k: usize) -> bool {
        match &self.course.asleep {
            Some(asleep) => asleep[k].is_some_and(|share| share >= 0.5),
            None => !(7.0..23.0).contains(&self.course.hour[k]),
        }
    }

    /// Change of glucose in the quarter of an hour before, mg/dL.
    fn rate(&self, k: usize) -> f64 {
        self.course.glucose[k] - self.course.glucose[k.saturating_sub(3)]
    }

    fn noon(&self, day: &Unit) -> usize {
        (day.steps.start + STEPS_PER_DAY / 2).min(self.n - 1)
    }

    /// Windows after meals, until the next.
    fn meals(&self, window: Range<usize>) -> Vec<Unit> {
        self.after(|k| self.course.carbs[k] >= MEAL, window)
    }

    /// The minutes around boluses beside which nothing was eaten: when a meal that is not on the log would begin.
    fn boluses_without_meal(&self) -> Vec<Unit> {
        let is_bolus = |k: usize| self.course.bolus[k] >= BOLUS;
        let starts = |k: usize| is_bolus(k) || self.course.carbs[k] >= MEAL;
        let mut found = self.after(starts, 0..3 * STEPS_PER_HOUR);
        found.retain(|unit| {
            let k = unit.event.start;
            is_bolus(k) && self.nothing_eaten(k, STEPS_PER_HOUR, STEPS_PER_HOUR)
        });
        for unit in &mut found {
            unit.steps = self.around(unit.event.start, 1, 5);
        }
        found
    }

    /// The time before glucose rises while nothing was eaten for long.
    fn rises(&self) -> Vec<Unit> {
        let mut found = self.half_hours(|k| {
            self.rate(k) >= RISE && self.nothing_eaten(k, 3 * STEPS_PER_HOUR, HALF_HOUR)
        });
        for unit in &mut found {
            unit.steps = self.around(unit.event.start, HALF_HOUR, HALF_HOUR / 2);
        }
        found
    }

    /// Stretches at the end of six hours with another amount of insulin than usual at their time of day.
    fn doses_that(&self, differ: impl Fn(f64) -> bool) -> Vec<Unit> {
        let window = 6 * STEPS_PER_HOUR;
        self.stretches(|k| k >= window && differ(self.doses.over_usual(&(k - window..k))))
    }

    /// A window after each step that begins one, until the next.
    fn after(&self, begins: impl Fn(usize) -> bool, window: Range<usize>) -> Vec<Unit> {
        let starts: Vec<usize> = (0..self.n).filter(|k| begins(*k)).collect();
        let ends = starts.iter().skip(1).copied().chain([self.n]);
        let unit = |(start, next): (&usize, usize)| {
            let steps = start + window.start..(start + window.end).min(next);
            (steps.len() >= HALF_HOUR).then_some(Unit { event: *start..start + 1, steps })
        };
        starts.iter().zip(ends).filter_map(unit).collect()
    }

    /// The hours of the clock from `from` on, every day; whole ones only.
    fn clock(&self, from: f64, hours: f64) -> Vec<Unit> {
        let length = (hours * STEPS_PER_HOUR as f64) as usize;
        let starts = (0..self.n).filter(|k| {
            let since = (self.course.hour[*k] - from).rem_euclid(24.0);
            since < 1.0 / STEPS_PER_HOUR as f64 - 1e-9 && k + length <= self.n
        });
        starts.map(|k| Unit::of(k..k + length)).collect()
    }

    /// Blocks one after the other from midnight on.
    fn blocks(&self, length: usize) -> Vec<Unit> {
        let of_day = (self.course.hour[0] * STEPS_PER_HOUR as f64).round() as usize % STEPS_PER_DAY;
        let first = (STEPS_PER_DAY - of_day) % STEPS_PER_DAY % length;
        let ends = (first..self.n).step_by(length).map(|start| start..(start + length).min(self.n));
        ends.filter(|steps| 2 * steps.len() >= length).map(Unit::of).collect()
    }

    fn half_hours(&self, wanted: impl Fn(usize) -> bool) -> Vec<Unit> {
        let mut found = self.blocks(HALF_HOUR);
        found.retain(|unit| wanted(unit.steps.start));
        found
    }

    /// Half days of a record that shows what they are asked about.
    fn half_days_with(&self, shown: bool) -> Vec<Unit> {
        if shown { self.blocks(STEPS_PER_DAY / 2) } else { Vec::new() }
    }

    /// Where something holds without a break of an hour.
    fn stretches(&self, holds: impl Fn(usize) -> bool) -> Vec<Unit> {
        let mut found: Vec<Range<usize>> = Vec::new();
        for k in (0..self.n).filter(|k| holds(*k)) {
            match found.last_mut() {
                Some(last) if k < last.end + STEPS_PER_HOUR => last.end = k + 1,
                _ => found.push(k..k + 1),
            }
        }
        found.into_iter().map(Unit::of).collect()
    }

    fn stretches_in(&self, situation: Situation) -> Vec<Unit> {
        self.stretches(|k| self.situations.holds(situation, k))
    }

    /// From so many steps after the end of a bout of exercise to so many.
    fn after_bouts(&self, from: usize, to: usize) -> Vec<Unit> {
        let mut found = self.stretches_in(Situation::Exercise);
        for bout in &mut found {
            let end = bout.event.end;
            bout.steps = (end + from).min(self.n)..(end + to).min(self.n);
        }
        found.retain(|bout| !bout.steps.is_empty());
        found
    }
}

fn flag(holds: bool) -> f64 {
    f64::from(u8::from(holds))
}

#[cfg(test)]
mod tests {
    use super::*;
    use cohort::{Channel, Person, Record, Therapy};

    /// Three days from midnight on: a lunch and a dinner a day, a run on the second, glucose low for an hour on the third.
    fn course() -> (Course, Situations, Doses) {
        let start = "2024-03-04T00:00:00".parse().expect("a literal time");
        let mut record = Record::new(start, 3 * STEPS_PER_DAY).expect("on the grid");
        let at = |day: usize, hour: usize| day * STEPS_PER_DAY + hour * STEPS_PER_HOUR;
        for day in 0..3 {
            record.channel_mut(Channel::Carbs)[at(day, 12)] = Some(40.0);
            record.channel_mut(Channel::Carbs)[at(day, 18)] = Some(80.0);
            record.channel_mut(Channel::Bolus)[at(day, 18)] = Some(8.0);
        }
        record.channel_mut(Channel::Steps)[at(1, 9)..at(1, 10)].fill(Some(900.0));
        let mut glucose = vec![120.0; 3 * STEPS_PER_DAY];
        glucose[at(2, 3)..at(2, 4)].fill(60.0);
        let person = Person {
            id: "p".into(),
            weight: None,
            therapy: Therapy::Unknown,
            heart_rate_baseline: None,
            record,
        };
        let situations = Situations::of(&person, &glucose);
        let course = crate::course(&person, glucose);
        let doses = Doses::of(&course.hour, course.bolus.iter().copied().map(Some).collect());
        (course, situations, doses)
    }

    /// First step, length and covariates of the units of a kind.
    fn found(name: &str) -> Vec<(usize, usize, Vec<f64>)> {
        let (course, situations, doses) = course();
        let recorded = vec![true; course.len()];
        let life = Life::of(&course, &situations, &doses, &recorded);
        let kind = KINDS.into_iter().find(|kind| kind.name == name).expect("a kind");
        let covariates = |unit: &Unit| -> Vec<f64> {
            kind.covariates.iter().map(|(_, of)| of(&life, unit)).collect()
        };
        let units = (kind.units)(&life);
        units.iter().map(|u| (u.steps.start, u.steps.len(), covariates(u))).collect()
    }

    #[test]
    fn meals_last_three_hours_and_dinners_until_the_next_meal() {
        let meals = found("meal");
        assert_eq!(meals.len(), 6);
        assert_eq!((meals[1].0, meals[1].1), (18 * STEPS_PER_HOUR, 3 * STEPS_PER_HOUR));
        // Size, not breakfast, dinner, glucose, no weekend, with a bolus, no exercise, 8 U for 80 g.
        assert_eq!(meals[1].2, [80f64.ln(), 0.0, 1.0, 120.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(meals[0].2[5], 1.0);
        // The run of the second day ended two hours before lunch.
        assert!((meals[2].2[6] - 1.0).abs() < 0.1);
        // The last evening ends after six hours.
        let dinners = found("dinner");
        let lengths: Vec<usize> = dinners.iter().map(|d| d.1).collect();
        assert_eq!(lengths, [8, 8, 6].map(|hours| hours * STEPS_PER_HOUR));
    }

    #[test]
    fn bouts_lows_nights_and_clocks_are_where_they_were() {
        let bouts = found("bout");
        assert_eq!(bouts.len(), 1);
        let end = bouts[0].0 + bouts[0].1;
        assert_eq!(found("after bout")[0].0, end);
        let lows = found("after low");
        assert_eq!((lows.len(), lows[0].1), (1, 3 * STEPS_PER_HOUR));
        assert_eq!(lows[0].2, [10.0, 0.0]);
        // Whole nights only: that of the third day is cut off.
        assert_eq!(found("night").len(), 2);
        assert_eq!(found("03-06").len(), 3);
        assert_eq!(found("half hour low").len(), 2);
        assert_eq!(found("below 70").len(), 2);
    }

    #[test]
    fn kinds_that_the_record_does_not_show_are_absent_and_units_end_with_it() {
        for absent in ["set day", "old set", "sensor day", "high", "above 180"] {
            assert!(found(absent).is_empty(), "{absent}");
        }
        for kind in KINDS {
            let end = |(start, length, _): (usize, usize, Vec<f64>)| start + length;
            assert!(found(kind.name).into_iter().map(end).all(|end| end <= 3 * STEPS_PER_DAY));
        }
    }
}
