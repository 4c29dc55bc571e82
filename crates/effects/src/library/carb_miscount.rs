//! Carbohydrate counted too low, the more so the larger the meal.

use super::prelude::*;

/// Exponent of eaten over logged in the logged amount at amplitude 1.
///
/// Meals of 55 to 164 g were counted 28 % too low, the large ones 34 %: logged grows like eaten to the 0.78, so
/// that eaten over logged grows like logged to the 0.28.
const EXPONENT: f64 = 0.28;
/// Logged amount that is taken as right, g.
///
/// A common error of all meals is the same as the person's share of carbohydrate that reaches the blood
/// and belongs to calibration; only its growth with size can be told.
const COUNTED_RIGHT: f64 = 40.0;
/// Exponent of the variant in which only large meals are counted too low (a quadratic term of meal size).
const EXPONENT_OF_LARGE: f64 = 0.5;
/// Logged amount from which a meal is large, g.
const LARGE: f64 = 50.0;
/// Logged amounts beyond which the error does not grow, g.
const LIMITS: (f64, f64) = (10.0, 160.0);

/// See the module.
#[derive(Debug, Clone, Copy)]
pub(super) struct CarbMiscount;

impl Effect for CarbMiscount {
    fn card(&self) -> Card {
        Card {
            id: EffectId::CARB_MISCOUNT,
            port: Port::CarbAmount,
            summary: "carbohydrate is counted too low, the more so the larger the meal",
            size_at_one: "eaten over logged grows like logged to the 0.28 (21 % more for twice the meal); its part \
                          common to all meals belongs to calibration",
            source: "28 % too low, 34 % for large meals: 74 adults and 24 test meals, Exp Clin Endocrinol Diabetes, doi \
                     10.1055/a-1493-2324; small meals over-, large ones underestimated: Kawamura \
                     et al., Clin Pediatr Endocrinol 2015;24:153; Roversi et al., Diabetes Technol Ther 2020;22:749",
            signature: "glucose under-predicted after large meals and over-predicted after small ones",
            channels: &[Channel::Carbs],
            confusable_with: &[EffectId::SLOW_MEALS, EffectId::MISSED_MEALS],
            relations: Relations::USUAL,
            prior: Prior { median: 1.0, log_sd: 0.6, largest: 3.0 },
        }
    }

    fn form(&self, course: &Course) -> Option<Form> {
        meals::any(course).then_some(Form::Driven)
    }

    fn variants(&self) -> usize {
        2
    }

    fn modulate(&self, variant: usize, amplitude: f64, course: &Course, into: &mut [Modulation]) {
        for (grams, modulation) in meals::so_far(course).iter().zip(into) {
            if *grams > 0.0 {
                let exponent = log_error(variant % 2, *grams);
                modulation[Field::CarbAmount] *= (amplitude * exponent).exp();
            }
        }
    }
}

/// Logarithm of eaten over logged at amplitude 1.
fn log_error(variant: usize, grams: f64) -> f64 {
    let grams = grams.clamp(LIMITS.0, LIMITS.1);
    if variant == 0 {
        EXPONENT * (grams / COUNTED_RIGHT).ln()
    } else {
        EXPONENT_OF_LARGE * (grams / LARGE).ln().max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{fortnight, modulated};

    #[test]
    fn more_was_eaten_than_logged_at_large_meals() {
        let course = fortnight();
        for variant in 0..CarbMiscount.variants() {
            let steps = modulated(&CarbMiscount, variant, 1.0, &course);
            assert!(steps[19 * 12][Field::CarbAmount] > 1.1, "dinner of 75 g, variant {variant}");
            assert!(steps[90][Field::CarbAmount] <= 1.0, "breakfast of 35 g, variant {variant}");
            assert!(steps[91].is_neutral());
        }
    }

    #[test]
    fn twice_the_meal_has_the_stated_error() {
        assert!((log_error(0, 80.0).exp() - 2.0_f64.powf(EXPONENT)).abs() < 1e-12);
        assert_eq!(log_error(0, COUNTED_RIGHT), 0.0);
        assert_eq!(log_error(0, 500.0), log_error(0, LIMITS.1));
    }
}
