//! `insulin_incomplete`: insulin that must have been given and is not on record.
//!
//! What such a record lacks, a diagnosis would call an effect. Two things cannot be:
//! - nobody with type 1 diabetes is without insulin for hours every day. Without it production of glucose exceeds
//!   what is taken up at any glucose by EGP0 - F01 = 0.0064 mmol/kg/min (Hovorka et al. 2004), 43 mg/dL an hour
//!   in 0.16 L/kg. A pump or a loop gives some at least every few hours, as a basal rate or in small boluses;
//! - nobody logs meals for days while no insulin answers them, neither boluses nor a controller's basal rate.

use cohort::{Channel, Person, Therapy};
use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

use super::{Consequence, Finding};

/// Least carbohydrate of a meal that needs insulin, g.
const MEAL: f64 = 15.0;
/// Meals a day from which a log is one of meals.
const MEALS_A_DAY: f64 = 1.0;
/// Fewest days that are judged.
const FEWEST_DAYS: f64 = 4.0;
/// Hours after a dose in which it acts: two depots of 55 min (Hovorka et al. 2004) have passed on 95 % of it
/// after 4.4 h, and plasma holds it for minutes.
const ACTS_FOR: usize = 5 * STEPS_PER_HOUR;
/// Hours a day without any insulin, on average over the record, that nobody has: in one hour glucose rises by
/// 43 mg/dL.
const UNCOVERED_HOURS: f64 = 1.0;
/// Time after a meal, and before it, in which insulin may answer it, steps: 4 h and 15 min.
const ANSWERED_WITHIN: usize = 4 * STEPS_PER_HOUR;
const ANSWERED_BEFORE: usize = 3;
/// Carbohydrate for a day's insulin, g: the rule of 500 of Walsh & Roberts, "Pumping Insulin".
const RULE_OF_500: f64 = 500.0;
/// Least share of the rule's insulin: two standard deviations below it, where people's ratios differ by a
/// coefficient of variation of 0.5. Reference people with boluses have 0.25 to 1.5, without them -0.4 to 0.14.
const LEAST_ANSWER: f64 = 0.39;

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
    let text = if !basal
        && person.therapy != Therapy::Mdi
        && uncovered_hours(person) > UNCOVERED_HOURS
    {
        "no basal insulin on record, and for hours a day no insulin at all, in which nobody can hold glucose; \
         give basal_u_h, or mdi as the therapy of injections"
    } else if !bolus && meals >= MEALS_A_DAY * days && answer(person) < LEAST_ANSWER {
        "meals are logged and not one bolus, and the basal rate does not answer them; give bolus_u"
    } else {
        return None;
    };
    Some(Finding::new("insulin_incomplete", person, Consequence::ExcludePerson, text.to_owned()))
}

/// Insulin of a step, U; what is not on record counts as none.
fn insulin(person: &Person, step: usize) -> f64 {
    let record = &person.record;
    let basal = record.basal()[step].unwrap_or(0.0) / STEPS_PER_HOUR as f64;
    basal + record.bolus()[step].unwrap_or(0.0)
}

/// Hours a day in which no dose acts, over the time that is on record: where no channel of insulin has an entry, nobody
/// knows.
fn uncovered_hours(person: &Person) -> f64 {
    let (basal, bolus) = (person.record.basal(), person.record.bolus());
    let (mut since, mut uncovered, mut known) = (0, 0, 0);
    for step in 0..person.record.len() {
        if basal[step].is_none() && bolus[step].is_none() {
            since = 0;
            continue;
        }
        known += 1;
        since = if insulin(person, step) > 0.0 { 0 } else { since + 1 };
        uncovered += usize::from(since > ACTS_FOR);
    }
    24.0 * uncovered as f64 / f64::from(known.max(1))
}

/// Insulin around meals beyond that of other hours, over what the rule of 500 has for their carbohydrate.
fn answer(person: &Person) -> f64 {
    let record = &person.record;
    let steps = record.len();
    let mut around = vec![false; steps];
    let mut carbs = 0.0;
    for (step, grams) in record.carbs().iter().enumerate() {
        let grams = grams.unwrap_or(0.0);
        carbs += grams;
        if grams >= MEAL {
            around[step.saturating_sub(ANSWERED_BEFORE)..(step + ANSWERED_WITHIN).min(steps)]
                .fill(true);
        }
    }
    let (mut at_meals, mut elsewhere) = ((0.0, 0.0), (0.0, 0.0));
    for (step, around) in around.iter().enumerate() {
        let (sum, count) = if *around { &mut at_meals } else { &mut elsewhere };
        *sum += insulin(person, step);
        *count += 1.0;
    }
    let daily = (at_meals.0 + elsewhere.0) * STEPS_PER_DAY as f64 / steps as f64;
    let beyond = at_meals.0 - elsewhere.0 / f64::max(elsewhere.1, 1.0) * at_meals.1;
    beyond / (carbs * daily / RULE_OF_500)
}
