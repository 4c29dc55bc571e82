//! The true situations at each step of a life, by the names of the exchange format.
//!
//! A diagnosis reads the same situations from a record and may confuse them; this module reads them
//! from the life itself.

use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

use crate::behaviour::MealKind;
use crate::calendar::within;
use crate::therapy::Regime;
use crate::virtual_person::{LivedDays, VirtualPerson};

named::named! {
    /// A situation. Several may hold at once.
    Situation {
        /// Within 3 h of a meal of at least 15 g, logged or not.
        AfterMeal: "after_meal",
        /// Within 5 h of a dinner.
        AfterDinner: "after_dinner",
        /// Within a session.
        Exercise: "exercise",
        /// Within 10 h of the end of a session, and in none.
        AfterExercise: "after_exercise",
        /// Asleep.
        Sleep: "sleep",
        /// Awake after less than 6 h of sleep.
        DayAfterShortSleep: "day_after_short_sleep",
        /// Within 2 h of glucose below 70 mg/dL.
        AfterLow: "after_low",
        /// The infusion set is two days old or older.
        SetDay3Plus: "set_day_3_plus",
        /// The sensor is in the last third of its life.
        SensorLate: "sensor_late",
        /// Glucose moved by more than 2 mg/dL/min over 15 min.
        FastChange: "fast_change",
        /// Saturday or Sunday.
        Weekend: "weekend",
        /// None of these.
        Other: "other",
    }
}

/// Smallest meal that counts, g.
const MEAL: f64 = 15.0;
/// Share of its life after which a sensor counts as late.
const LATE: f64 = 2.0 / 3.0;
/// Hours of a night below which it is short.
const SHORT_NIGHT: f64 = 6.0;

/// The situations of every step of a life.
pub(super) struct Situations(Vec<[bool; Situation::ALL.len()]>);

impl Situations {
    pub(super) fn of(person: &VirtualPerson, lived: &LivedDays) -> Self {
        let (life, n) = (&lived.life, lived.glucose.len());
        let (wear, _) = person.wear(life);
        let mut held = vec![[false; Situation::ALL.len()]; n];
        let mut mark = |situation: Situation, from: i64, to: i64| {
            for step in &mut held[within(from..to, n)] {
                step[situation as usize] = true;
            }
        };
        let hours = |count: usize| (count * STEPS_PER_HOUR) as i64;
        for meal in &life.meals {
            let start = meal.step as i64;
            if meal.eaten.0 >= MEAL {
                mark(Situation::AfterMeal, start, start + hours(3));
            }
            if meal.kind == MealKind::Dinner {
                mark(Situation::AfterDinner, start, start + hours(5));
            }
        }
        for session in &life.sessions {
            let (start, end) = (session.start as i64, (session.start + session.steps) as i64);
            mark(Situation::Exercise, start, end);
            mark(Situation::AfterExercise, end, end + hours(10));
        }
        for (night, next) in life.nights.iter().zip(life.nights.iter().skip(1)) {
            if night.hours() < SHORT_NIGHT {
                mark(Situation::DayAfterShortSleep, night.wake, next.onset);
            }
        }
        for (step, glucose) in lived.glucose.iter().enumerate() {
            let now = step as i64;
            if glucose.0 < 70.0 {
                mark(Situation::AfterLow, now, now + hours(2));
            }
            let before = step.checked_sub(3).map_or(glucose, |earlier| &lived.glucose[earlier]);
            let old_set = person.regime != Regime::Mdi && life.sets.age_days(step) >= 2.0;
            let late_from = LATE * person.everyday.sensor.life_days as f64;
            let of_the_step = [
                (Situation::FastChange, (glucose.0 - before.0).abs() > 30.0),
                (Situation::Sleep, life.is_asleep(step)),
                (Situation::SetDay3Plus, old_set),
                (Situation::SensorLate, wear.age_days(step) >= late_from),
                (Situation::Weekend, life.calendar.is_weekend(step / STEPS_PER_DAY)),
            ];
            for (situation, _) in of_the_step.into_iter().filter(|(_, holds)| *holds) {
                mark(situation, now, now + 1);
            }
        }
        for step in &mut held {
            step[Situation::AfterExercise as usize] &= !step[Situation::Exercise as usize];
            step[Situation::Other as usize] = !step.contains(&true);
        }
        Self(held)
    }

    /// Whether a situation holds at a step; `false` beyond the life.
    pub(super) fn holds(&self, situation: Situation, step: usize) -> bool {
        self.0.get(step).is_some_and(|held| held[situation as usize])
    }
}
