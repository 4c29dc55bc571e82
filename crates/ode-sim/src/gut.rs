//! Carbohydrate on its way from the gut into the blood: the exact solution of Eq. (U_G).
//!
//! The paper's U_G(t) = D A_G t exp(-t/t_max,G) / t_max,G^2 is the outflow of two equal linear
//! compartments, dC1 = A_G D delta - C1/t_max, dC2 = (C1 - C2)/t_max, U_G = C2/t_max. The pair is
//! linear, so it is advanced without error over any time, and any number of meals share one pair.

use physiology::{GRAMS_PER_MMOL_GLUCOSE, Grams, Kilograms, Minutes};

/// Time to the maximal appearance of rescue carbohydrate, min (Resalat et al. 2019, test program).
pub const RESCUE_T_MAX: Minutes = Minutes(20.0);

/// Two equal linear gut compartments in a row, both mmol/kg.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GutPair {
    /// First compartment: what was eaten, mmol/kg.
    pub c1: f64,
    /// Second compartment, which empties into the blood, mmol/kg.
    pub c2: f64,
}

impl GutPair {
    /// The pair after a meal of `amount` mmol/kg (bioavailability already applied).
    #[inline]
    #[must_use]
    pub fn fed(self, amount: f64) -> Self {
        Self { c1: self.c1 + amount, ..self }
    }

    /// The pair `time` min later, exactly; `t_max` in min.
    #[inline]
    #[must_use]
    pub fn after(self, time: f64, t_max: f64) -> Self {
        // An empty gut and the start of a step are common enough to spare the exponential.
        if self.is_empty() || time == 0.0 {
            return self;
        }
        let left = (-time / t_max).exp();
        Self { c1: self.c1 * left, c2: (self.c2 + self.c1 * time / t_max) * left }
    }

    /// Rate of appearance in the blood U_G, mmol/kg/min; `t_max` in min.
    #[inline]
    #[must_use]
    pub fn appearance(self, t_max: f64) -> f64 {
        self.c2 / t_max
    }

    /// Whether nothing is left to absorb.
    #[inline]
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.c1 == 0.0 && self.c2 == 0.0
    }
}

/// The dose D_G of the paper, mmol/kg: glucose equivalent of `carbs` for a body of `weight`.
#[inline]
#[must_use]
pub fn glucose_dose(carbs: Grams, weight: Kilograms) -> f64 {
    carbs.0 / (GRAMS_PER_MMOL_GLUCOSE * weight.0)
}

/// Meal appearance in closed form, Eq. (U_G): mmol/kg/min, `time` min after eating `dose` mmol/kg.
///
/// `a_g` unitless, `t_max_g` in min. Zero before the meal.
#[must_use]
pub fn meal_appearance(dose: f64, a_g: f64, t_max_g: f64, time: f64) -> f64 {
    if time <= 0.0 {
        return 0.0;
    }
    dose * a_g * time * (-time / t_max_g).exp() / (t_max_g * t_max_g)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pair_follows_the_closed_form_for_several_meals() {
        let (t_max, a_g) = (40.0, 0.8);
        let meals = [(0.0, 3.0), (35.0, 1.5), (60.0, 4.0)];
        let mut pair = GutPair::default();
        let mut now = 0.0;
        for step in 0..100 {
            for (time, dose) in meals {
                if time == now {
                    pair = pair.fed(a_g * dose);
                }
            }
            let expected: f64 =
                meals.iter().map(|(t, d)| meal_appearance(*d, a_g, t_max, now - t)).sum();
            // Rounding of 100 successive exact steps.
            assert!((pair.appearance(t_max) - expected).abs() < 1e-15, "step {step}");
            pair = pair.after(5.0, t_max);
            now += 5.0;
        }
    }

    #[test]
    fn steps_compose() {
        let pair = GutPair { c1: 2.0, c2: 0.7 };
        let once = pair.after(13.0, 20.0);
        let twice = pair.after(4.0, 20.0).after(9.0, 20.0);
        // Rounding of three exponentials.
        assert!((once.c1 - twice.c1).abs() < 1e-15 && (once.c2 - twice.c2).abs() < 1e-15);
    }

    #[test]
    fn the_dose_of_a_meal_is_its_glucose_per_body_weight() {
        assert!((glucose_dose(Grams(18.0), Kilograms(50.0)) - 2.0).abs() < 1e-15); // rounding
    }
}
