//! The situations in which errors are averaged: clock, events, glucose.
//!
//! A situation is read at the step from which a prediction starts, and from nothing later: clock,
//! logged events up to that step, and the filtered glucose. Conditioning on what comes after (a
//! reading above 180, a rescue, an insulin dose that answers to glucose) would select errors by
//! their own sign and find a gap where there is none.

use chrono::Timelike;
use cohort::Person;
use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

named::named! {
    /// A situation of the `context` factor. Several may hold at once.
    ///
    /// `sensor_late` of the exchange format is not among them: no channel tells when a sensor was
    /// inserted.
    Situation {
        /// A meal of at least [`MEAL`] g was logged within the last 3 h.
        AfterMeal: "after_meal",
        /// A meal of at least [`DINNER`] g was logged between 17:00 and 22:00 and within the last 5 h.
        AfterDinner: "after_dinner",
        /// At least two of the last three steps were exercise: heart rate at least
        /// [`EXERCISE_HEART_RATE`] over rest, or at least [`EXERCISE_STEPS`] steps walked.
        Exercise: "exercise",
        /// Exercise within the last 10 h, but not now.
        AfterExercise: "after_exercise",
        /// At least half of the step is asleep.
        Sleep: "sleep",
        /// Less than [`SHORT_SLEEP`] h of sleep since 18:00 of the day before; from 07:00 to 18:00, while
        /// awake.
        DayAfterShortSleep: "day_after_short_sleep",
        /// Filtered glucose below 70 mg/dL within the last 2 h.
        AfterLow: "after_low",
        /// The infusion set is 48 h old or older.
        SetDay3Plus: "set_day_3_plus",
        /// Filtered glucose moved by more than 2 mg/dL/min over the last 15 min.
        FastChange: "fast_change",
        /// Saturday or Sunday.
        Weekend: "weekend",
        /// None of the situations above.
        Other: "other",
    }
}

/// Smallest meal of [`Situation::AfterMeal`], g.
pub const MEAL: f64 = 15.0;
/// Smallest meal of [`Situation::AfterDinner`], g.
pub const DINNER: f64 = 25.0;
/// Heart rate over rest that counts as exercise, 1/min.
pub const EXERCISE_HEART_RATE: f64 = 30.0;
/// Steps walked in five minutes that count as exercise: 80 a minute, a brisk walk.
pub const EXERCISE_STEPS: f64 = 400.0;
/// Sleep below which a night is short, h.
pub const SHORT_SLEEP: f64 = 6.0;

impl Situation {
    /// Whether the situation is recognised from glucose itself.
    #[must_use]
    pub const fn reads_glucose(self) -> bool {
        matches!(self, Self::AfterLow | Self::FastChange)
    }
}

/// Hours of a part of the day. Cells, units and courses all use these parts: a peak of three hours, like that of dawn, then
/// lies in a part of its own.
pub const HOURS_OF_PART: usize = 3;
/// Parts of a day, from midnight on.
pub const PARTS: usize = 24 / HOURS_OF_PART;

/// Levels of the `glucose_band` factor, by filtered glucose: below 70, 70 to 180, above 180 mg/dL.
pub const BANDS: [&str; 3] = ["<70", "70-180", ">180"];

/// Part of the day of a clock hour (0 to 23).
#[must_use]
pub const fn part_of_day(hour: usize) -> usize {
    hour % 24 / HOURS_OF_PART
}

/// The hours of a part of the day, `HH-HH`: a level of the `hour` factor.
#[must_use]
pub fn hours_of_part(part: usize) -> String {
    format!("{:02}-{:02}", HOURS_OF_PART * part, HOURS_OF_PART * (part + 1))
}

/// Index of a glucose value, mg/dL, in [`BANDS`].
#[must_use]
pub fn band(glucose: f64) -> usize {
    if glucose < 70.0 {
        0
    } else if glucose <= 180.0 {
        1
    } else {
        2
    }
}

/// The situations of a person's steps.
#[derive(Debug, Clone, PartialEq)]
pub struct Situations {
    /// By situation: whether it holds at each step.
    held: [Vec<bool>; Situation::ALL.len()],
}

impl Situations {
    /// Recognises the situations of every step.
    ///
    /// `glucose` is the filtered glucose, mg/dL, one a step. A situation whose channel was not
    /// recorded (around that step, for sleep and infusion sets: so far) does not hold anywhere.
    #[must_use]
    pub fn of(person: &Person, glucose: &[f64]) -> Self {
        let record = &person.record;
        let n = record.len().min(glucose.len());
        let mut held: [Vec<bool>; Situation::ALL.len()] = Default::default();
        let mut mark = |situation: Situation, holds: Vec<bool>| held[situation as usize] = holds;
        let carbs = |k: usize| record.carbs()[k].unwrap_or(0.0);
        mark(Situation::AfterMeal, within((0..n).map(|k| carbs(k) >= MEAL), 3 * STEPS_PER_HOUR));
        let dinner = |k: usize| carbs(k) >= DINNER && (17..22).contains(&record.hour(k));
        mark(Situation::AfterDinner, within((0..n).map(dinner), 5 * STEPS_PER_HOUR));

        let exercise = exercise(person, n);
        let recent = within(exercise.iter().copied(), 10 * STEPS_PER_HOUR);
        let after = recent.iter().zip(&exercise).map(|(r, e)| *r && !e).collect();
        mark(Situation::AfterExercise, after);
        mark(Situation::Exercise, exercise);

        let asleep: Vec<bool> =
            (0..n).map(|k| record.sleep_efficiency()[k].is_some_and(|s| s >= 0.5)).collect();
        mark(Situation::DayAfterShortSleep, after_short_sleep(person, &asleep));
        mark(Situation::Sleep, asleep);

        let low = glucose[..n].iter().map(|g| *g < 70.0);
        mark(Situation::AfterLow, within(low, 2 * STEPS_PER_HOUR));
        let fast = |k: usize| k >= 3 && (glucose[k] - glucose[k - 3]).abs() > 2.0 * 15.0;
        mark(Situation::FastChange, (0..n).map(fast).collect());
        // The age of a set is unknown before the first change.
        let changed =
            record.set_change()[..n].iter().map(|change| change.is_some_and(|c| c >= 0.5));
        let old = |steps: Option<usize>| steps.is_some_and(|steps| steps >= 2 * STEPS_PER_DAY);
        mark(Situation::SetDay3Plus, since(changed).map(old).collect());
        mark(Situation::Weekend, (0..n).map(|k| record.weekend(k)).collect());
        let other = Situation::Other as usize;
        held[other] = (0..n).map(|k| held[..other].iter().all(|holds| !holds[k])).collect();
        Self { held }
    }

    /// Whether a situation holds at a step; `false` beyond the record.
    #[must_use]
    pub fn holds(&self, situation: Situation, step: usize) -> bool {
        self.held[situation as usize].get(step).is_some_and(|holds| *holds)
    }

    /// The situations that hold at a step.
    pub(crate) fn at(&self, step: usize) -> impl Iterator<Item = Situation> {
        Situation::ALL.into_iter().filter(move |situation| self.holds(*situation, step))
    }
}

/// Whether `event` holds at each step or held within the `span` steps before it.
fn within(event: impl Iterator<Item = bool>, span: usize) -> Vec<bool> {
    since(event).map(|steps| steps.is_some_and(|steps| steps < span)).collect()
}

/// Steps since something last held, at each step; `None` before it does first.
pub(crate) fn since(holds: impl Iterator<Item = bool>) -> impl Iterator<Item = Option<usize>> {
    let mut last: Option<usize> = None;
    holds.map(move |now| {
        last = if now { Some(0) } else { last.map(|steps| steps + 1) };
        last
    })
}

fn exercise(person: &Person, n: usize) -> Vec<bool> {
    let rest = person.resting_heart_rate().map(|rest| rest.0);
    let record = &person.record;
    let active: Vec<bool> = (0..n)
        .map(|k| {
            let heart = record.heart_rate()[k].zip(rest);
            heart.is_some_and(|(rate, rest)| rate - rest >= EXERCISE_HEART_RATE)
                || record.steps()[k].is_some_and(|steps| steps >= EXERCISE_STEPS)
        })
        .collect();
    (0..n).map(|k| active[k.saturating_sub(2)..=k].iter().filter(|a| **a).count() >= 2).collect()
}

/// The day after a short night: sleep between 18:00 and noon below [`SHORT_SLEEP`], at least 1 h of
/// it and most of the window recorded, so that a tracker left off does not pass for a short night.
/// Sleep is summed up to the step itself, so the morning of a long sleeper who is still asleep is
/// not called short.
fn after_short_sleep(person: &Person, asleep: &[bool]) -> Vec<bool> {
    let record = &person.record;
    let (evening, noon) = (18 * STEPS_PER_HOUR, 12 * STEPS_PER_HOUR);
    let first = record.start().time().num_seconds_from_midnight() as usize / 300;
    let (mut hours, mut recorded, mut steps_so_far) = (0.0, 0usize, 0usize);
    let mut short = false;
    (0..asleep.len())
        .map(|k| {
            let of_day = (first + k) % STEPS_PER_DAY;
            if of_day == evening {
                (hours, recorded, steps_so_far, short) = (0.0, 0, 0, false);
            }
            if of_day >= evening || of_day < noon {
                let sleep = record.sleep_efficiency()[k];
                hours += sleep.unwrap_or(0.0) / STEPS_PER_HOUR as f64;
                recorded += usize::from(sleep.is_some());
                steps_so_far += 1;
                // 13 h of the night have passed by 07:00.
                short = steps_so_far >= 13 * STEPS_PER_HOUR
                    && 2 * recorded > steps_so_far
                    && (1.0..SHORT_SLEEP).contains(&hours);
            }
            short && of_day >= 7 * STEPS_PER_HOUR && of_day < evening && !asleep[k]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use cohort::{Channel, Record, Therapy};

    /// Three days from Friday 2024-03-08, midnight; nothing recorded.
    fn person() -> Person {
        let start = "2024-03-08T00:00:00".parse().expect("a literal time");
        Person {
            id: "p".into(),
            weight: None,
            therapy: Therapy::Unknown,
            heart_rate_baseline: Some(physiology::BeatsPerMinute(60.0)),
            record: Record::new(start, 3 * STEPS_PER_DAY).expect("on the grid"),
        }
    }

    /// The step at `hour` o'clock of day `day`.
    fn at(day: usize, hour: f64) -> usize {
        day * STEPS_PER_DAY + (hour * STEPS_PER_HOUR as f64) as usize
    }

    /// The steps at which a situation holds, as (first, last) runs.
    fn runs(person: &Person, glucose: &[f64], situation: Situation) -> Vec<(usize, usize)> {
        let situations = Situations::of(person, glucose);
        let mut runs: Vec<(usize, usize)> = Vec::new();
        for step in (0..glucose.len()).filter(|step| situations.holds(situation, *step)) {
            match runs.last_mut() {
                Some((_, last)) if *last + 1 == step => *last = step,
                _ => runs.push((step, step)),
            }
        }
        runs
    }

    fn calm() -> Vec<f64> {
        vec![120.0; 3 * STEPS_PER_DAY]
    }

    #[test]
    fn channels_that_were_not_recorded_give_no_situation() {
        let person = person();
        for situation in Situation::ALL {
            let found = runs(&person, &calm(), situation);
            let expected: &[(usize, usize)] = match situation {
                Situation::Weekend => &[(at(1, 0.0), at(3, 0.0) - 1)],
                Situation::Other => &[(0, at(1, 0.0) - 1)],
                _ => &[],
            };
            assert_eq!(found, expected, "{situation:?}");
        }
    }

    #[test]
    fn meals_hold_from_their_step_on_and_dinners_longer() {
        let mut person = person();
        let carbs = person.record.channel_mut(Channel::Carbs);
        carbs[at(0, 12.0)] = Some(14.0);
        carbs[at(0, 13.0)] = Some(40.0);
        carbs[at(0, 18.0)] = Some(40.0);
        let after_meal = runs(&person, &calm(), Situation::AfterMeal);
        assert_eq!(after_meal, [(at(0, 13.0), at(0, 16.0) - 1), (at(0, 18.0), at(0, 21.0) - 1)]);
        let after_dinner = runs(&person, &calm(), Situation::AfterDinner);
        assert_eq!(after_dinner, [(at(0, 18.0), at(0, 23.0) - 1)]);
    }

    #[test]
    fn exercise_is_a_fast_heart_or_many_steps_twice_in_three_steps() {
        let mut person = person();
        let start = at(0, 10.0);
        for step in start..start + 6 {
            person.record.channel_mut(Channel::HeartRate)[step] = Some(95.0);
        }
        person.record.channel_mut(Channel::Steps)[at(0, 15.0)] = Some(900.0);
        assert_eq!(runs(&person, &calm(), Situation::Exercise), [(start + 1, start + 6)]);
        // Ten hours from the last step of exercise.
        let after = runs(&person, &calm(), Situation::AfterExercise);
        assert_eq!(after, [(start + 7, start + 6 + 10 * STEPS_PER_HOUR - 1)]);
    }

    #[test]
    fn the_day_after_a_short_night_ends_at_six_in_the_evening() {
        let mut person = person();
        // First night: asleep 01:00 to 05:00 (4 h); second: 23:00 to 07:00 (8 h).
        let sleep = person.record.channel_mut(Channel::SleepEfficiency);
        sleep[..at(2, 12.0)].fill(Some(0.0));
        sleep[at(1, 1.0)..at(1, 5.0)].fill(Some(1.0));
        sleep[at(1, 23.0)..at(2, 7.0)].fill(Some(1.0));
        let short = runs(&person, &calm(), Situation::DayAfterShortSleep);
        assert_eq!(short, [(at(1, 7.0), at(1, 18.0) - 1)]);
        let asleep = runs(&person, &calm(), Situation::Sleep);
        assert_eq!(asleep, [(at(1, 1.0), at(1, 5.0) - 1), (at(1, 23.0), at(2, 7.0) - 1)]);
    }

    #[test]
    fn glucose_and_infusion_sets_make_their_situations() {
        let mut person = person();
        person.record.channel_mut(Channel::SetChange)[at(0, 6.0)] = Some(1.0);
        let set = runs(&person, &calm(), Situation::SetDay3Plus);
        assert_eq!(set, [(at(2, 6.0), at(3, 0.0) - 1)]);

        let mut glucose = calm();
        glucose[at(0, 8.0)] = 69.0;
        let low = runs(&person, &glucose, Situation::AfterLow);
        assert_eq!(low, [(at(0, 8.0), at(0, 10.0) - 1)]);
        // A fall of 51 mg/dL within 15 min and the rise after it; 29 mg/dL would not do.
        let fast = runs(&person, &glucose, Situation::FastChange);
        assert_eq!(fast, [(at(0, 8.0), at(0, 8.0)), (at(0, 8.25), at(0, 8.25))]);
        glucose[at(0, 8.0)] = 91.0;
        assert_eq!(runs(&person, &glucose, Situation::FastChange), []);
    }

    #[test]
    fn hours_and_bands_cover_everything_once() {
        for hour in 0..24 {
            let level = hours_of_part(part_of_day(hour));
            let (first, end) = level.split_once('-').expect("two hours");
            let (first, end): (usize, usize) =
                (first.parse().expect("an hour"), end.parse().expect("an hour"));
            assert!((first..end).contains(&hour), "{hour} in {level}");
        }
        assert_eq!((PARTS, hours_of_part(2).as_str()), (8, "06-09"));
        assert_eq!([69.9, 70.0, 180.0, 180.1].map(band), [0, 1, 1, 2]);
    }
}
