//! `flat_cgm`: a sensor that shows one value, or nothing within its range.
//!
//! Glucose of a person with type 1 diabetes varies by a third of its mean (coefficient of variation 36 %,
//! Danne et al. 2017); no person stays within a few mg/dL for days, and nobody lives below 40 or above 400.

use cohort::Person;

use super::{Consequence, Finding};
use crate::filter::observations::{SENSOR_HIGH, SENSOR_LOW};

/// Distance between the 5th and the 95th percentile below which a column is flat, mg/dL. The least of the
/// reference people is above 100.
const FLAT: f64 = 10.0;
/// Share of readings at or beyond the ends of the range from which nothing is known of glucose.
const OUT_OF_RANGE: f64 = 0.9;
/// Fewest readings that are judged: a day of a sensor that reads every 15 min.
const FEWEST: usize = 96;

pub(super) fn finding(person: &Person) -> Option<Finding> {
    let mut values: Vec<f64> = person.record.cgm().iter().flatten().copied().collect();
    if values.len() < FEWEST {
        return None;
    }
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values[(share * (values.len() - 1) as f64) as usize];
    let outside = values.iter().filter(|v| **v <= SENSOR_LOW.0 || **v >= SENSOR_HIGH.0).count();
    let share = outside as f64 / values.len() as f64;
    let text = if share > OUT_OF_RANGE {
        format!(
            "{:.0} % of the readings lie at or beyond the ends of a sensor's range, {SENSOR_LOW} to \
             {SENSOR_HIGH}; check the unit of cgm_mg_dl",
            100.0 * share
        )
    } else if at(0.95) - at(0.05) < FLAT {
        format!(
            "nine of ten readings lie between {:.0} and {:.0} mg/dL: a flat line is no person's glucose",
            at(0.05),
            at(0.95)
        )
    } else {
        return None;
    };
    Some(Finding::note("flat_cgm", person, text).with_consequence(Consequence::ExcludePerson))
}
