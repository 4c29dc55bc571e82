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

/// A point of the day.
struct DailyMean {
    name: &'static str,
    unit: &'static str,
    /// Mean and its interval.
    mean: (f64, f64, f64),
    plausible: (f64, f64),
}

impl DailyMean {
    /// Whether the interval lies wholly outside.
    fn outside(&self) -> bool {
        self.mean.2 < self.plausible.0 || self.mean.1 > self.plausible.1
    }
}

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
    let insulin = DailyMean {
        name: "insulin",
        unit,
        mean: (mean / over, lower / over, upper / over),
        plausible: (if whole { low } else { 0.0 }, high),
    };
    if insulin.outside() {
        let per_kg = mean / person.weight.unwrap_or(DEFAULT_WEIGHT).0;
        let cure = if per_kg > THOUSANDTHS_U_KG {
            "doses in thousandths of a unit; divide them by 1000"
        } else if insulin.mean.0 > insulin.plausible.1 {
            "check the units of basal_u_h and bolus_u"
        } else {
            "doses are missing or their unit is larger than U; check basal_u_h and bolus_u"
        };
        return vec![report(person, &insulin, cure, Consequence::ExcludePerson)];
    }
    let mut points: Vec<(DailyMean, &str)> = Vec::new();
    let mut add = |name, unit, mean, plausible, cure| {
        let point = DailyMean { name, unit, mean, plausible };
        if point.outside() {
            points.push((point, cure));
        }
    };
    if whole && let Some(mean) = of(|day| (day.insulin() > 0.0).then(|| day.basal / day.insulin()))
    {
        let cure = "check whether boluses or basal rates are missing";
        add("basal share of insulin", "of all insulin", mean, BASAL_SHARE, cure);
    }
    if let Some(mean) = of(|day| day.carbs) {
        let cure = "check its unit and whether meals are logged";
        add("carbohydrate", "g/day", mean, CARBS_G, cure);
    }
    let total = |value: fn(&DayDoses) -> f64| days.iter().map(value).sum::<f64>();
    let (carbs, bolus) = (total(|day| day.carbs.unwrap_or(0.0)), total(|day| day.bolus));
    if carbs > 0.0 && bolus > 0.0 {
        let mean = (carbs / bolus, carbs / bolus, carbs / bolus);
        let cure = "check the units of carbs_g and bolus_u";
        add("carbohydrate per bolus", "g/U", mean, GRAMS_PER_UNIT, cure);
    }
    let consequence = if points.len() > 1 { Consequence::ExcludePerson } else { Consequence::Note };
    points.iter().map(|(point, cure)| report(person, point, cure, consequence)).collect()
}

fn report(person: &Person, point: &DailyMean, cure: &str, consequence: Consequence) -> Finding {
    let DailyMean { name, unit, mean, plausible: (low, high) } = *point;
    let value = mean.0;
    let text = format!("{name} of {value:.2} {unit} is outside {low} to {high}; {cure}");
    Finding::note("plausible_day", person, text)
        .with_estimate(mean, unit)
        .with_consequence(consequence)
}
