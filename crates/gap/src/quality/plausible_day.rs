//! `plausible_day`: doses that do not add up to a day that a person can live.
//!
//! Four points: insulin per body weight, the share of basal in it, carbohydrate, and carbohydrate
//! per unit of bolus. Insulin that cannot be (0.2 to 1.5 U/kg are plausible, 0.4 to 1.0 typical: ADA
//! Standards of Care) excludes the person, as do two other points together; one alone is noted.

use cohort::Person;

use super::daily_doses::{DayDoses, days, mean_with_interval};
use super::{Consequence, Finding};
use crate::filter::observations::DEFAULT_WEIGHT;

/// Plausible insulin a day, U/kg.
const INSULIN_U_KG: (f64, f64) = (0.2, 1.5);
/// Plausible insulin a day where the weight is unknown, U: a small child's to a heavy adult's.
const INSULIN_U: (f64, f64) = (8.0, 150.0);
/// Plausible share of basal insulin. Some controllers give little else than micro-boluses.
const BASAL_SHARE: (f64, f64) = (0.1, 0.9);
/// Plausible carbohydrate a day, g: below, people eat ketogenic food or do not log.
const CARBS_G: (f64, f64) = (30.0, 500.0);
/// Plausible carbohydrate per unit of bolus, g/U: ratios in use are 3 to 30, and carbohydrate may be
/// logged without bolus or the other way round.
const GRAMS_PER_UNIT: (f64, f64) = (1.5, 60.0);
/// From this daily insulin on, per kg, units are likely thousandths.
const THOUSANDTHS_U_KG: f64 = 30.0;

/// The findings; none where an earlier finding about a unit or a flag (in `before`) says why.
pub(super) fn findings(person: &Person, before: &[Finding]) -> Vec<Finding> {
    let explained = before.iter().any(|finding| {
        ["dose_is_flag", "basal_unit", "carb_unit"].contains(&finding.reported.check.as_str())
    });
    let days = days(person);
    let of = |value: fn(&DayDoses) -> Option<f64>| -> Option<(f64, f64, f64)> {
        mean_with_interval(&days.iter().filter_map(value).collect::<Vec<f64>>())
    };
    let Some((mean, lower, upper)) = of(|day| Some(day.insulin())) else { return Vec::new() };
    if explained || mean <= 0.0 {
        return Vec::new();
    }
    // Where only one of basal and bolus is recorded, the day is known from above alone.
    let whole = days.iter().any(|day| day.basal > 0.0) && days.iter().any(|day| day.bolus > 0.0);
    let (unit, over, (low, high)) = match person.weight {
        Some(weight) => ("U/kg/day", weight.0, INSULIN_U_KG),
        None => ("U/day", 1.0, INSULIN_U),
    };
    let insulin = (mean / over, lower / over, upper / over);
    let plausible = (if whole { low } else { 0.0 }, high);
    let cure = if mean / person.weight.unwrap_or(DEFAULT_WEIGHT).0 > THOUSANDTHS_U_KG {
        "doses in thousandths of a unit; divide them by 1000"
    } else if insulin.0 > high {
        "check the units of basal_u_h and bolus_u"
    } else {
        "doses are missing or their unit is larger than U; check basal_u_h and bolus_u"
    };
    if let Some(found) = outside(person, "insulin", Some(insulin), unit, plausible, cure) {
        return vec![Finding { consequence: Consequence::ExcludePerson, ..found }];
    }
    let share = of(|day| (day.insulin() > 0.0).then(|| day.basal / day.insulin()));
    let share = share.filter(|_| whole);
    let total = |value: fn(&DayDoses) -> f64| days.iter().map(value).sum::<f64>();
    let (carbs, bolus) = (total(|day| day.carbs.unwrap_or(0.0)), total(|day| day.bolus));
    let ratio = carbs / bolus;
    let ratio = (carbs > 0.0 && bolus > 0.0).then_some((ratio, ratio, ratio));
    let missing = "check whether boluses or basal rates are missing";
    let logged = "check its unit and whether meals are logged";
    let units = "check the units of carbs_g and bolus_u";
    let points = [
        outside(person, "basal share of insulin", share, "of all insulin", BASAL_SHARE, missing),
        outside(person, "carbohydrate", of(|day| day.carbs), "g/day", CARBS_G, logged),
        outside(person, "carbohydrate per bolus", ratio, "g/U", GRAMS_PER_UNIT, units),
    ];
    let mut found: Vec<Finding> = points.into_iter().flatten().collect();
    if found.len() > 1 {
        found.iter_mut().for_each(|point| point.consequence = Consequence::ExcludePerson);
    }
    found
}

/// A point of the day, to be noted where its interval lies wholly outside what is plausible.
fn outside(
    person: &Person,
    name: &str,
    mean: Option<(f64, f64, f64)>,
    unit: &str,
    (low, high): (f64, f64),
    cure: &str,
) -> Option<Finding> {
    let (value, lower, upper) = mean.filter(|(_, lower, upper)| *upper < low || *lower > high)?;
    let text = format!("{name} of {value:.2} {unit} is outside {low} to {high}; {cure}");
    let found = Finding::new("plausible_day", person, Consequence::Note, text);
    Some(found.with_estimate((value, lower, upper), unit))
}
