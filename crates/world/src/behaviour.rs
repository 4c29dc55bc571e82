//! What a person does, day by day: sleep, meals, exercise, alcohol, infusion sets, wearable.
//!
//! Each file states its distributions and their sources. Nothing here depends on glucose: a life is
//! drawn before the body is simulated, so another body can live the same life, also under another
//! therapy or without an effect.

mod alcohol;
mod exercise;
mod habits;
mod hours;
mod infusion_sets;
mod meals;
mod sleep;
mod wearable;

pub use alcohol::Drinking;
pub use exercise::Session;
pub use habits::{Habits, Sport};
pub use hours::{Hours, Shift};
pub use infusion_sets::InfusionSets;
pub use meals::{BolusTiming, Meal, MealKind};
pub use sleep::Night;
pub use wearable::Wearable;

use physiology::STEPS_PER_DAY;

use crate::calendar::Calendar;
use crate::stream::{Concept, stream};

/// Everything a person does over the days of a calendar.
#[derive(Debug, Clone, PartialEq)]
pub struct Life {
    /// The days.
    pub calendar: Calendar,
    /// Meals, ordered by step.
    pub meals: Vec<Meal>,
    /// Exercise sessions, ordered by step.
    pub sessions: Vec<Session>,
    /// One night a day, and one more for the last evening.
    pub nights: Vec<Night>,
    /// Hour of waking of a usual weekday. Of people who work in shifts that rotate it is that of their early days: a
    /// body's clock hardly follows such shifts (Boivin and Boudreau, Pathol Biol 2014;62:292).
    pub usual_wake_hour: f64,
    /// Evenings with alcohol.
    pub evenings: Vec<Drinking>,
    /// Infusion sets.
    pub sets: InfusionSets,
    /// Share of each step asleep, 0 to 1.
    pub asleep: Vec<f64>,
    /// Heart rate and steps.
    pub wearable: Wearable,
}

impl Life {
    /// Draws the life of person `person` of the world with this seed.
    #[must_use]
    pub fn sample(habits: &Habits, calendar: Calendar, seed: u64, person: usize) -> Self {
        Self::sample_with(habits, &Hours::REGULAR, calendar, seed, person)
    }

    /// As [`Self::sample`], with the person's own hours.
    #[must_use]
    pub fn sample_with(
        habits: &Habits,
        hours: &Hours,
        calendar: Calendar,
        seed: u64,
        person: usize,
    ) -> Self {
        let rng = |concept| stream(seed, person, concept);
        let evenings = alcohol::evenings(habits, hours, &calendar, &mut rng(Concept::Alcohol));
        let late: Vec<usize> = evenings.iter().map(|e| e.step / STEPS_PER_DAY).collect();
        let mut sleep_rng = rng(Concept::Sleep);
        let nights = sleep::nights(habits, hours, &calendar, &late, &mut sleep_rng);
        let asleep = sleep::efficiency(habits, &calendar, &nights, &mut sleep_rng);
        let sessions =
            exercise::sessions(habits, hours, &calendar, &nights, &mut rng(Concept::Exercise));
        let mut meals = meals::meals(habits, hours, &calendar, &nights, &mut rng(Concept::Meals));
        meals::count_again(&mut meals, &mut rng(Concept::Counting));
        let sets = InfusionSets::sample(habits, &calendar, &mut rng(Concept::InfusionSets));
        let wearable =
            wearable::wearable(habits, &calendar, &asleep, &sessions, &mut rng(Concept::Wearable));
        let usual_wake_hour = habits.wake_hour + hours.always_later();
        Self {
            calendar,
            meals,
            sessions,
            nights,
            usual_wake_hour,
            evenings,
            sets,
            asleep,
            wearable,
        }
    }

    /// The session that covers a step, if there is one.
    #[must_use]
    pub fn session_at(&self, step: usize) -> Option<&Session> {
        self.sessions.iter().find(|s| s.covers(step))
    }

    /// Whether the person is mostly asleep in a step.
    #[must_use]
    pub fn is_asleep(&self, step: usize) -> bool {
        self.asleep.get(step).is_some_and(|share| *share > 0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chrono::NaiveDate;

    /// Twelve lives of twelve weeks, each of another person.
    fn lives() -> Vec<(Habits, Life)> {
        let monday = NaiveDate::from_ymd_opt(2024, 1, 8).expect("a date");
        (0..12)
            .map(|person| {
                let habits = Habits::sample(&mut stream(3, person, Concept::Habits));
                (habits, Life::sample(&habits, Calendar::new(monday, 84), 3, person))
            })
            .collect()
    }

    fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
        let values: Vec<f64> = values.into_iter().collect();
        values.iter().sum::<f64>() / values.len() as f64
    }

    #[test]
    fn counts_per_day_lie_where_their_sources_put_them() {
        for (habits, life) in lives() {
            let days = life.calendar.days() as f64;
            let main = life.meals.iter().filter(|m| m.kind != MealKind::Snack).count() as f64;
            // 3 - 1/12 - 1/30 = 2.88; SD over 84 days below 0.04.
            assert!((2.7..=3.0).contains(&(main / days)), "{}", main / days);
            let snacks = life.meals.len() as f64 - main;
            // Poisson over 84 days: four standard errors, and a few fall on another meal.
            let tolerance = 4.0 * (habits.snacks_per_day / days).sqrt() + 0.05;
            assert!((snacks / days - habits.snacks_per_day).abs() < tolerance);
            let weekly = 7.0 * life.sessions.len() as f64 / days;
            assert!((1.8..=5.5).contains(&weekly), "{weekly}"); // 3.5, binomial SD 0.39 x 4
            let changes = life.sets.changes().iter().filter(|change| **change >= 0).count();
            let interval = 0.5 + days / changes as f64;
            assert!((interval - habits.set_change_days).abs() < 0.4, "{interval}"); // SD 0.1
            let carbs = life.meals.iter().map(|m| m.eaten.0).sum::<f64>() / days;
            assert!((100.0..300.0).contains(&carbs), "{carbs}");
        }
    }

    #[test]
    fn counting_errors_have_the_published_bias_and_spread() {
        let ratios: Vec<f64> = lives()
            .iter()
            .flat_map(|(_, l)| &l.meals)
            .filter(|m| m.kind != MealKind::Snack)
            .map(|m| m.log_counting_error.exp())
            .collect();
        let under = mean(ratios.iter().map(|r| f64::from(*r < 1.0)));
        let absolute = mean(ratios.iter().map(|r| (r - 1.0).abs()));
        // Brazeau 2013: 63 % under, 20.9 % absolute; about 2,900 draws leave 1 % and 0.3 %, and
        // the slope over size is ours.
        assert!((under - 0.63).abs() < 0.05, "{under}");
        assert!((absolute - 0.209).abs() < 0.02, "{absolute}");
    }

    #[test]
    fn nights_are_as_long_and_as_sound_as_the_habits_say() {
        for (habits, life) in lives() {
            let hours = mean(life.nights.iter().map(Night::hours));
            assert!((5.5..=9.0).contains(&hours), "{hours}");
            let within: Vec<f64> = life
                .nights
                .iter()
                .flat_map(|n| n.onset.max(0)..n.wake)
                .filter_map(|s| life.asleep.get(usize::try_from(s).ok()?).copied())
                .collect();
            let efficiency = mean(within.iter().map(|e| f64::from(*e == 1.0)));
            // About 8,000 steps with a correlation over two: four standard errors are 0.02.
            assert!((efficiency - habits.sleep_efficiency).abs() < 0.025, "{efficiency}");
            let short = life.nights.iter().filter(|n| n.hours_short > 1.9).count();
            assert!((1..=30).contains(&short), "{short}"); // 8 to 16 % of 85, and alcohol
        }
    }

    #[test]
    fn heart_rate_and_steps_follow_sleep_and_exercise() {
        for (habits, life) in lives() {
            let rate = |pick: &dyn Fn(usize) -> bool| {
                mean(
                    (0..life.calendar.steps())
                        .filter(|s| pick(*s))
                        .filter_map(|s| life.wearable.heart_rate[s]),
                )
            };
            let asleep = rate(&|s| life.is_asleep(s));
            let awake = rate(&|s| !life.is_asleep(s) && life.session_at(s).is_none());
            let late_in_session = rate(&|s| life.session_at(s).is_some_and(|x| s >= x.start + 3));
            assert!(awake > asleep + 8.0, "{awake} {asleep}");
            assert!(late_in_session > awake + 25.0, "{late_in_session} {awake}");
            assert!(late_in_session < habits.maximal_heart_rate);
            let daily =
                life.wearable.steps.iter().flatten().sum::<f64>() / life.calendar.days() as f64;
            assert!((2_500.0..20_000.0).contains(&daily), "{daily}");
            let worn = mean(life.wearable.heart_rate.iter().map(|r| f64::from(r.is_some())));
            assert!((0.85..1.0).contains(&worn), "{worn}");
        }
    }

    #[test]
    fn a_life_is_the_same_for_the_same_seed() {
        let (habits, life) = lives().swap_remove(4);
        assert_eq!(Life::sample(&habits, life.calendar, 3, 4), life);
        assert_ne!(Life::sample(&habits, life.calendar, 4, 4).meals, life.meals);
    }
}
