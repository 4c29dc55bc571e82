//! `insulin_incomplete`: insulin that must have been given and is not on record.
//!
//! Nobody on a pump lives without basal insulin, and nobody logs meals for days without one bolus, unless a
//! controller gives all insulin as basal. What such a record lacks, a diagnosis would call an effect.

use cohort::{Channel, Person, Therapy};
use physiology::STEPS_PER_DAY;

use super::{Consequence, Finding};

/// Least carbohydrate of a meal that needs a bolus, g.
const MEAL: f64 = 15.0;
/// Meals a day from which a log is one of meals.
const MEALS_A_DAY: f64 = 1.0;
/// Fewest days that are judged.
const FEWEST_DAYS: f64 = 4.0;

pub(super) fn finding(person: &Person) -> Option<Finding> {
    let record = &person.record;
    let days = record.len() as f64 / STEPS_PER_DAY as f64;
    let given = |channel| record.channel(channel).iter().flatten().any(|dose| *dose > 0.0);
    let (basal, bolus) = (given(Channel::Basal), given(Channel::Bolus));
    // Without any insulin the person is left out for that.
    if days < FEWEST_DAYS || !(basal || bolus) {
        return None;
    }
    let meals = record.carbs().iter().flatten().filter(|grams| **grams >= MEAL).count() as f64;
    let on_pump = matches!(person.therapy, Therapy::OpenLoopPump | Therapy::Aid);
    let text = if on_pump && !basal {
        "a pump without basal insulin on record; give basal_u_h, or mdi as the therapy of injections"
    } else if !bolus && person.therapy != Therapy::Aid && meals >= MEALS_A_DAY * days {
        "meals are logged and not one bolus; give bolus_u"
    } else {
        return None;
    };
    Some(
        Finding::note("insulin_incomplete", person, text)
            .with_consequence(Consequence::ExcludePerson),
    )
}
