//! Glucose 30, 60 and 120 minutes ahead (paper, "Evaluation as a predictive model").
//!
//! Unlike a forecaster in use, the plants are told the doses, meals and context that lie ahead, as
//! in the paper. Persistence, linear extrapolation and a linear regression fitted on the training
//! days stand beside them, so that the errors mean something.

use std::ops::Range;

use cohort::{Person, WindowRule, split_by_time, windows};
use nn_statespace::PopulationModel;
use physiology::STEP;
use twins::{PersonWindows, SteadyStates};

use crate::arx::{Arx, BACK, READINGS};
use crate::error::EvaluationError;
use crate::method::Method;
use crate::models::{Model, PersonModels};
use crate::readings::sensor_reading;
use crate::settings::EvaluationSettings;

/// Horizons of the paper, min.
pub const FORECAST_MINUTES: [u32; 3] = [30, 60, 120];
/// Steps before the origin from which linear extrapolation takes its slope: 15 min.
const BEFORE: usize = 3;
/// Steps of the longest horizon.
const AHEAD: usize = 24;
/// Steps between two origins: 30 min.
const STRIDE: usize = 6;

/// Something that forecasts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Forecaster {
    /// A plant that runs freely from the origin.
    Plant(Method),
    /// The reading at the origin.
    Persistence,
    /// The least-squares line through the four readings up to the origin, drawn from the reading
    /// at the origin.
    LinearExtrapolation,
    /// A linear regression on readings, insulin and carbohydrate, fitted on the training days.
    Arx,
}

impl Forecaster {
    /// Every forecaster, the twin first; plants where there are such models.
    pub const ALL: [Self; 8] = [
        Self::Plant(Method::Twin),
        Self::Plant(Method::ConstrainedTwin),
        Self::Plant(Method::Population),
        Self::Plant(Method::Ode),
        Self::Plant(Method::MaximumAPosteriori),
        Self::Persistence,
        Self::LinearExtrapolation,
        Self::Arx,
    ];

    /// The key in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Plant(method) => method.name(),
            Self::Persistence => "persistence",
            Self::LinearExtrapolation => "linear",
            Self::Arx => "arx",
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
}

/// Errors over origins every 30 minutes in the test days with complete readings and doses from 30
/// minutes before to two hours after. Empty if there is no such origin; the regression is absent where
/// the training days were too few to fit it.
pub(crate) fn forecast_errors(
    index: usize,
    person: &Person,
    cut: &PersonWindows,
    models: &PersonModels,
    steady: &SteadyStates<'_, PopulationModel>,
    settings: &EvaluationSettings,
) -> Result<Vec<ForecastError>, EvaluationError> {
    let training_days = settings.protocol.training_days_of(&person.record);
    let split = split_by_time(&person.record, training_days);
    let test = origins(index, person, split.test, settings)?;
    if test.is_empty() {
        return Ok(Vec::new());
    }
    let glucose = person.record.cgm();
    let actual = |origin: usize, ahead: usize| glucose[origin + ahead].map_or(f64::NAN, |g| g);

    let mut errors = Vec::new();
    let mut keep = |forecaster, ahead: usize, forecasts: Vec<f64>| {
        let squares: f64 =
            test.iter().zip(forecasts).map(|(o, f)| (f - actual(*o, ahead)).powi(2)).sum();
        errors.push(ForecastError {
            forecaster,
            minutes: (ahead as f64 * STEP.0) as u32,
            rmse: (squares / test.len() as f64).sqrt(),
        });
    };
    let horizons = FORECAST_MINUTES.map(|minutes| (f64::from(minutes) / STEP.0) as usize);
    let parts: Vec<Range<usize>> = test.iter().map(|origin| *origin..*origin + AHEAD).collect();
    for forecaster in Forecaster::ALL {
        let Forecaster::Plant(method) = forecaster else { continue };
        let model = match models.of(method) {
            // A forecast is one course, not several drawn ones.
            None | Some(Model::Draws(_) | Model::Spread(..)) => continue,
            Some(model) => model,
        };
        let (runs, _) = model.runs(steady, (person, cut), &parts)?;
        for ahead in horizons {
            keep(forecaster, ahead, runs[0].iter().map(|run| run[ahead].0).collect());
        }
    }
    let training = origins(index, person, split.train, settings)?;
    for ahead in horizons {
        let now = |origin: &usize| actual(*origin, 0);
        keep(Forecaster::Persistence, ahead, test.iter().map(now).collect());
        let lines = test.iter().map(|origin| {
            let before: Vec<f64> = (0..=BEFORE).map(|k| actual(origin + k - BEFORE, 0)).collect();
            sensor_reading(now(origin) + slope_per_step(&before) * ahead as f64)
        });
        keep(Forecaster::LinearExtrapolation, ahead, lines.collect());
        if let Some(arx) = Arx::fit(glucose, &cut.inputs, &training, ahead) {
            let forecasts: Option<Vec<f64>> = test
                .iter()
                .map(|origin| arx.forecast(glucose, &cut.inputs, *origin).map(sensor_reading))
                .collect();
            if let Some(forecasts) = forecasts {
                keep(Forecaster::Arx, ahead, forecasts);
            }
        }
    }
    Ok(errors)
}

/// Origins in a part of the record, 30 minutes apart, with what every forecaster needs.
fn origins(
    index: usize,
    person: &Person,
    part: Range<usize>,
    settings: &EvaluationSettings,
) -> Result<Vec<usize>, EvaluationError> {
    let before = READINGS - 1;
    let len = before + 1 + AHEAD;
    let overlap = 1.0 - STRIDE as f64 / len as f64;
    let rule = WindowRule { len, overlap, cgm_share: 1.0, ..settings.protocol.test };
    let cuts = windows(index, &person.record, part, &rule)?;
    // Doses before the readings may be missing; they count as none, as everywhere.
    Ok(cuts.iter().map(|cut| cut.start + before).filter(|origin| *origin >= BACK).collect())
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
