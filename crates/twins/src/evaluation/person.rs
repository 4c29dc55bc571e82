//! One person's held-out windows under every method.

use cohort::{Person, Window};
use nn_statespace::{GLUCOSE_RANGE, PopulationModel};
use physiology::{MgPerDl, OpenLoop, Plant, StepInput, simulate};
use stats::Outcomes;

use crate::error::TwinError;
use crate::evaluation::forecast::{ForecastError, forecast_errors};
use crate::evaluation::{EvaluationSettings, Method, ode_baseline};
use crate::inputs::MissingContext;
use crate::protocol::{PersonWindows, inputs_within, measured};
use crate::start::{Starts, SteadyStates, window_starts, window_starts_with};
use crate::twin::Twin;

/// One person's figures.
#[derive(Debug, Clone)]
pub struct PersonEvaluation {
    /// The person's identifier.
    pub person_id: String,
    /// Test windows.
    pub windows: usize,
    /// Outcomes of the sensor readings, averaged over windows.
    pub actual: Outcomes,
    /// Figures of each method, in the order of [`Method::ALL`].
    pub methods: [MethodResult; 3],
    /// Forecast errors of every forecaster and horizon.
    pub forecast: Vec<ForecastError>,
    /// Personal inputs that the test windows lacked.
    pub missing: MissingContext,
}

/// What one method made of a person's test windows.
#[derive(Debug, Clone, Copy)]
pub struct MethodResult {
    /// The method.
    pub method: Method,
    /// Outcomes of the simulated readings, averaged over windows.
    pub outcomes: Outcomes,
    /// Root mean squared error over all windows and steps after the start, mg/dL.
    pub rmse: f64,
    /// Windows whose start is no steady state although one was asked for.
    pub not_at_rest: usize,
}

impl PersonEvaluation {
    /// The figures of a method.
    #[must_use]
    pub fn of(&self, method: Method) -> &MethodResult {
        &self.methods[method as usize]
    }
}

pub(super) fn evaluate_person(
    index: usize,
    person: &Person,
    cut: &PersonWindows,
    twin: &Twin,
    steady: &SteadyStates<'_, PopulationModel>,
    settings: &EvaluationSettings,
) -> Result<PersonEvaluation, TwinError> {
    let steps: Vec<usize> = cut.test.iter().map(|window| window.start).collect();
    let ode = ode_baseline(person.weight);
    let start = settings.protocol.start;
    let network_starts =
        window_starts_with(steady, person, &cut.inputs, &steps, start, cut.mean_basal)?;
    let ode_starts = window_starts(&ode, person, &cut.inputs, &steps, start, cut.mean_basal)?;

    let mut actual = Vec::with_capacity(cut.test.len());
    for window in &cut.test {
        let glucose = measured(person, window)?;
        actual.push(Outcomes::of(glucose[1..].iter().copied().map(MgPerDl))?);
    }
    let methods = [
        judge(Method::Twin, twin, person, cut, &network_starts)?,
        judge(Method::Population, steady.plant(), person, cut, &network_starts)?,
        judge(Method::Ode, &ode, person, cut, &ode_starts)?,
    ];
    let within = cut.test.iter().flat_map(|window| inputs_within(&cut.inputs, window));
    Ok(PersonEvaluation {
        person_id: person.id.clone(),
        windows: cut.test.len(),
        actual: Outcomes::average(&actual)?,
        methods,
        forecast: forecast_errors(index, person, cut, twin, steady, &ode, settings)?,
        missing: MissingContext::count(within),
    })
}

fn judge<P: Plant>(
    method: Method,
    plant: &P,
    person: &Person,
    cut: &PersonWindows,
    starts: &Starts<P::State>,
) -> Result<MethodResult, TwinError> {
    let mut outcomes = Vec::with_capacity(cut.test.len());
    let (mut squares, mut samples) = (0.0, 0);
    for (window, start) in cut.test.iter().zip(&starts.states) {
        let simulated = readings(plant, start.clone(), inputs_of(cut, window))?;
        let measured = measured(person, window)?;
        for (s, m) in simulated.iter().zip(&measured).skip(1) {
            squares += (s.0 - m).powi(2);
            samples += 1;
        }
        outcomes.push(Outcomes::of(simulated[1..].iter().copied())?);
    }
    Ok(MethodResult {
        method,
        outcomes: Outcomes::average(&outcomes)?,
        rmse: (squares / f64::from(samples)).sqrt(),
        not_at_rest: starts.not_at_rest,
    })
}

fn inputs_of<'a>(cut: &'a PersonWindows, window: &Window) -> &'a [StepInput] {
    inputs_within(&cut.inputs, window)
}

/// What a sensor would have read of a free run, the start included.
pub(super) fn readings<P: Plant>(
    plant: &P,
    start: P::State,
    inputs: &[StepInput],
) -> Result<Vec<MgPerDl>, TwinError> {
    let run = simulate(plant, start, &mut OpenLoop::new(inputs), inputs.len())?;
    Ok(run.glucose(plant).into_iter().map(sensor_reading).collect())
}

/// Glucose within a sensor's range, 40 to 400 mg/dL, so that all methods are judged on what the
/// record could have shown. A simulation has checked that it is finite.
pub(super) fn sensor_reading(glucose: MgPerDl) -> MgPerDl {
    MgPerDl(glucose.0.clamp(GLUCOSE_RANGE.0.0, GLUCOSE_RANGE.1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sensor_reads_between_40_and_400() {
        for (glucose, expected) in [(-3.0, 40.0), (40.0, 40.0), (123.4, 123.4), (512.0, 400.0)] {
            assert_eq!(sensor_reading(MgPerDl(glucose)), MgPerDl(expected));
        }
    }
}
