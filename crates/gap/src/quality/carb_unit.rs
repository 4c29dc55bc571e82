//! `carb_unit`: carbohydrate in servings (10, 12 or 15 g) or another unit where grams are meant.
//!
//! A gram needs about 1/500 of the daily insulin (the 500 rule of Walsh & Roberts, "Pumping
//! Insulin"). Meals and the boluses within half an hour of them tell what a person needs per entry.
//! In the clean records that were looked at, their ratio is 0.35 to 1.3 times the rule's; servings
//! make it a tenth.

use cohort::Person;
use physiology::STEPS_PER_DAY;

use super::daily_doses::days;
use super::{Consequence, Finding};
use crate::filter::observations::DEFAULT_WEIGHT;
use crate::filter::whitening::median;

/// Grams per unit of insulin, times the daily insulin, U.
const RULE: f64 = 500.0;
/// Median of clean people's ratio to the rule: they give a quarter more than it says.
const TYPICAL: f64 = 0.8;
/// Spread of that between people: a factor that 95 % lie within.
const SPREAD: f64 = 2.5;
/// Ratios to the rule between which grams are believed.
const BELIEVED: (f64, f64) = (0.2, 4.0);
/// Insulin a day, U/kg, outside which the boluses are doubted first.
const INSULIN_U_KG: (f64, f64) = (0.1, 2.0);
/// Largest upper tail of entries that can be servings: 25 of 10 g.
const LARGEST_SERVINGS: f64 = 25.0;
/// Median entry and carbohydrate a day below which entries without any bolus are servings.
const WITHOUT_BOLUS: (f64, f64) = (8.0, 25.0);
/// Steps around a meal in which its bolus lies: half an hour.
const NEAR: usize = 6;
/// Smallest bolus that is paired with a meal, U: less is a controller's.
const SMALLEST_BOLUS: f64 = 0.3;
/// Fewest meals.
const FEWEST: usize = 8;

pub(super) fn finding(person: &Person) -> Option<Finding> {
    let record = &person.record;
    let (carbs, bolus) = (record.carbs(), record.bolus());
    let meals: Vec<(usize, f64)> =
        (0..record.len()).filter_map(|k| carbs[k].filter(|c| *c > 0.0).map(|c| (k, c))).collect();
    if meals.len() < FEWEST {
        return None;
    }
    let mut entries: Vec<f64> = meals.iter().map(|(_, size)| *size).collect();
    entries.sort_by(f64::total_cmp);
    let (middle, tail) = (entries[entries.len() / 2], entries[entries.len() * 95 / 100]);
    let mut ratios: Vec<f64> = meals
        .iter()
        .filter_map(|(k, size)| {
            let near = k.saturating_sub(NEAR)..(k + NEAR + 1).min(record.len());
            let units: f64 = bolus[near].iter().flatten().sum();
            (units >= SMALLEST_BOLUS).then(|| size / units)
        })
        .collect();
    let days = days(person);
    let daily = days.iter().map(|day| day.insulin()).sum::<f64>() / days.len().max(1) as f64;
    if ratios.len() < FEWEST || daily <= 0.0 {
        let a_day = entries.iter().sum::<f64>() * STEPS_PER_DAY as f64 / record.len() as f64;
        let small = middle < WITHOUT_BOLUS.0 && a_day < WITHOUT_BOLUS.1;
        return small.then(|| {
            let text = format!(
                "entries of {middle:.1} in the middle and {a_day:.0} a day, with no boluses to compare: \
                 carbohydrate in servings, or hardly logged; convert it to grams"
            );
            Finding::new("carb_unit", person, Consequence::ExcludePerson, text)
        });
    }
    let weight = person.weight.unwrap_or(DEFAULT_WEIGHT).0;
    if !(INSULIN_U_KG.0..=INSULIN_U_KG.1).contains(&(daily / weight)) {
        return None;
    }
    let rule = RULE / daily;
    let found = median(&mut ratios);
    let ratio = found / rule;
    // Meals may lie beside boluses of another purpose (a clock that is off), and may be logged without
    // boluses or the other way round: the whole record must say the same.
    let units: f64 = bolus.iter().flatten().sum();
    let overall = entries.iter().sum::<f64>() / units / rule;
    let doubted = (ratio < BELIEVED.0 && overall < BELIEVED.0 && tail <= LARGEST_SERVINGS)
        || (ratio > BELIEVED.1 && overall > BELIEVED.1);
    if !doubted {
        return None;
    }
    let grams = TYPICAL / ratio;
    let text = if ratio < 1.0 {
        format!(
            "{found:.2} g per unit of insulin at meals where about {rule:.0} are usual, entries of {middle:.1} \
             in the middle: carbohydrate in servings of about {grams:.0} g (10, 12 and 15 g are in use); \
             convert it to grams"
        )
    } else {
        format!(
            "{found:.0} g per unit of insulin at meals where about {rule:.0} are usual: the unit is smaller \
             than a gram of carbohydrate, by a factor of about {:.0}; convert it to grams",
            1.0 / grams
        )
    };
    let found = Finding::new("carb_unit", person, Consequence::ExcludePerson, text);
    Some(found.with_estimate((grams, grams / SPREAD, grams * SPREAD), "g per recorded gram"))
}
