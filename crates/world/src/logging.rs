//! How much of the carbohydrate a person logs, and how they count it.

use physiology::{Grams, STEPS_PER_DAY, STEPS_PER_HOUR};

use crate::background::Background;
use crate::behaviour::{Meal, MealKind};
use crate::effects::{Amplitudes, Effect, Forms, MissedForm, Shapes, UnloggedForm};
use crate::everyday::LogHabit;
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
    forms: Forms,
    miscount: f64,
    missed: f64,
    unlogged: f64,
    habit: LogHabit,
}

impl Logging {
    /// The log of a person with these amplitudes of effects.
    pub(crate) fn new(
        background: Background,
        habit: LogHabit,
        shapes: &Shapes,
        amplitudes: &Amplitudes,
    ) -> Self {
        Self {
            habit,
            background,
            own_bias: shapes.counting_bias,
            forms: shapes.forms,
            miscount: amplitudes.of(Effect::CarbMiscount),
            missed: amplitudes.of(Effect::MissedMeals) * MISSED_SHARE,
            unlogged: amplitudes.of(Effect::UnloggedRescueCarbs) * UNLOGGED_SHARE,
        }
    }

    /// What is logged of a meal, in whole units of the habit; `None` if it is neither logged nor
    /// covered.
    pub(crate) fn of_meal(&self, meal: &Meal) -> Option<Grams> {
        let hour = (meal.step % STEPS_PER_DAY) / STEPS_PER_HOUR;
        let weight = match self.forms.missed {
            MissedForm::Any => 1.0,
            MissedForm::Snacks if meal.kind == MealKind::Snack => 2.2,
            MissedForm::Evenings if hour >= 17 => 1.8,
            MissedForm::Small if meal.eaten.0 < 35.0 => 2.2,
            MissedForm::Snacks | MissedForm::Evenings | MissedForm::Small => 0.4,
        };
        (meal.logging_draw >= self.missed * weight).then(|| self.counted(meal))
    }

    /// Carbohydrate of a meal as the person counts it, in whole units of the habit.
    pub(crate) fn counted(&self, meal: &Meal) -> Grams {
        let error = self.error(meal);
        self.habit.rounded(meal.eaten.0 * error.exp())
    }

    /// What must have been eaten so that `other` counts it as `self` counts `meal`, except for
    /// rounding.
    pub(crate) fn behind_the_same_count(&self, other: &Self, meal: &Meal) -> Grams {
        Grams(meal.eaten.0 * (self.error(meal) - other.error(meal)).exp())
    }

    /// Logarithm of counted over eaten.
    fn error(&self, meal: &Meal) -> f64 {
        let form = self.forms.miscount;
        self.background.log_counting_error(meal, form, self.own_bias, self.miscount)
    }

    /// Whether carbohydrate against a low, eaten in a step with this reaction, is not logged.
    pub(crate) fn omits_rescue(&self, step: usize, reaction: &Reaction) -> bool {
        let hour = (step % STEPS_PER_DAY) / STEPS_PER_HOUR;
        let weight = match self.forms.unlogged {
            UnloggedForm::Any => 1.0,
            UnloggedForm::Nights if !(7..22).contains(&hour) => 1.8,
            UnloggedForm::Daytime if (9..18).contains(&hour) => 1.8,
            UnloggedForm::Nights | UnloggedForm::Daytime => 0.4,
        };
        reaction.treat_log < self.unlogged * weight
    }
}
