//! The ways in which every real person differs from a model, whether an effect acts or not.
//!
//! A model does not fit even a world without any effect. Insulin action and the gut differ from day
//! to day ([`Variability`](crate::Variability)), sensors err ([`SensorModel`](ode_sim::SensorModel)
//! and a gain of their own), boluses come late or not at all ([`BolusTiming`](crate::BolusTiming)),
//! rescue carbohydrate is logged like a meal, settings are not quite right, and nobody counts
//! carbohydrate exactly. This module states the last of these.

use crate::behaviour::{Meal, MealKind};
use crate::effects::{MiscountForm, rise};

/// The background of one person: how carbohydrate is counted where no effect acts, and what the
/// effect adds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Background {
    /// The count has a log-normal error without bias and with this coefficient of variation; the
    /// effect adds its bias and its spread.
    Unbiased {
        /// Coefficient of variation of the count.
        cv: f64,
    },
    /// The count is exact; bias and spread are both the effect's, as in
    /// [`Meal::log_counting_error`].
    AllInEffect,
}

/// What an amplitude of 1 of the effect does under [`Background::AllInEffect`].
pub(crate) const SIZE_OF_ERRORS_IN_EFFECT: &str =
    "counted over eaten log-normal: 63 % below 1, mean error 21 %";

/// Bias of the logarithm of a count at amplitude 1: for small meals, and the amount added for large
/// ones. The medians are -28 and -34 % (size of the design of this effect; underestimates of this
/// order are in Roversi et al., Diabetes Technol Ther 2020;22:749, and Kawamura et al., J Diabetes
/// Investig 2015;6:280).
const BIAS: f64 = -0.3285;
const BIAS_OF_LARGE: f64 = -0.087;
/// Size at which a meal becomes large, and the width of the transition, g.
const LARGE: (f64, f64) = (65.0, 8.0);
/// Spread of the logarithm of a count that the effect adds at amplitude 1, for a meal of 60 g. It
/// grows with the root of the size (assumed).
const ADDED_SPREAD: f64 = 0.12;

/// Usual size, towards which counts are pulled in the form that pulls them, g.
const USUAL: f64 = 45.0;

impl Background {
    /// Counts without bias and with a coefficient of variation of 20 %. The mean absolute error of
    /// 20.9 % of Brazeau et al. (Diabetes Res Clin Pract 2013;99:19) includes bias and spread.
    pub const REALISTIC: Self = Self::Unbiased { cv: 0.20 };

    /// Counts whose whole error is the effect's.
    pub const ERRORS_IN_EFFECT: Self = Self::AllInEffect;

    /// Logarithm of counted over eaten for a meal, when the effect acts with `amplitude` on a
    /// person whose bias is `own_bias` times the published one.
    #[must_use]
    pub fn log_counting_error(
        &self,
        meal: &Meal,
        form: MiscountForm,
        own_bias: f64,
        amplitude: f64,
    ) -> f64 {
        match *self {
            Self::Unbiased { cv } => {
                let sd = (1.0 + cv * cv).ln().sqrt();
                let unbiased = sd * meal.counting_draw - 0.5 * sd * sd;
                let large = rise(meal.eaten.0, LARGE);
                let bias = own_bias
                    * match form {
                        MiscountForm::TooLow => BIAS + BIAS_OF_LARGE * large,
                        MiscountForm::LargeOnly => 2.0 * BIAS * large,
                        MiscountForm::Dinners if meal.kind == MealKind::Dinner => 1.6 * BIAS,
                        MiscountForm::Dinners => 0.0,
                        MiscountForm::TowardUsual => {
                            let usual = (meal.eaten.0 / USUAL).ln().clamp(-1.2, 1.2);
                            1.5 * BIAS * usual
                        }
                    };
                let spread = ADDED_SPREAD * (meal.eaten.0 / 60.0).sqrt();
                unbiased + amplitude * (bias + spread * meal.second_counting_draw)
            }
            Self::AllInEffect => amplitude * meal.log_counting_error,
        }
    }
}
