//! `basal_unit`: basal insulin in U per five minutes where U/h is meant, or the other way round,
//! throughout or on some days.
//!
//! The two differ by a factor of twelve, which no way of treating diabetes spans: basal insulin is
//! about half of the day's (0.3 to 0.7 in the records that were looked at; 0.4 to 0.5 is advised
//! for pumps, Walsh & Roberts, "Pumping Insulin"), and the day's is 0.2 to 1.5 U/kg (0.4 to 1.0 is
//! typical, ADA Standards of Care). A unit is doubted where the record as it stands is outside and
//! the record with the other unit is inside.

use std::collections::BTreeMap;

use cohort::{Person, Therapy};
use physiology::STEPS_PER_HOUR;

use super::daily_doses::{DayDoses, days, mean_with_interval};
use super::{Consequence, Finding};
use crate::filter::observations::DEFAULT_WEIGHT;
use crate::filter::whitening::median;

/// U/h over U per five minutes.
const FACTOR: f64 = STEPS_PER_HOUR as f64;
/// Plausible insulin a day, U/kg.
const INSULIN_U_KG: (f64, f64) = (0.2, 1.5);
/// Plausible share of basal insulin in it.
const BASAL_SHARE: (f64, f64) = (0.2, 0.9);
/// Lowest plausible insulin from midnight to six, U/kg/day: a body without any goes into
/// ketoacidosis, and the lowest programmed profiles give about 0.1.
const NIGHT_U_KG: f64 = 0.06;
/// Share of basal insulin that no programmed profile goes below, %.
const LEAST_PROGRAMMED: f64 = 12.0;
/// Fewest days on each side for units that change.
const FEWEST_DAYS: usize = 2;
/// How far apart the days' basal amounts must lie for units that change: around the factor.
const APART: (f64, f64) = (7.0, 20.0);
/// How far days of one unit differ at most: a factor on their median.
const ALIKE: f64 = 2.5;

pub(super) fn finding(person: &Person) -> Option<Finding> {
    let days = days(person);
    let basal: Vec<f64> = days.iter().map(|day| day.basal).collect();
    let estimate = mean_with_interval(&basal)?;
    if estimate.0 <= 0.0 {
        return None;
    }
    let text = mixed(person, &days).or_else(|| throughout(person, &days, estimate.0))?;
    let found = Finding::new("basal_unit", person, Consequence::ExcludePerson, text);
    Some(found.with_estimate(estimate, "U/day"))
}

/// Basal insulin, `mean` U a day, that is plausible in the other unit alone.
fn throughout(person: &Person, days: &[DayDoses], mean: f64) -> Option<String> {
    let weight = person.weight.unwrap_or(DEFAULT_WEIGHT).0;
    let bolus = days.iter().map(|day| day.bolus).sum::<f64>() / days.len() as f64;
    let fits = |basal: f64| {
        let insulin = basal + bolus;
        // Without boluses there is no share to judge.
        within(insulin / weight, INSULIN_U_KG)
            && (bolus == 0.0 || within(basal / insulin, BASAL_SHARE))
    };
    if fits(mean) {
        return None;
    }
    let share = 100.0 * mean / (mean + bolus);
    // Controllers may give nearly all insulin as boluses, but then they give them at night as well.
    let bare = night_insulin(person) < NIGHT_U_KG * weight;
    let programmed = share < LEAST_PROGRAMMED && person.therapy == Therapy::OpenLoopPump;
    if (mean / (mean + bolus) < BASAL_SHARE.0 || bolus == 0.0)
        && fits(FACTOR * mean)
        && (bare || programmed)
    {
        Some(format!(
            "basal insulin of {mean:.1} U a day is {share:.0} % of all insulin, less than a body \
             without meals needs: amounts per 5 min recorded as U/h; multiply basal_u_h by 12"
        ))
    } else if (mean + bolus) / weight > INSULIN_U_KG.1 && fits(mean / FACTOR) {
        Some(format!(
            "basal insulin of {mean:.0} U a day is {share:.0} % of all insulin: rates in U/h taken for \
             amounts per 5 min; divide basal_u_h by 12"
        ))
    } else {
        None
    }
}

fn within(value: f64, (low, high): (f64, f64)) -> bool {
    (low..=high).contains(&value)
}

/// Insulin from midnight to six as a daily rate, U/day: the median over nights.
fn night_insulin(person: &Person) -> f64 {
    let record = &person.record;
    let mut nights: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
    for k in (0..record.len()).filter(|k| record.hour(*k) < 6) {
        let (Some(basal), Some(bolus)) = (record.basal()[k], record.bolus()[k]) else { continue };
        let (sum, count) = nights.entry(record.day_index(k)).or_default();
        *sum += basal / FACTOR + bolus;
        *count += 1.0;
    }
    let mut rates: Vec<f64> = nights.values().map(|(sum, n)| sum / n * 24.0 * FACTOR).collect();
    median(&mut rates)
}

/// Days whose basal insulin is a twelfth of the other days'.
fn mixed(person: &Person, days: &[DayDoses]) -> Option<String> {
    let mut sorted: Vec<f64> = days.iter().map(|day| day.basal).filter(|b| *b > 0.0).collect();
    sorted.sort_by(f64::total_cmp);
    // The widest gap between neighbours, on a log scale, parts the days.
    let split = (FEWEST_DAYS..(sorted.len() + 1).saturating_sub(FEWEST_DAYS))
        .max_by(|a, b| (sorted[*a] / sorted[*a - 1]).total_cmp(&(sorted[*b] / sorted[*b - 1])))?;
    let (low, high) = sorted.split_at(split);
    let (few, many) = (low[low.len() / 2], high[high.len() / 2]);
    let alike = |values: &[f64], middle: f64| {
        values.iter().all(|v| within(*v, (middle / ALIKE, middle * ALIKE)))
    };
    if !(within(many / few, APART) && alike(low, few) && alike(high, many)) {
        return None;
    }
    let border = high[0];
    let first = days.iter().find(|day| day.basal > 0.0 && day.basal < border)?;
    let date = person.record.time(first.start).date();
    Some(format!(
        "basal insulin is {few:.1} U a day on {} days and {many:.1} on {}, first from {date}: U/h and \
         amounts per 5 min are mixed; convert the days of one unit",
        low.len(),
        high.len()
    ))
}
