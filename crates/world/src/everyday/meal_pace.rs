//! How meals differ from each other in speed and course.

use physiology::{Grams, STEPS_PER_HOUR};
use rand::{Rng, RngExt};

use super::course::EverydayLogs;
use crate::behaviour::Life;
use crate::stream::standard_normal;

/// Hours for which a meal determines the gut, if no other follows.
const HOURS: f64 = 6.0;
/// Smaller ones are eaten on top of the meal before.
const LEAST: Grams = Grams(15.0);
/// Slowing while a meal stalls between its phases (log).
const STALL: f64 = 1.2;

/// How the meals of one person differ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MealPace {
    /// Logarithm of the factor on the gut's time at all meals of the person.
    pub level: f64,
    /// Spread of the logarithm of a meal's time of absorption within its kind.
    pub spread: f64,
    /// Share of meals that come in two phases: the gut stalls for an hour after the first.
    pub two_phase_share: f64,
}

impl MealPace {
    /// All alike.
    pub const NONE: Self = Self { level: 0.0, spread: 0.0, two_phase_share: 0.0 };

    /// Draws them. The person's gut is 0.5 to 2.2 times as slow as the body's (log SD 0.35:
    /// half-times of gastric emptying differ about twofold between people, and with diabetes it is
    /// often delayed; Bharucha et al., Endocr Rev 2019;40:1318). Speeds differ by 10 to 45 % by
    /// world, a person's within a fifth of it (times to the peak of appearance differ by about a
    /// third within a person: fat, fibre and what is drunk with it; Lodefalk et al., Diabetes Care
    /// 2008;31:1899; Gingras et al., Diabetes Obes Metab 2018;20:245). Two phases occur in 0 to 40
    /// % of meals of half of the worlds (biphasic appearance of mixed meals, Elleri et al.,
    /// Diabetologia 2013;56:1909; the share is assumed).
    #[must_use]
    pub(super) fn sample(world: &mut impl Rng, own: &mut impl Rng) -> Self {
        let (spread, some) = (world.random_range(0.10..0.45), world.random_bool(0.5));
        let share = own.random_range(0.0..0.4);
        let factor = (0.2 * standard_normal(own)).clamp(-0.4, 0.4).exp();
        let level = (0.1 + 0.35 * standard_normal(own)).clamp(-0.7, 0.8);
        Self { level, spread: spread * factor, two_phase_share: if some { share } else { 0.0 } }
    }

    /// Adds the logarithms of the factors on the gut's time for the meals of a life.
    pub(super) fn add(&self, course: &mut [EverydayLogs], life: &Life, rng: &mut impl Rng) {
        course.iter_mut().for_each(|logs| logs.gut_time += self.level);
        let mut until = 0;
        for (k, meal) in life.meals.iter().enumerate() {
            let pace = self.spread * standard_normal(rng).clamp(-2.5, 2.5);
            let (draw, begins) = (rng.random::<f64>(), rng.random_range(25.0..60.0));
            let lasts: f64 = rng.random_range(30.0..75.0);
            if meal.eaten < LEAST && meal.step < until {
                continue;
            }
            let next = life.meals[k + 1..].iter().find(|later| later.eaten >= LEAST);
            let end = meal.step + (HOURS * STEPS_PER_HOUR as f64) as usize;
            until = next.map_or(end, |later| later.step.min(end)).min(course.len());
            let stalls = draw < self.two_phase_share;
            for (later, logs) in course.iter_mut().take(until).skip(meal.step).enumerate() {
                let minutes = 5.0 * later as f64;
                let stalled = stalls && (begins..begins + lasts).contains(&minutes);
                logs.gut_time += pace + if stalled { STALL } else { 0.0 };
            }
        }
    }
}
