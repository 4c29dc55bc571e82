//! `example_day.json`: up to three consecutive days of one person, measured and simulated.

use crate::document::even;
use crate::{ContractError, Document};

/// `example_day.json`: every series has one value a step.
#[apply(strict!)]
pub struct ExampleDay {
    /// `example-day/2`.
    pub schema: String,
    /// The person.
    pub person_id: String,
    /// The days, as they should be shown.
    pub date: String,
    /// Days shown.
    pub days: usize,
    /// Wall clock of every step, `HH:MM`, from the first day's first step on.
    pub time: Vec<String>,
    /// Sensor glucose, mg/dL.
    pub cgm: Vec<Option<f64>>,
    /// Glucose of the population network, mg/dL; simulated series begin with the first reading.
    pub population: Vec<Option<f64>>,
    /// Glucose of the person's twin, mg/dL.
    pub twin: Vec<Option<f64>>,
    /// Glucose of the ODE plant with population parameters, mg/dL.
    pub ode: Vec<Option<f64>>,
    /// Glucose of the closest virtual patient, mg/dL; absent where none was sought.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub closest: Option<Vec<Option<f64>>>,
    /// Basal rate, U/h.
    pub basal_u_h: Vec<f64>,
    /// Boluses in each step, U.
    pub bolus_u: Vec<f64>,
    /// Carbohydrate in each step, g.
    pub carbs_g: Vec<f64>,
    /// Heart rate over its resting baseline, a difference, 1/min; 0 at rest.
    pub heart_rate_over_baseline: Vec<Option<f64>>,
    /// Share of each step asleep, 0 to 1.
    pub sleep_efficiency: Vec<Option<f64>>,
    /// Times in ranges of each glucose series.
    pub outcomes: SeriesOutcomes,
    /// By what rule person and days were chosen.
    pub chosen: String,
}

/// Outcomes of each glucose series, all over the steps after the start that have a reading.
#[apply(strict!)]
pub struct SeriesOutcomes {
    /// Of the sensor.
    pub cgm: TimeInRanges,
    /// Of the population network.
    pub population: TimeInRanges,
    /// Of the twin.
    pub twin: TimeInRanges,
    /// Of the ODE plant.
    pub ode: TimeInRanges,
    /// Of the closest virtual patient.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub closest: Option<TimeInRanges>,
}

/// Shares of the steps, %.
#[apply(strict!)]
#[derive(Copy)]
pub struct TimeInRanges {
    /// Below 70 mg/dL.
    pub tbr: f64,
    /// From 70 to 180 mg/dL.
    pub tir: f64,
    /// Above 180 mg/dL.
    pub tar: f64,
}

impl Document for ExampleDay {
    const FILE: &'static str = "example_day.json";
    const SCHEMA: &'static str = "example-day/2";

    fn check(&self) -> Result<(), ContractError> {
        let closest = self.closest.as_ref().map(|series| ("closest", series.len()));
        let series = [
            ("cgm", self.cgm.len()),
            ("population", self.population.len()),
            ("twin", self.twin.len()),
            ("ode", self.ode.len()),
            ("basal_u_h", self.basal_u_h.len()),
            ("bolus_u", self.bolus_u.len()),
            ("carbs_g", self.carbs_g.len()),
            ("heart_rate_over_baseline", self.heart_rate_over_baseline.len()),
            ("sleep_efficiency", self.sleep_efficiency.len()),
        ];
        even(Self::FILE, ("time", self.time.len()), series.into_iter().chain(closest))
    }
}
