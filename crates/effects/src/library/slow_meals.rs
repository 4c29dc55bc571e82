//! Slow meals: fat and protein delay absorption and blunt insulin for hours.

use crate::card::{Card, Channel, Prior};
use crate::course::Course;
use crate::effect::{Effect, Form};
use crate::meals;
use crate::modulation::{Field, Modulation};
use crate::port::Port;

/// Time of absorption at amplitude 1, as a factor.
const SLOWER: f64 = 1.4;
/// Insulin action at amplitude 1, as a factor.
const ACTION: f64 = 0.83;
/// How long absorption is slow, min.
const ABSORBING: f64 = 360.0;
/// When insulin action begins to fall and has fallen, min after the meal.
const BLUNTED: (f64, f64) = (30.0, 90.0);
/// When it begins to rise again and is back, min after the meal.
const RECOVERS: (f64, f64) = (300.0, 420.0);
/// Least grams of a meal that ends the slow one before it.
const ANOTHER_MEAL: f64 = 20.0;

/// Which meals are slow.
#[derive(Debug, Clone, Copy)]
struct Kind {
    /// Hours between which.
    hours: (f64, f64),
    /// Least carbohydrate, g.
    grams: f64,
    /// Whether insulin action falls too.
    blunts: bool,
}

/// What is tried, in the order of the variants: dinners, large meals, whatever is eaten in the evening, and
/// dinners that are slow only.
const KINDS: [Kind; 4] = [
    Kind { hours: (17.0, 22.0), grams: 25.0, blunts: true },
    Kind { hours: (0.0, 24.0), grams: 50.0, blunts: true },
    Kind { hours: (17.0, 24.0), grams: 1.0, blunts: true },
    Kind { hours: (17.0, 22.0), grams: 25.0, blunts: false },
];

/// See the module.
#[derive(Debug, Clone, Copy)]
pub(super) struct SlowMeals;

impl Effect for SlowMeals {
    fn card(&self) -> Card {
        Card {
            name: "slow_meals",
            port: Port::GutAbsorption,
            summary: "meals rich in fat and protein, dinners above all, are absorbed slowly and blunt insulin",
            size_at_one: "time of absorption 1.4 times as long for 6 h, insulin action 17 % lower from 1.5 to 5 h",
            source: "Wolpert et al., Diabetes Care 2013;36:810; Bell et al., Diabetes Care 2015;38:1008; Smart et al., \
                     Diabetes Care 2013;36:3897",
            signature: "glucose over-predicted in the first hour or two after dinner, under-predicted from three \
                        hours into the night",
            channels: &[Channel::Carbs],
            confusable_with: &["carb_miscount", "circadian_sensitivity", "missed_meals"],
            prior: Prior { median: 1.0, log_sd: 0.5, largest: 4.0 },
        }
    }

    fn form(&self, course: &Course) -> Option<Form> {
        meals::any(course).then_some(Form::Driven)
    }

    fn variants(&self) -> usize {
        KINDS.len()
    }

    fn modulate(&self, variant: usize, amplitude: f64, course: &Course, into: &mut [Modulation]) {
        let kind = KINDS[variant % KINDS.len()];
        let grams = meals::so_far(course);
        let mut since: Option<f64> = None;
        for ((hour, grams), modulation) in course.hour.iter().zip(&grams).zip(into) {
            since = since.map(|minutes| minutes + crate::course::STEP_MINUTES);
            let slow = (kind.hours.0..kind.hours.1).contains(hour) && *grams >= kind.grams;
            if slow {
                since = Some(0.0);
            } else if *grams >= ANOTHER_MEAL && since.is_some_and(|minutes| minutes > 30.0) {
                since = None;
            }
            let Some(minutes) = since else { continue };
            if minutes < ABSORBING {
                modulation[Field::GutTime] *= (amplitude * SLOWER.ln()).exp();
            }
            if kind.blunts {
                modulation[Field::Action] *= (amplitude * ACTION.ln() * blunted(minutes)).exp();
            }
        }
    }
}

/// How far insulin is blunted so many minutes after the meal, 0 to 1.
fn blunted(minutes: f64) -> f64 {
    let rise = (minutes - BLUNTED.0) / (BLUNTED.1 - BLUNTED.0);
    let fall = (RECOVERS.1 - minutes) / (RECOVERS.1 - RECOVERS.0);
    rise.min(fall).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{DAY, fortnight, modulated};

    #[test]
    fn dinner_is_slow_and_breakfast_is_not() {
        let course = fortnight();
        assert_eq!(SlowMeals.variants(), KINDS.len());
        for (variant, kind) in KINDS.iter().enumerate() {
            let steps = modulated(&SlowMeals, variant, 1.0, &course);
            let (dinner, breakfast) = (19 * 12, 90);
            assert!(
                (steps[dinner + 24][Field::GutTime] - SLOWER).abs() < 1e-12,
                "variant {variant}"
            );
            assert!(steps[breakfast + 24].is_neutral(), "variant {variant}");
            assert!(steps[dinner - 1].is_neutral());
            // Seven hours on, nothing is left.
            assert!(steps[dinner + 84].is_neutral());
            let action = steps[dinner + 36][Field::Action];
            assert!(if kind.blunts { (action - ACTION).abs() < 1e-12 } else { action == 1.0 });
        }
    }

    #[test]
    fn a_meal_that_is_not_slow_ends_the_one_before() {
        let mut course = fortnight();
        course.carbs[DAY + 12] = 30.0;
        let steps = modulated(&SlowMeals, 0, 1.0, &course);
        assert!(steps[DAY + 11][Field::GutTime] > 1.0);
        assert!(steps[DAY + 12].is_neutral());
    }

    #[test]
    fn without_logged_carbohydrate_there_is_no_form() {
        let mut course = fortnight();
        course.carbs.fill(0.0);
        assert_eq!(SlowMeals.form(&course), None);
    }
}
