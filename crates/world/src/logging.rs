//! What of the carbohydrate a person logs, and how they count it.

use physiology::Grams;

use crate::background::Background;
use crate::behaviour::Meal;
use crate::effects::{Amplitudes, Effect, Shapes};
use crate::reactions::Reaction;

/// Share of meals that are neither logged nor covered at amplitude 1; about 0.25 a day of 20 to 60
/// g (0.2 to 1 a day of 20 to 25 g is what studies of meal detection assume).
const MISSED_SHARE: f64 = 0.07;
/// Share of rescue carbohydrate that is not logged at amplitude 1; assumed.
const UNLOGGED_SHARE: f64 = 0.5;

/// How one person keeps the log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Logging {
    background: Background,
    own_bias: f64,
    miscount: f64,
    missed: f64,
    unlogged: f64,
}

impl Logging {
    /// The log of a person in whom effects act with these amplitudes.
    pub(crate) fn new(background: Background, shapes: &Shapes, amplitudes: &Amplitudes) -> Self {
        Self {
            background,
            own_bias: shapes.counting_bias,
            miscount: amplitudes.of(Effect::CarbMiscount),
            missed: amplitudes.of(Effect::MissedMeals) * MISSED_SHARE,
            unlogged: amplitudes.of(Effect::UnloggedRescueCarbs) * UNLOGGED_SHARE,
        }
    }

    /// What is logged of a meal, in whole grams; `None` if it is neither logged nor covered.
    pub(crate) fn of_meal(&self, meal: &Meal) -> Option<Grams> {
        (meal.logging_draw >= self.missed).then(|| self.counted(meal))
    }

    /// Carbohydrate of a meal as the person counts it, in whole grams.
    pub(crate) fn counted(&self, meal: &Meal) -> Grams {
        let error = self.background.log_counting_error(meal, self.own_bias, self.miscount);
        Grams((meal.eaten.0 * error.exp()).round().max(1.0))
    }

    /// What must have been eaten for `other` to count it as `self` counts `meal`, but for rounding.
    pub(crate) fn behind_the_same_count(&self, other: &Self, meal: &Meal) -> Grams {
        let error =
            |log: &Self| log.background.log_counting_error(meal, log.own_bias, log.miscount);
        Grams(meal.eaten.0 * (error(self) - error(other)).exp())
    }

    /// Whether carbohydrate against a low, eaten in a step with this reaction, is left out.
    pub(crate) fn omits_rescue(&self, reaction: &Reaction) -> bool {
        reaction.treat_log < self.unlogged
    }
}
