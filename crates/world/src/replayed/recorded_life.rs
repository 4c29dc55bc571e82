//! What a record says about a person's days, in the form in which worlds draw them.

use chrono::Timelike;
use cohort::Person;
use physiology::{Exercise, Grams, STEPS_PER_DAY, STEPS_PER_HOUR};
use rand::{Rng, RngExt};

use super::doses::median;
use crate::background::Background;
use crate::behaviour::{
    BolusTiming, Habits, InfusionSets, Life, Meal, MealKind, Night, Session, Sport, Wearable,
};
use crate::calendar::Calendar;
use crate::effects::Shapes;
use crate::stream::{Concept, standard_normal, stream};

/// Share of the heart-rate reserve that counts as exercise if held for [`SHORTEST`] steps, per
/// cent: light to moderate intensity begins at 30 and 40 (ACSM).
const EXERCISING: f64 = 35.0;
const SHORTEST: usize = 3;
/// Highest heart rate assumed, 1/min (208 - 0.7 age at 35 years, Tanaka et al. 2001), and the
/// reserve where the record holds differences from rest.
const HIGHEST_RATE: f64 = 183.0;
const RESERVE: f64 = 115.0;
/// Hours about midnight within which a night is searched, its shortest length, and the longest
/// awakening within it, steps.
const NIGHT: (f64, f64) = (-6.0, 14.0);
const SHORTEST_NIGHT: usize = 3 * STEPS_PER_HOUR;
const AWAKENING: usize = STEPS_PER_HOUR;
/// Meals a day that may be eaten besides the record, and how often each is at amplitude 1: about
/// 0.25 a day of 20 to 50 g, as in the made worlds.
const UNLOGGED_A_DAY: usize = 2;
const UNLOGGED_SHARE: f64 = 0.13;

/// A recorded life on a calendar of whole days.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RecordedLife {
    /// The life from the midnight before the record. Its meals hold what was logged.
    pub(super) life: Life,
    /// Sleep times as recorded; everything else is drawn.
    pub(super) habits: Habits,
    /// Steps from that midnight to the start of the record.
    pub(super) offset: usize,
    /// Meals that may be eaten besides the record, each with the amplitude from which on it is.
    pub(super) unlogged: Vec<(usize, Grams, f64)>,
}

impl RecordedLife {
    /// The life of a record.
    pub(super) fn new(seed: u64, index: usize, person: &Person) -> Self {
        let record = &person.record;
        let first = record.start();
        let offset = (first.hour() as usize * 60 + first.minute() as usize) / 5;
        let days = (offset + record.len()).div_ceil(STEPS_PER_DAY);
        let calendar = Calendar::new(first.date(), days);
        let padded = |channel: &[Option<f64>]| -> Vec<Option<f64>> {
            let mut values = vec![None; offset];
            values.extend_from_slice(channel);
            values.resize(calendar.steps(), None);
            values
        };
        let rng = |concept| stream(seed, index, concept);

        let sleep = padded(record.sleep_efficiency());
        let mut habits = Habits::sample(&mut rng(Concept::Habits));
        let (nights, recorded) = nights(&calendar, &sleep, &mut habits);
        let asleep = if recorded {
            sleep.iter().map(|share| share.unwrap_or(0.0)).collect()
        } else {
            lain(&calendar, &nights)
        };
        let heart_rate = padded(record.heart_rate());
        let steps = padded(record.steps());
        let rest = person.resting_heart_rate().map(|found| found.0);
        let sessions = rest.map_or_else(Vec::new, |rest| sessions(&heart_rate, &asleep, rest));
        let logged = padded(record.carbs());
        let meals = meals(&calendar, &logged, &mut rng(Concept::Meals));
        let unlogged = unlogged(&calendar, &nights, &meals, &mut rng(Concept::Counting));
        let changes = padded(record.set_change())
            .iter()
            .enumerate()
            .filter(|(_, change)| **change == Some(1.0))
            .map(|(step, _)| step as i64)
            .collect();
        let life = Life {
            calendar,
            meals,
            sessions,
            nights,
            evenings: Vec::new(),
            sets: InfusionSets::recorded(changes),
            asleep,
            wearable: Wearable { heart_rate, steps },
        };
        Self { life, habits, offset, unlogged }
    }
}

/// Turns the logged carbohydrate of the meals of a recorded life into what was eaten.
pub(super) fn eaten(life: &mut Life, background: &Background, shapes: &Shapes, amplitude: f64) {
    for meal in &mut life.meals {
        let error = background
            .log_counting_error(meal, shapes.forms.miscount, shapes.counting_bias, amplitude)
            .clamp(-1.1, 1.1);
        meal.eaten = Grams(meal.eaten.0 * (-error).exp());
    }
}

/// The nights of the calendar and whether any was recorded; habits take their times from them.
///
/// A night is the longest stretch of sleep between 18:00 and 14:00, with awakenings of up to an
/// hour. A night that was not recorded is an ordinary one.
fn nights(calendar: &Calendar, sleep: &[Option<f64>], habits: &mut Habits) -> (Vec<Night>, bool) {
    let found: Vec<Option<(i64, i64)>> = (0..=calendar.days())
        .map(|day| {
            let window = calendar.signed_step(day, NIGHT.0)..calendar.signed_step(day, NIGHT.1);
            longest_sleep(sleep, window)
        })
        .collect();
    let hours = |steps: i64| steps as f64 / STEPS_PER_HOUR as f64;
    let of = |time: &dyn Fn(usize, (i64, i64)) -> i64| -> Option<f64> {
        let all = found.iter().enumerate().filter_map(|(day, night)| Some(time(day, (*night)?)));
        median(all.map(hours).collect())
    };
    let midnight = |day: usize| calendar.signed_step(day, 0.0);
    let usual = of(&|_, (onset, wake)| wake - onset);
    if let (Some(bed), Some(wake)) =
        (of(&|day, (onset, _)| onset - midnight(day)), of(&|day, (_, wake)| wake - midnight(day)))
    {
        habits.bed_hour = 24.0 + bed;
        habits.wake_hour = wake;
    }
    let nights = found
        .iter()
        .enumerate()
        .map(|(day, night)| match (night, usual) {
            (Some((onset, wake)), Some(usual)) => Night {
                day,
                onset: *onset,
                wake: *wake,
                hours_short: (usual - hours(wake - onset)).max(0.0),
            },
            _ => Night {
                day,
                onset: calendar.signed_step(day, habits.bed_hour - 24.0),
                wake: calendar.signed_step(day, habits.wake_hour),
                hours_short: 0.0,
            },
        })
        .collect();
    (nights, usual.is_some())
}

/// First and last step (exclusive) of the longest stretch of sleep in a window.
fn longest_sleep(sleep: &[Option<f64>], window: std::ops::Range<i64>) -> Option<(i64, i64)> {
    let asleep = |step: i64| {
        let at = usize::try_from(step).ok();
        at.and_then(|s| sleep.get(s).copied().flatten()).is_some_and(|share| share > 0.5)
    };
    let mut best: Option<(i64, i64)> = None;
    let mut current: Option<(i64, i64)> = None;
    for step in window {
        if !asleep(step) {
            continue;
        }
        current = match current {
            Some((onset, wake)) if step - wake <= AWAKENING as i64 => Some((onset, step + 1)),
            _ => Some((step, step + 1)),
        };
        let length = |night: Option<(i64, i64)>| night.map_or(0, |(onset, wake)| wake - onset);
        if length(current) > length(best) {
            best = current;
        }
    }
    best.filter(|(onset, wake)| wake - onset >= SHORTEST_NIGHT as i64)
}

/// Whether each step lies in a night, 0 or 1.
fn lain(calendar: &Calendar, nights: &[Night]) -> Vec<f64> {
    let mut asleep = vec![0.0; calendar.steps()];
    for night in nights {
        for step in night.onset..night.wake {
            if let Some(slot) = usize::try_from(step).ok().and_then(|s| asleep.get_mut(s)) {
                *slot = 1.0;
            }
        }
    }
    asleep
}

/// Stretches of a raised heart rate, each at its mean intensity.
///
/// The share of the heart-rate reserve is that of VO2max (Swain and Leutholtz, Med Sci Sports Exerc
/// 1997;29:410).
fn sessions(heart_rate: &[Option<f64>], asleep: &[f64], rest: f64) -> Vec<Session> {
    let reserve = if rest > 30.0 { (HIGHEST_RATE - rest).max(60.0) } else { RESERVE };
    let intensity = |step: usize| -> Option<f64> {
        let share = 100.0 * (heart_rate[step]? - rest) / reserve;
        (asleep[step] < 0.5 && share >= EXERCISING).then_some(share)
    };
    let mut sessions = Vec::new();
    let mut step = 0;
    while step < heart_rate.len() {
        let bout: Vec<f64> = (step..heart_rate.len()).map_while(intensity).collect();
        if bout.len() >= SHORTEST {
            let mean = bout.iter().sum::<f64>() / bout.len() as f64;
            sessions.push(Session {
                start: step,
                steps: bout.len(),
                sport: Sport::Walking,
                exercise: Exercise { vo2max_percent: mean.min(90.0), active_muscle_share: 0.5 },
            });
        }
        step += bout.len().max(1);
    }
    sessions
}

/// Every logged entry as a meal that holds what was logged, with draws of its own.
fn meals(calendar: &Calendar, logged: &[Option<f64>], rng: &mut (impl Rng + ?Sized)) -> Vec<Meal> {
    let entries = logged
        .iter()
        .enumerate()
        .filter_map(|(step, grams)| grams.filter(|grams| *grams > 0.0).map(|grams| (step, grams)));
    entries
        .map(|(step, grams)| {
            let kind = match calendar.hour(step) {
                hour if grams >= 15.0 && (4.5..10.5).contains(&hour) => MealKind::Breakfast,
                hour if grams >= 20.0 && (11.0..15.5).contains(&hour) => MealKind::Lunch,
                hour if grams >= 20.0 && (17.5..23.0).contains(&hour) => MealKind::Dinner,
                _ => MealKind::Snack,
            };
            let (rich_draw, rich_size) = (rng.random::<f64>(), rng.random_range(0.5..1.0));
            let rich = match kind {
                MealKind::Dinner => 0.5,
                MealKind::Lunch => 0.15,
                MealKind::Breakfast | MealKind::Snack => 0.0,
            };
            let mut draw = || standard_normal(rng).clamp(-2.0, 2.0);
            let (counting_draw, second_counting_draw) = (draw(), draw());
            Meal {
                step,
                kind,
                eaten: Grams(grams),
                log_counting_error: -0.085 + 0.26 * counting_draw,
                counting_draw,
                second_counting_draw,
                logging_draw: 1.0,          // it was logged
                bolus: BolusTiming::Missed, // the record has the bolus
                richness: if rich_draw < rich { rich_size } else { 0.0 },
            }
        })
        .collect()
}

/// What may be eaten besides the record: awake, at least an hour from anything logged.
fn unlogged(
    calendar: &Calendar,
    nights: &[Night],
    meals: &[Meal],
    rng: &mut (impl Rng + ?Sized),
) -> Vec<(usize, Grams, f64)> {
    let mut eaten = Vec::new();
    for day in 0..calendar.days() {
        for _ in 0..UNLOGGED_A_DAY {
            let (hour, grams) = (rng.random_range(7.0..22.0), rng.random_range(20.0..50.0));
            let from = rng.random::<f64>() / UNLOGGED_SHARE;
            let Some(step) = calendar.step_at(day, hour) else { continue };
            let awake = nights.get(day).is_none_or(|night| step as i64 > night.wake);
            let apart = meals.iter().all(|meal| meal.step.abs_diff(step) > STEPS_PER_HOUR);
            if awake && apart {
                eaten.push((step, Grams(f64::round(grams)), from));
            }
        }
    }
    eaten
}
