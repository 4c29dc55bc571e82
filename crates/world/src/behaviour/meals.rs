//! Meals: when, how much, how the carbohydrate is counted and when the bolus is given.

use physiology::Grams;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, Gamma, LogNormal, Poisson};

use super::habits::Habits;
use super::hours::Hours;
use super::sleep::Night;
use crate::calendar::Calendar;
use crate::stream::standard_normal;

/// Which meal of the day.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MealKind {
    /// Breakfast.
    Breakfast,
    /// Lunch.
    Lunch,
    /// Dinner.
    Dinner,
    /// Anything between.
    Snack,
}

/// When the bolus of a meal is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BolusTiming {
    /// With the first bite.
    Prompt,
    /// This many steps after it.
    Late(usize),
    /// Not at all.
    Missed,
}

/// Carbohydrate eaten at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meal {
    /// Step at whose start it is eaten.
    pub step: usize,
    /// Which meal.
    pub kind: MealKind,
    /// What is truly eaten.
    pub eaten: Grams,
    /// Logarithm of counted over eaten with the bias and spread of one study. An amplitude scales
    /// it in a [background](crate::Background::AllInEffect) that has no other error.
    pub log_counting_error: f64,
    /// Standard normal draws, cut at two standard deviations: of the counting error that is always
    /// there, and of the spread that an effect adds.
    pub counting_draw: f64,
    /// See [`Self::counting_draw`].
    pub second_counting_draw: f64,
    /// Uniform draw from 0 to 1 that decides, with an amplitude, whether the meal is logged.
    pub logging_draw: f64,
    /// When its bolus is given.
    pub bolus: BolusTiming,
    /// How slow the meal is, 0 for an ordinary one to 1 for a rich dinner (fat, protein).
    pub richness: f64,
}

impl Meal {
    /// A further uniform draw from 0 to 1: the digits of [`Self::logging_draw`] from the fourth on
    /// are independent of the first three.
    #[must_use]
    pub fn spare_draw(&self) -> f64 {
        (1000.0 * self.logging_draw).fract()
    }
}

/// Draws the meals of all days, ordered by step, at most one a step.
///
/// The families of the sizes are those that Camerlingo et al. fitted to 4,874 days of 32 people (J
/// Diabetes Sci Technol 2021;15:346: gamma for breakfast and snacks, log-normal for lunch, a
/// heavy-tailed family for dinner). Medians near 45, 62, 73 and 16 g and coefficients of variation
/// near a third are chosen so that days hold 100 to 300 g. Times: breakfast 0.7 h (SD 0.3) after
/// waking, lunch 12:40, dinner 18:50 (SD 0.5 h; an hour later at weekends), snacks uniform from 2 h
/// after waking to 22:00. One breakfast in twelve and one lunch in thirty are skipped.
///
/// Counting error: log ratio N(-0.085, 0.26), falling by 0.08 per doubling of the meal. So 63 % are
/// underestimated and the mean absolute error is about 21 % (Brazeau et al., Diabetes Res Clin
/// Pract 2013;99:19), and larger for larger meals (Roversi et al., Diabetes Technol Ther
/// 2020;22:749). Bolus: late ones 10 to 45 min (paper, section on scenarios), missed ones by habit.
/// A snack's bolus is missed three times as often as a main meal's.
#[must_use]
pub(super) fn meals(
    habits: &Habits,
    hours: &Hours,
    calendar: &Calendar,
    nights: &[Night],
    rng: &mut (impl Rng + ?Sized),
) -> Vec<Meal> {
    let (shifted, irregular) = (hours.later(calendar), hours.irregularity);
    let snacks = Poisson::new(habits.snacks_per_day).expect("a positive rate");
    let mut meals: Vec<Meal> = Vec::with_capacity(5 * calendar.days());
    for (day, moved) in shifted.iter().copied().enumerate().take(calendar.days()) {
        let later = if calendar.is_weekend(day) { 1.0 } else { 0.0 };
        let wake = nights.get(day).map_or(habits.wake_hour, |n| {
            (n.wake - calendar.signed_step(day, 0.0)) as f64 / physiology::STEPS_PER_HOUR as f64
        });
        let mut times = vec![
            (MealKind::Breakfast, wake + (0.7 + irregular * 0.3 * standard_normal(rng)).max(0.1)),
            (MealKind::Lunch, 12.7 + moved + 0.6 * later + irregular * 0.5 * standard_normal(rng)),
            (MealKind::Dinner, 18.8 + moved + later + irregular * 0.5 * standard_normal(rng)),
        ];
        let count = Distribution::<f64>::sample(&snacks, rng) as usize;
        for _ in 0..count {
            let last = (22.0 + moved).max(wake + 4.0);
            times.push((MealKind::Snack, rng.random_range(wake + 2.0..last)));
        }
        for (kind, hour) in times {
            let skipped = rng.random::<f64>() < kind.skip_probability(hours.meals_left_out);
            let meal = draw_meal(habits, kind, later, rng);
            let free = |step: &usize| meals.iter().all(|m| m.step.abs_diff(*step) > 1);
            if let Some(step) = calendar.step_at(day, hour).filter(free)
                && !skipped
            {
                meals.push(Meal { step, ..meal });
            }
        }
    }
    meals.sort_by_key(|m| m.step);
    meals
}

/// Draws the second counting errors from a separate stream.
pub(super) fn count_again(meals: &mut [Meal], rng: &mut (impl Rng + ?Sized)) {
    for meal in meals {
        meal.second_counting_draw = standard_normal(rng).clamp(-2.0, 2.0);
    }
}

impl MealKind {
    /// Probability that a person leaves out the meal, given their share of breakfasts and lunches
    /// left out.
    fn skip_probability(self, left_out: f64) -> f64 {
        match self {
            Self::Breakfast => left_out.max(1.0 / 12.0),
            Self::Lunch => left_out.max(1.0 / 30.0),
            Self::Dinner => 0.25 * left_out,
            Self::Snack => 0.0,
        }
    }
}

/// Everything about a meal except its step; every draw is made whatever the outcome.
fn draw_meal(habits: &Habits, kind: MealKind, weekend: f64, rng: &mut (impl Rng + ?Sized)) -> Meal {
    let gamma =
        |shape: f64, scale: f64| Gamma::new(shape, scale).expect("positive shape and scale");
    let about = |median: f64, sd| LogNormal::new(median.ln(), sd).expect("a positive spread");
    let size = match kind {
        MealKind::Breakfast => gamma(9.0, 5.2).sample(rng), // mean 47 g
        MealKind::Lunch => about(62.0, 0.30).sample(rng),
        MealKind::Dinner => about(73.0, 0.35).sample(rng) * (1.0 + 0.12 * weekend),
        MealKind::Snack => gamma(4.0, 4.5).sample(rng), // mean 18 g
    };
    let eaten = (size * habits.appetite).clamp(5.0, 130.0);
    let (timing, lateness) = (rng.random::<f64>(), rng.random_range(2..=9_usize));
    let missed = match kind {
        MealKind::Snack => (3.0 * habits.missed_bolus_probability).min(0.3),
        _ => habits.missed_bolus_probability,
    };
    let bolus = if timing < missed {
        BolusTiming::Missed
    } else if timing < missed + habits.late_bolus_probability {
        BolusTiming::Late(lateness)
    } else {
        BolusTiming::Prompt
    };
    let (rich_draw, rich_size) = (rng.random::<f64>(), rng.random_range(0.5..1.0));
    let rich_probability = match kind {
        MealKind::Dinner => 0.5,
        MealKind::Lunch => 0.15,
        MealKind::Breakfast | MealKind::Snack => 0.0,
    };
    let counting_draw = standard_normal(rng).clamp(-2.0, 2.0);
    Meal {
        step: 0,
        kind,
        eaten: Grams(eaten),
        log_counting_error: -0.085 - 0.08 * (eaten / 62.0).log2() + 0.26 * counting_draw,
        counting_draw,
        second_counting_draw: 0.0,
        logging_draw: rng.random(),
        bolus,
        richness: if rich_draw < rich_probability { rich_size } else { 0.0 },
    }
}
