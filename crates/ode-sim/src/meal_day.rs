//! Daily meals drawn from a stated distribution, in place of the T1DEXI-pilot logs, which are not
//! public.
//!
//! What is known of those logs (paper, section on the development dataset): days between the 5th
//! and 95th percentile of the number of meals (1 to 9) and of total carbohydrate (30 to 359 g) were
//! kept. The rest is an assumption of this workspace, stated here in full:
//! - the number of meals is a log-normal variable, rounded, and total carbohydrate a log-normal
//!   variable, each with exactly those percentiles before days outside are dropped; their
//!   logarithms correlate with [`CORRELATION`];
//! - breakfast, lunch and dinner lie around 07:30, 12:30 and 18:30 (SD 60, 60 and 75 min), further
//!   meals are snacks, uniform from 07:00 to 23:00; days with fewer than three meals have a random
//!   choice of the three;
//! - a main meal weighs four times a snack in the share of the day's carbohydrate on average, each
//!   share with a coefficient of variation of one half (gamma).

use physiology::{Grams, STEP, STEPS_PER_DAY};
use rand::seq::index;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, Gamma, StandardNormal};

/// Number of meals a day that are kept: the 5th and 95th percentile (paper).
pub const MEALS_PER_DAY: (usize, usize) = (1, 9);
/// Total carbohydrate of days that are kept, g: the 5th and 95th percentile (paper).
pub const CARBS_PER_DAY: (f64, f64) = (30.0, 359.0);
/// Correlation of log number and log carbohydrate (assumed).
pub const CORRELATION: f64 = 0.5;

/// The 95th percentile of the standard normal distribution.
const Z_95: f64 = 1.644_853_626_951_472_6;
/// Mean minute of the day and SD, min, of breakfast, lunch and dinner (assumed).
const MAIN_MEALS: [(f64, f64); 3] = [(450.0, 60.0), (750.0, 60.0), (1110.0, 75.0)];
/// First and last minute of the day for snacks (assumed).
const SNACK_HOURS: (f64, f64) = (420.0, 1380.0);
/// Mean weight of a main meal in the shares of a day; that of a snack is 1 (assumed).
const MAIN_MEAL_WEIGHT: f64 = 4.0;
/// Shape of the gamma distribution of the weights: coefficient of variation 1/sqrt(4) (assumed).
const WEIGHT_SHAPE: f64 = 4.0;

/// A meal within a day.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DayMeal {
    /// Step of the day, 0 at midnight.
    pub step: usize,
    /// Its carbohydrate.
    pub carbs: Grams,
}

/// The meals of one day, by step; no two share one.
#[derive(Debug, Clone, PartialEq)]
pub struct MealDay {
    meals: Vec<DayMeal>,
}

impl MealDay {
    /// Draws a day by the distribution of this module.
    pub fn draw(rng: &mut impl Rng) -> Self {
        let (number, total) = loop {
            let (number, total) = number_and_total(rng);
            let (few, many) = MEALS_PER_DAY;
            let (little, much) = CARBS_PER_DAY;
            if (few..=many).contains(&number) && (little..=much).contains(&total) {
                break (number, total);
            }
        };
        let gamma =
            Gamma::new(WEIGHT_SHAPE, 1.0 / WEIGHT_SHAPE).expect("both constants are positive");
        let mut slots = Vec::with_capacity(number);
        for main in index::sample(rng, MAIN_MEALS.len(), number.min(MAIN_MEALS.len())) {
            let (mean, sd) = MAIN_MEALS[main];
            let z: f64 = StandardNormal.sample(rng);
            let weight = MAIN_MEAL_WEIGHT * gamma.sample(rng);
            slots.push((free_step(&slots, mean + sd * z), weight));
        }
        while slots.len() < number {
            let minute = rng.random_range(SNACK_HOURS.0..SNACK_HOURS.1);
            let weight = gamma.sample(rng);
            slots.push((free_step(&slots, minute), weight));
        }
        slots.sort_by_key(|(step, _)| *step);
        let sum: f64 = slots.iter().map(|(_, weight)| weight).sum();
        let meals = slots
            .into_iter()
            .map(|(step, weight)| DayMeal { step, carbs: Grams(total * weight / sum) })
            .collect();
        Self { meals }
    }

    /// The meals, earliest first.
    #[must_use]
    pub fn meals(&self) -> &[DayMeal] {
        &self.meals
    }
}

/// A pair before days outside the percentiles are dropped: meals, and carbohydrate in g.
fn number_and_total(rng: &mut impl Rng) -> (usize, f64) {
    let z: f64 = StandardNormal.sample(rng);
    let own: f64 = StandardNormal.sample(rng);
    let correlated = CORRELATION * z + (1.0 - CORRELATION * CORRELATION).sqrt() * own;
    let between = |(low, high): (f64, f64), z: f64| {
        let (low, high) = (low.ln(), high.ln());
        (0.5 * (low + high) + 0.5 * (high - low) / Z_95 * z).exp()
    };
    let number = between((MEALS_PER_DAY.0 as f64, MEALS_PER_DAY.1 as f64), z).round();
    (number as usize, between(CARBS_PER_DAY, correlated))
}

/// The free step nearest to a minute of the day, later ones first.
fn free_step(taken: &[(usize, f64)], minute: f64) -> usize {
    let wanted = (minute / STEP.0).round().clamp(0.0, (STEPS_PER_DAY - 1) as f64) as usize;
    let is_free = |step: &usize| taken.iter().all(|(other, _)| other != step);
    (wanted..STEPS_PER_DAY)
        .chain((0..wanted).rev())
        .find(is_free)
        .expect("nine meals leave steps of the day free")
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha12Rng;

    fn share(count: usize, of: usize) -> f64 {
        count as f64 / of as f64
    }

    #[test]
    fn before_dropping_the_papers_bounds_are_the_5th_and_95th_percentiles() {
        let mut rng = ChaCha12Rng::seed_from_u64(1);
        let n = 40_000;
        let draws: Vec<_> = (0..n).map(|_| number_and_total(&mut rng)).collect();
        let below = share(draws.iter().filter(|d| d.1 < 30.0).count(), n);
        let above = share(draws.iter().filter(|d| d.1 > 359.0).count(), n);
        // Four standard errors of a share of 5 % in 40,000 draws.
        let tolerance = 4.0 * (0.05_f64 * 0.95 / n as f64).sqrt();
        assert!((below - 0.05).abs() < tolerance && (above - 0.05).abs() < tolerance);
        // Numbers are whole: 1 and 9 are percentiles if they hold the 5 % and 95 % points.
        let at_most = |k| share(draws.iter().filter(|d| d.0 <= k).count(), n);
        assert!(at_most(0) < 0.05 && at_most(1) > 0.05);
        assert!(at_most(8) < 0.95 && at_most(9) > 0.95);
    }

    #[test]
    fn days_stay_within_the_papers_bounds_and_no_two_meals_share_a_step() {
        let mut rng = ChaCha12Rng::seed_from_u64(2);
        let mut numbers = [0_usize; 10];
        for _ in 0..5000 {
            let day = MealDay::draw(&mut rng);
            numbers[day.meals().len()] += 1;
            let total: f64 = day.meals().iter().map(|meal| meal.carbs.0).sum();
            // 1e-9: rounding of the shares.
            assert!((30.0 - 1e-9..=359.0 + 1e-9).contains(&total));
            assert!(day.meals().windows(2).all(|pair| pair[0].step < pair[1].step));
            assert!(day.meals().iter().all(|m| m.step < STEPS_PER_DAY && m.carbs.0 > 0.0));
        }
        assert!(numbers[1..=9].iter().all(|count| *count > 0), "every number occurs: {numbers:?}");
    }

    #[test]
    fn main_meals_are_larger_than_snacks() {
        let mut rng = ChaCha12Rng::seed_from_u64(3);
        let days: Vec<_> = (0..4000).map(|_| MealDay::draw(&mut rng)).collect();
        let mean = |steps: std::ops::Range<usize>| {
            let sizes: Vec<f64> = days
                .iter()
                .filter(|d| d.meals().len() > 3)
                .flat_map(|d| d.meals())
                .filter(|m| steps.contains(&m.step))
                .map(|m| m.carbs.0)
                .collect();
            sizes.iter().sum::<f64>() / sizes.len() as f64
        };
        // Around dinner against late evening, where only snacks lie.
        assert!(mean(210..235) > 2.0 * mean(262..276));
    }
}
