//! `glucose_by_person.json`: each person's measured glucose in the figures of a report on CGM.

use crate::agp::Percentiles;
use crate::{ContractError, Document};

/// `glucose_by_person.json`: readings that are in use, by person.
#[apply(strict!)]
pub struct GlucoseByPerson {
    /// `glucose-by-person/1`.
    pub schema: String,
    /// Middle of each slot of the day, h.
    pub hour: Vec<f64>,
    /// People with two readings or more, in the order of the cohort.
    pub people: Vec<PersonGlucose>,
}

/// One person's glucose.
#[apply(strict!)]
pub struct PersonGlucose {
    /// The person.
    pub person_id: String,
    /// Readings in use.
    pub readings: usize,
    /// Mean, mg/dL.
    pub mean_mg_dl: f64,
    /// Coefficient of variation, %.
    pub cv: f64,
    /// Glucose management indicator, %.
    pub gmi: f64,
    /// Shares of the readings, %.
    pub ranges: GlucoseRanges,
    /// Insulin, U a day; null where basal or boluses are not recorded.
    pub insulin_u_day: Option<f64>,
    /// Carbohydrate logged, g a day; null where it is not recorded.
    pub carbs_g_day: Option<f64>,
    /// Percentiles by time of day, one value a slot.
    pub percentiles: Percentiles,
}

/// Shares of readings in the five ranges of the consensus on CGM; they add up to 100 %.
#[apply(strict!)]
#[derive(Copy)]
pub struct GlucoseRanges {
    /// Below 54 mg/dL, %.
    pub below_54: f64,
    /// From 54 to below 70 mg/dL, %.
    pub from_54_to_70: f64,
    /// From 70 to 180 mg/dL, %.
    pub from_70_to_180: f64,
    /// Above 180 to 250 mg/dL, %.
    pub from_180_to_250: f64,
    /// Above 250 mg/dL, %.
    pub above_250: f64,
}

impl Document for GlucoseByPerson {
    const FILE: &'static str = "glucose_by_person.json";
    const SCHEMA: &'static str = "glucose-by-person/1";

    fn check(&self) -> Result<(), ContractError> {
        let slots = self.hour.len();
        self.people.iter().try_for_each(|person| person.percentiles.even(Self::FILE, slots))
    }
}
