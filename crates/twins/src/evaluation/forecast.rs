//! Glucose 30, 60 and 120 minutes ahead (paper, "Evaluation as a predictive model").
//!
//! Unlike a forecaster in use, the plants are told the doses, meals and context that lie ahead, as
//! in the paper. Persistence and linear extrapolation stand beside them, so that the errors mean
//! something.

use cohort::{Person, WindowRule, split_by_time, windows};
use nn_statespace::PopulationModel;
use ode_sim::OdePlant;
use physiology::{MgPerDl, STEP};

use crate::error::TwinError;
use crate::evaluation::person::{readings, sensor_reading};
use crate::evaluation::{EvaluationSettings, Method};
use crate::protocol::{PersonWindows, measured};
use crate::start::{SteadyStates, window_starts, window_starts_with};
use crate::twin::Twin;

/// Horizons of the paper, min.
pub const FORECAST_MINUTES: [u32; 3] = [30, 60, 120];
/// Steps before the origin from which linear extrapolation takes its slope: 15 min.
const BEFORE: usize = 3;
/// Steps of the longest horizon.
const AHEAD: usize = 24;
/// Steps between two origins: 30 min.
const STRIDE: usize = 6;

/// Something that forecasts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Forecaster {
    /// A plant that runs freely from the origin.
    Plant(Method),
    /// The reading at the origin.
    Persistence,
    /// The least-squares line through the four readings up to the origin, drawn from the reading
    /// at the origin.
    LinearExtrapolation,
}

impl Forecaster {
    /// Every forecaster, the twin first.
    pub const ALL: [Self; 5] = [
        Self::Plant(Method::Twin),
        Self::Plant(Method::Population),
        Self::Plant(Method::Ode),
        Self::Persistence,
        Self::LinearExtrapolation,
    ];

    /// The key in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Plant(method) => method.name(),
            Self::Persistence => "persistence",
            Self::LinearExtrapolation => "linear",
        }
    }
}

/// One person's error of one forecaster at one horizon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForecastError {
    /// The forecaster.
    pub forecaster: Forecaster,
    /// The horizon, min.
    pub minutes: u32,
    /// Root mean squared error over the person's origins, mg/dL.
    pub rmse: f64,
    /// Number of origins.
    pub origins: usize,
}

/// Errors over origins every 30 minutes in the test days with complete readings and doses from 15
/// minutes before to two hours after. Empty if there is no such origin.
pub(super) fn forecast_errors(
    index: usize,
    person: &Person,
    cut: &PersonWindows,
    twin: &Twin,
    steady: &SteadyStates<'_, PopulationModel>,
    ode: &OdePlant,
    settings: &EvaluationSettings,
) -> Result<Vec<ForecastError>, TwinError> {
    let len = BEFORE + 1 + AHEAD;
    let overlap = 1.0 - STRIDE as f64 / len as f64;
    let rule = WindowRule { len, overlap, ..settings.protocol.test };
    let rule = WindowRule { cgm_share: 1.0, ..rule };
    let training_days = settings.protocol.training_days_of(&person.record);
    let test = split_by_time(&person.record, training_days).test;
    let cuts = windows(index, &person.record, test, &rule)?;
    if cuts.is_empty() {
        return Ok(Vec::new());
    }
    let origins: Vec<usize> = cuts.iter().map(|window| window.start + BEFORE).collect();
    let start = settings.protocol.start;
    let of_network =
        window_starts_with(steady, person, &cut.inputs, &origins, start, cut.mean_basal)?;
    let of_ode = window_starts(ode, person, &cut.inputs, &origins, start, cut.mean_basal)?;

    let mut squares = [[0.0; FORECAST_MINUTES.len()]; Forecaster::ALL.len()];
    for (n, (window, origin)) in cuts.iter().zip(&origins).enumerate() {
        let inputs = &cut.inputs[*origin..origin + AHEAD];
        let readings_of = [
            readings(twin, of_network.states[n], inputs)?,
            readings(steady.plant(), of_network.states[n], inputs)?,
            readings(ode, of_ode.states[n], inputs)?,
        ];
        let measured = measured(person, window)?;
        let now = measured[BEFORE];
        let slope = slope_per_step(&measured[..=BEFORE]);
        for (horizon, minutes) in FORECAST_MINUTES.into_iter().enumerate() {
            let ahead = (f64::from(minutes) / STEP.0) as usize;
            let actual = measured[BEFORE + ahead];
            let line = sensor_reading(MgPerDl(now + slope * ahead as f64)).0;
            let forecasts = [
                readings_of[0][ahead].0,
                readings_of[1][ahead].0,
                readings_of[2][ahead].0,
                now,
                line,
            ];
            for (sum, forecast) in squares.iter_mut().zip(forecasts) {
                sum[horizon] += (forecast - actual).powi(2);
            }
        }
    }
    let mut errors = Vec::with_capacity(Forecaster::ALL.len() * FORECAST_MINUTES.len());
    for (forecaster, sums) in Forecaster::ALL.into_iter().zip(squares) {
        for (minutes, sum) in FORECAST_MINUTES.into_iter().zip(sums) {
            let rmse = (sum / origins.len() as f64).sqrt();
            errors.push(ForecastError { forecaster, minutes, rmse, origins: origins.len() });
        }
    }
    Ok(errors)
}

/// Least-squares slope of equally spaced values, per step.
fn slope_per_step(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let centre = (n - 1.0) / 2.0;
    let mean = values.iter().sum::<f64>() / n;
    let (mut above, mut below) = (0.0, 0.0);
    for (k, value) in values.iter().enumerate() {
        let x = k as f64 - centre;
        above += x * (value - mean);
        below += x * x;
    }
    above / below
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_is_that_of_the_line() {
        assert!((slope_per_step(&[100.0, 102.0, 104.0, 106.0]) - 2.0).abs() < 1e-12); // rounding
        // numpy.polyfit([0, 1, 2, 3], [1, 0, 2, 5], 1) gives 1.4.
        assert!((slope_per_step(&[1.0, 0.0, 2.0, 5.0]) - 1.4).abs() < 1e-12);
    }
}
