//! Rich meals are absorbed more slowly.

use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

use super::forms::SlowMealsForm;
use crate::behaviour::Meal;

/// Lengthening of the time to the maximal appearance for the richest meal, as a share. Fat and
/// protein delay and flatten the rise (Wolpert et al., Diabetes Care 2013;36:810); 0.4 to 0.6 is of
/// that order.
const LENGTHENING: f64 = 0.5;
/// Hours for which a rich meal determines the gut.
const HOURS: f64 = 6.0;
/// Share of meals that are fatty where any can be; assumed.
const FATTY_SHARE: f64 = 0.3;

/// Factor on the time to the maximal appearance, `hours` after the start of a meal of this
/// slowness; 1 outside the six hours that follow it.
#[must_use]
pub(super) fn gut_time_factor(slowness: f64, hours: f64, amplitude: f64) -> f64 {
    let ruling = (0.0..HOURS).contains(&hours);
    if ruling { 1.0 + amplitude * LENGTHENING * slowness } else { 1.0 }
}

/// How slow a meal is, 0 to 1.
#[must_use]
pub(super) fn slowness(form: SlowMealsForm, meal: &Meal) -> f64 {
    match form {
        SlowMealsForm::RichDinners => meal.richness,
        SlowMealsForm::AnyFatty => {
            let draw = meal.spare_draw();
            if draw < FATTY_SHARE { 0.5 + 0.5 * draw / FATTY_SHARE } else { 0.0 }
        }
        SlowMealsForm::Large => ((meal.eaten.0 - 50.0) / 50.0).clamp(0.0, 1.0),
        SlowMealsForm::Evenings => {
            let hour = (meal.step % STEPS_PER_DAY) / STEPS_PER_HOUR;
            if (17..24).contains(&hour) { 0.6 } else { 0.0 }
        }
    }
}
