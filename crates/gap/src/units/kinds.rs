//! What varies, as a person could point at it: meals, boluses, nights, days, bouts of exercise, infusion sets, lows.

use std::ops::Range;

use effects::Course;
use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

use super::doses::Doses;
use crate::context::{Situation, Situations};

/// Least carbohydrate of a meal, g, and least dose of a bolus, U.
const MEAL: f64 = 10.0;
const BOLUS: f64 = 1.0;
/// Rise of glucose in 15 min that a meal would make, mg/dL.
const RISE: f64 = 9.0;
/// Logarithm of an amount of insulin over the usual one that is much; one below it by as much is little.
const MUCH: f64 = 0.4;
/// Steps of half an hour.
const HALF_HOUR: usize = STEPS_PER_HOUR / 2;

/// A kind of unit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kind {
    pub(super) name: &'static str,
    /// What may explain how units of this kind differ.
    pub(super) covariates: &'static [&'static str],
    /// Whether a person's day and response to glucose are left in the innovations: they are what the kind asks about.
    pub(super) plain: bool,
    /// Periods at which units may come and go, by name: units each.
    pub(super) rhythms: &'static [(&'static str, usize)],
    /// A person's units; none where the record does not show the kind.
    units: fn(&Life<'_>) -> Vec<Unit>,
}

const fn kind(
    name: &'static str,
    covariates: &'static [&'static str],
    units: fn(&Life<'_>) -> Vec<Unit>,
) -> Kind {
    Kind { name, covariates, plain: false, rhythms: &[], units }
}

const fn plain(name: &'static str, units: fn(&Life<'_>) -> Vec<Unit>) -> Kind {
    Kind { name, covariates: &[], plain: true, rhythms: &[], units }
}

const OF_NIGHTS: &[&str] =
    &["hours asleep", "exercise", "evening carbohydrate", "weekend", "glucose", "insulin"];
const OF_DAYS: &[&str] =
    &["short night", "exercise before", "weekend", "date", "set age", "insulin"];
const OF_MEALS: &[&str] = &[
    "size",
    "breakfast",
    "dinner",
    "glucose",
    "weekend",
    "no bolus",
    "exercise",
    "insulin per carbohydrate",
];

/// The kinds.
pub(super) const KINDS: [Kind; 40] = [
    kind("meal", OF_MEALS, |life| {
        life.meals(0..3 * STEPS_PER_HOUR, |k| {
            let bolus = life.sum(&life.course.bolus, k, 6, 6);
            vec![
                life.course.carbs[k].ln(),
                life.within_hours(k, 5.0..10.0),
                life.within_hours(k, 17.0..22.0),
                life.course.glucose[k],
                flag(life.course.weekend[k]),
                flag(bolus <= 0.0),
                life.exercised(k, 10 * STEPS_PER_HOUR),
                insulin_per_carbohydrate(bolus, life.course.carbs[k]),
            ]
        })
    }),
    kind("late meal", &["size", "dinner"], |life| {
        life.meals(3 * STEPS_PER_HOUR..8 * STEPS_PER_HOUR, |k| {
            vec![life.course.carbs[k].ln(), life.within_hours(k, 17.0..22.0)]
        })
    }),
    kind("dinner", &["size"], |life| {
        let mut dinners = life.meals(0..8 * STEPS_PER_HOUR, |k| vec![life.course.carbs[k].ln()]);
        dinners.retain(|unit| (17.0..22.0).contains(&life.course.hour[unit.steps.start]));
        dinners
    }),
    kind("bolus", &["dose", "correction", "set age", "glucose"], |life| life.boluses()),
    kind("bolus without meal", &["dose", "glucose", "mealtime"], |life| {
        life.boluses_without_meal()
    }),
    kind("rise without meal", &["rate", "low before"], |life| life.rises()),
    kind("much insulin", &["insulin"], |life| life.doses_that(|over| over >= MUCH)),
    kind("little insulin", &["insulin"], |life| life.doses_that(|over| over <= -MUCH)),
    kind("night", OF_NIGHTS, |life| life.nights(23.0, 8.0)),
    kind("late night", OF_NIGHTS, |life| life.nights(3.0, 5.0)),
    Kind {
        name: "day",
        covariates: OF_DAYS,
        plain: false,
        rhythms: &[("3 days", 3), ("7 days", 7), ("10 days", 10)],
        units: |life| {
            life.blocks(STEPS_PER_DAY, |steps| {
                let middle = usize::midpoint(steps.start, steps.end);
                let noon = (steps.start + STEPS_PER_DAY / 2).min(life.n - 1);
                vec![
                    flag(steps.clone().any(|k| life.short_night[k])),
                    life.exercised(steps.start, STEPS_PER_DAY),
                    flag(life.course.weekend[noon]),
                    middle as f64,
                    life.set_age[noon],
                    life.doses.over_usual(steps),
                ]
            })
        },
    },
    kind("quarter", &["set age", "insulin"], |life| {
        life.blocks(STEPS_PER_DAY / 4, |steps| {
            vec![life.set_age[steps.start], life.doses.over_usual(steps)]
        })
    }),
    kind("three days", &[], |life| life.blocks(3 * STEPS_PER_DAY, |_| Vec::new())),
    kind("hour", &["rate", "glucose"], |life| {
        life.blocks(STEPS_PER_HOUR, |steps| {
            vec![life.rate(steps), life.course.glucose[steps.start]]
        })
    }),
    kind("half hour low", &["depth"], |life| {
        life.half_hours(
            |k| life.course.glucose[k] < 70.0,
            |steps| vec![70.0 - life.course.glucose[steps.start]],
        )
    }),
    kind("half hour asleep", &["rate"], |life| {
        life.half_hours(|k| life.asleep(k), |steps| vec![life.rate(steps)])
    }),
    kind("half hour awake", &["rate"], |life| {
        life.half_hours(|k| !life.asleep(k), |steps| vec![life.rate(steps)])
    }),
    kind("set day", &["age"], |life| match life.course.set_changed {
        Some(_) => life.blocks(STEPS_PER_DAY / 2, |steps| vec![life.set_age[steps.start]]),
        None => Vec::new(),
    }),
    kind("old set", &[], |life| life.stretches(&life.old_set)),
    kind("sensor day", &["age"], |life| match &life.course.sensor_age {
        Some(ages) => life.blocks(STEPS_PER_DAY / 2, |steps| vec![ages[steps.start]]),
        None => Vec::new(),
    }),
    kind("first sensor day", &[], |life| match &life.course.sensor_age {
        Some(ages) => life.stretches(&ages.iter().map(|age| *age < 1.0).collect::<Vec<_>>()),
        None => Vec::new(),
    }),
    kind("bout", &["length"], |life| life.bouts(0, 0)),
    kind("after bout", &["length"], |life| life.bouts(0, 2 * STEPS_PER_HOUR)),
    kind("long after bout", &["length"], |life| {
        life.bouts(2 * STEPS_PER_HOUR, 14 * STEPS_PER_HOUR)
    }),
    kind("after short night", &[], |life| life.stretches(&life.short_night)),
    kind("after low", &["depth", "carbohydrate"], |life| {
        life.episodes(
            |glucose| glucose < 70.0,
            2 * STEPS_PER_HOUR,
            |steps| {
                let lowest = steps.clone().map(|k| life.course.glucose[k]).fold(f64::MAX, f64::min);
                let eaten: f64 = steps.clone().map(|k| life.course.carbs[k]).sum();
                vec![70.0 - lowest, eaten]
            },
        )
    }),
    kind("high", &["height"], |life| {
        life.episodes(
            |glucose| glucose > 200.0,
            0,
            |steps| {
                let most = steps.clone().map(|k| life.course.glucose[k]).fold(0.0, f64::max);
                vec![most - 200.0]
            },
        )
    }),
    kind("evening", &["weekend"], |life| {
        life.clock(18.0, 5.0, |k| vec![flag(life.course.weekend[k])])
    }),
    kind("morning after weekend", &[], |life| {
        let mut mornings = life.clock(4.0, 8.0, |_| Vec::new());
        mornings.retain(|unit| {
            let evening = unit.steps.start.checked_sub(6 * STEPS_PER_HOUR);
            evening.is_some_and(|evening| life.course.weekend[evening])
        });
        mornings
    }),
    plain("00-03", |life| life.clock(0.0, 3.0, |_| Vec::new())),
    plain("03-06", |life| life.clock(3.0, 3.0, |_| Vec::new())),
    plain("06-09", |life| life.clock(6.0, 3.0, |_| Vec::new())),
    plain("09-12", |life| life.clock(9.0, 3.0, |_| Vec::new())),
    plain("12-15", |life| life.clock(12.0, 3.0, |_| Vec::new())),
    plain("15-18", |life| life.clock(15.0, 3.0, |_| Vec::new())),
    plain("18-21", |life| life.clock(18.0, 3.0, |_| Vec::new())),
    plain("21-24", |life| life.clock(21.0, 3.0, |_| Vec::new())),
    plain("below 70", |life| life.half_hours(|k| life.course.glucose[k] < 70.0, |_| Vec::new())),
    plain("70-180", |life| {
        life.half_hours(|k| (70.0..=180.0).contains(&life.course.glucose[k]), |_| Vec::new())
    }),
    plain("above 180", |life| life.half_hours(|k| life.course.glucose[k] > 180.0, |_| Vec::new())),
];

/// One unit.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Unit {
    pub(super) steps: Range<usize>,
    /// In the order of the kind's.
    pub(super) covariates: Vec<f64>,
}

/// A person's units of one kind.
pub(super) struct Units {
    /// Index in [`KINDS`].
    pub(super) kind: usize,
    pub(super) units: Vec<Unit>,
}

/// A person's units, kind by kind; kinds that the record does not show are absent.
///
/// `recorded` says in which steps every dose is on record.
pub(super) fn units(
    course: &Course,
    situations: &Situations,
    doses: &Doses,
    recorded: &[bool],
) -> Vec<Units> {
    let life = Life::of(course, situations, doses, recorded);
    let of_kind = |(kind, of): (usize, &Kind)| Units { kind, units: (of.units)(&life) };
    KINDS.iter().enumerate().map(of_kind).filter(|units| !units.units.is_empty()).collect()
}

/// What defines the units.
struct Life<'a> {
    course: &'a Course,
    doses: &'a Doses,
    recorded: &'a [bool],
    n: usize,
    exercise: Vec<bool>,
    short_night: Vec<bool>,
    old_set: Vec<bool>,
    /// Days since the last change of a set; 0 where none is on record.
    set_age: Vec<f64>,
}

impl<'a> Life<'a> {
    fn of(
        course: &'a Course,
        situations: &Situations,
        doses: &'a Doses,
        recorded: &'a [bool],
    ) -> Self {
        let n = course.len();
        let holds = |situation| (0..n).map(|k| situations.holds(situation, k)).collect();
        let mut changed = None;
        let set_age = (0..n)
            .map(|k| {
                if course.set_changed.as_ref().is_some_and(|changes| changes[k]) {
                    changed = Some(k);
                }
                changed.map_or(0.0, |at| (k - at) as f64 / STEPS_PER_DAY as f64)
            })
            .collect();
        Self {
            course,
            doses,
            recorded,
            n,
            exercise: holds(Situation::Exercise),
            short_night: holds(Situation::DayAfterShortSleep),
            old_set: holds(Situation::SetDay3Plus),
            set_age,
        }
    }

    fn within_hours(&self, k: usize, hours: Range<f64>) -> f64 {
        flag(hours.contains(&self.course.hour[k]))
    }

    fn sum(&self, values: &[f64], k: usize, before: usize, after: usize) -> f64 {
        values[k.saturating_sub(before)..(k + after).min(self.n)].iter().sum()
    }

    /// Whether it is on record that nothing was eaten from so many steps before to so many after.
    fn nothing_eaten(&self, k: usize, before: usize, after: usize) -> bool {
        let steps = k.saturating_sub(before)..(k + after).min(self.n);
        self.recorded[steps.clone()].iter().all(|recorded| *recorded)
            && self.course.carbs[steps].iter().sum::<f64>() <= 0.0
    }

    /// Hours of exercise in the steps before.
    fn exercised(&self, k: usize, before: usize) -> f64 {
        let steps = &self.exercise[k.saturating_sub(before)..k];
        steps.iter().filter(|now| **now).count() as f64 / STEPS_PER_HOUR as f64
    }

    fn asleep(&self, k: usize) -> bool {
        match &self.course.asleep {
            Some(asleep) => asleep[k].is_some_and(|share| share >= 0.5),
            None => !(7.0..23.0).contains(&self.course.hour[k]),
        }
    }

    /// Change of glucose in the quarter of an hour before, mg/dL.
    fn rate(&self, steps: &Range<usize>) -> f64 {
        let before = steps.start.saturating_sub(3);
        self.course.glucose[steps.start] - self.course.glucose[before]
    }

    /// Windows after meals, until the next.
    fn meals(&self, window: Range<usize>, covariates: impl Fn(usize) -> Vec<f64>) -> Vec<Unit> {
        let meals: Vec<usize> = (0..self.n).filter(|k| self.course.carbs[*k] >= MEAL).collect();
        self.after(&meals, window, covariates)
    }

    fn boluses(&self) -> Vec<Unit> {
        let boluses: Vec<usize> = (0..self.n).filter(|k| self.course.bolus[*k] >= BOLUS).collect();
        self.after(&boluses, 0..5 * STEPS_PER_HOUR, |k| {
            let eaten = self.sum(&self.course.carbs, k, STEPS_PER_HOUR, STEPS_PER_HOUR);
            vec![
                self.course.bolus[k].ln(),
                flag(eaten <= 0.0),
                self.set_age[k],
                self.course.glucose[k],
            ]
        })
    }

    /// The minutes around boluses beside which nothing was eaten: when a meal that is not on the log would begin.
    fn boluses_without_meal(&self) -> Vec<Unit> {
        let doses =
            (0..self.n).filter(|k| self.course.bolus[*k] >= BOLUS || self.course.carbs[*k] >= MEAL);
        let starts: Vec<usize> = doses.collect();
        let mut found = self.after(&starts, 0..3 * STEPS_PER_HOUR, |k| {
            let mealtimes = [7.0..10.0, 12.0..15.0, 18.0..21.0];
            vec![
                self.course.bolus[k].max(0.1).ln(),
                self.course.glucose[k],
                mealtimes.into_iter().map(|hours| self.within_hours(k, hours)).sum(),
            ]
        });
        found.retain(|unit| {
            let k = unit.steps.start;
            self.course.bolus[k] >= BOLUS && self.nothing_eaten(k, STEPS_PER_HOUR, STEPS_PER_HOUR)
        });
        for unit in &mut found {
            let k = unit.steps.start;
            unit.steps = k.saturating_sub(1)..(k + 5).min(self.n);
        }
        found
    }

    /// The time before glucose rises while nothing was eaten for long.
    fn rises(&self) -> Vec<Unit> {
        let mut found = self.blocks(HALF_HOUR, |steps| {
            let before =
                &self.course.glucose[steps.start.saturating_sub(STEPS_PER_HOUR)..=steps.start];
            vec![self.rate(steps), flag(before.iter().any(|glucose| *glucose < 75.0))]
        });
        found.retain(|unit| {
            let k = unit.steps.start;
            unit.covariates[0] >= RISE && self.nothing_eaten(k, 3 * STEPS_PER_HOUR, HALF_HOUR)
        });
        for unit in &mut found {
            let start = unit.steps.start;
            unit.steps = start.saturating_sub(HALF_HOUR)..(start + HALF_HOUR / 2).min(self.n);
        }
        found
    }

    /// Stretches at the end of six hours with another amount of insulin than usual at their time of day.
    fn doses_that(&self, differ: impl Fn(f64) -> bool) -> Vec<Unit> {
        let window = 6 * STEPS_PER_HOUR;
        let holds: Vec<bool> = (0..self.n)
            .map(|k| k >= window && differ(self.doses.over_usual(&(k - window..k))))
            .collect();
        let mut found = self.stretches(&holds);
        for unit in &mut found {
            unit.covariates = vec![self.doses.over_usual(&unit.steps)];
        }
        found
    }

    /// A window after each start, until the next start.
    fn after(
        &self,
        starts: &[usize],
        window: Range<usize>,
        covariates: impl Fn(usize) -> Vec<f64>,
    ) -> Vec<Unit> {
        let ends = starts.iter().skip(1).copied().chain(std::iter::once(self.n));
        let unit = |(start, next): (&usize, usize)| {
            let steps = start + window.start..(start + window.end).min(next);
            (steps.len() >= HALF_HOUR).then(|| Unit { covariates: covariates(*start), steps })
        };
        starts.iter().zip(ends).filter_map(unit).collect()
    }

    fn nights(&self, from: f64, hours: f64) -> Vec<Unit> {
        let mut nights = self.clock(from, hours, |_| Vec::new());
        for night in &mut nights {
            let start = night.steps.start;
            let asleep = night.steps.clone().filter(|k| self.asleep(*k)).count();
            let evening = start.saturating_sub(6 * STEPS_PER_HOUR);
            night.covariates = vec![
                asleep as f64 / STEPS_PER_HOUR as f64,
                self.exercised(start, STEPS_PER_DAY),
                self.course.carbs[evening..start].iter().sum(),
                flag(self.course.weekend[evening]),
                self.course.glucose[start],
                self.doses.over_usual(&night.steps),
            ];
        }
        nights
    }

    /// The hours of the clock from `from` on, every day; whole ones only.
    fn clock(&self, from: f64, hours: f64, covariates: impl Fn(usize) -> Vec<f64>) -> Vec<Unit> {
        let length = (hours * STEPS_PER_HOUR as f64) as usize;
        let starts = (0..self.n).filter(|k| {
            let since = (self.course.hour[*k] - from).rem_euclid(24.0);
            since < 1.0 / STEPS_PER_HOUR as f64 - 1e-9 && k + length <= self.n
        });
        starts.map(|k| Unit { steps: k..k + length, covariates: covariates(k) }).collect()
    }

    /// Blocks one after the other from midnight on.
    fn blocks(&self, length: usize, covariates: impl Fn(&Range<usize>) -> Vec<f64>) -> Vec<Unit> {
        let of_day = (self.course.hour[0] * STEPS_PER_HOUR as f64).round() as usize % STEPS_PER_DAY;
        let first = (STEPS_PER_DAY - of_day) % STEPS_PER_DAY % length;
        let ends = (first..self.n).step_by(length).map(|start| start..(start + length).min(self.n));
        let whole = ends.filter(|steps| 2 * steps.len() >= length);
        whole.map(|steps| Unit { covariates: covariates(&steps), steps }).collect()
    }

    fn half_hours(
        &self,
        wanted: impl Fn(usize) -> bool,
        covariates: impl Fn(&Range<usize>) -> Vec<f64>,
    ) -> Vec<Unit> {
        let mut found = self.blocks(HALF_HOUR, covariates);
        found.retain(|unit| wanted(unit.steps.start));
        found
    }

    /// Where something holds without a break of an hour.
    fn stretches(&self, holds: &[bool]) -> Vec<Unit> {
        let mut found: Vec<Range<usize>> = Vec::new();
        for k in (0..self.n).filter(|k| holds[*k]) {
            match found.last_mut() {
                Some(last) if k < last.end + STEPS_PER_HOUR => last.end = k + 1,
                _ => found.push(k..k + 1),
            }
        }
        found.into_iter().map(|steps| Unit { steps, covariates: Vec::new() }).collect()
    }

    /// From so many steps after the end of a bout of exercise to so many; the bout itself for none.
    fn bouts(&self, from: usize, to: usize) -> Vec<Unit> {
        let mut found = self.stretches(&self.exercise);
        for bout in &mut found {
            bout.covariates = vec![(bout.steps.len() as f64).ln()];
            if to > 0 {
                let end = bout.steps.end;
                bout.steps = (end + from).min(self.n)..(end + to).min(self.n);
            }
        }
        found.retain(|bout| !bout.steps.is_empty());
        found
    }

    /// Stretches of glucose and some steps after them.
    fn episodes(
        &self,
        wanted: impl Fn(f64) -> bool,
        after: usize,
        covariates: impl Fn(&Range<usize>) -> Vec<f64>,
    ) -> Vec<Unit> {
        let holds: Vec<bool> = self.course.glucose[..self.n].iter().map(|g| wanted(*g)).collect();
        let mut found = self.stretches(&holds);
        for episode in &mut found {
            episode.steps.end = (episode.steps.end + after).min(self.n);
            episode.covariates = covariates(&episode.steps);
        }
        found
    }
}

/// Logarithm of insulin per carbohydrate, U over 10 g; finite where either is small.
fn insulin_per_carbohydrate(units: f64, grams: f64) -> f64 {
    ((units + 0.5) / (grams / 10.0 + 0.5)).ln()
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
        let units = units(&course, &situations, &doses, &vec![true; course.len()]);
        let own = units.into_iter().find(|units| KINDS[units.kind].name == name);
        let own = own.map_or_else(Vec::new, |units| units.units);
        own.into_iter().map(|u| (u.steps.start, u.steps.len(), u.covariates)).collect()
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
    fn kinds_that_the_record_does_not_show_are_absent_and_names_are_known() {
        for absent in ["set day", "old set", "sensor day", "high", "above 180"] {
            assert!(found(absent).is_empty(), "{absent}");
        }
        let (course, situations, doses) = course();
        for units in units(&course, &situations, &doses, &vec![true; course.len()]) {
            let kind = KINDS[units.kind];
            assert!(units.units.iter().all(|u| u.covariates.len() == kind.covariates.len()));
            assert!(units.units.iter().all(|u| u.steps.end <= course.len()));
        }
    }
}
