//! `flat_cgm`: a sensor that shows one value, or nothing within its range.
//!
//! A sensor's own error scatters its readings even where glucose stands still, so that a column with less scatter
//! than that is no sensor's. And half of a person's readings cannot lie beyond its range: below 40 mg/dL nobody
//! lives, and even without any insulin the ODE plant settles at 400 mg/dL, where the kidneys excrete what
//! production exceeds uptake by: 9 mmol/L + (EGP0 - F01) / (0.003/min V_G).

use cohort::Person;

use super::{Consequence, Finding};
use crate::filter::noise::NoiseModel;
use crate::filter::observations::{SENSOR_HIGH, SENSOR_LOW};

/// Distance between the 5th and the 95th percentile of a normal distribution, standard deviations.
const NINETY_PERCENT: f64 = 3.29;
/// Share of readings at or beyond the ends of the range that nobody has.
const OUT_OF_RANGE: f64 = 0.5;
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
    } else if at(0.95) - at(0.05) < NINETY_PERCENT * NoiseModel::working().sensor_sd {
        format!(
            "nine of ten readings lie between {:.0} and {:.0} mg/dL: a flat line is no person's glucose",
            at(0.05),
            at(0.95)
        )
    } else {
        return None;
    };
    Some(Finding::new("flat_cgm", person, Consequence::ExcludePerson, text))
}
