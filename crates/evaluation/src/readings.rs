//! What a sensor would have read of free runs.

use std::ops::Range;

use cohort::{Person, Window};
use nn_statespace::GLUCOSE_RANGE;
use physiology::{MgPerDl, OpenLoop, Plant, StepInput, simulate};
use twins::{PersonWindows, Startable, SteadyStates, window_starts_with};

use crate::error::EvaluationError;

/// Readings of some runs, the start of each first.
pub(crate) type Runs = Vec<Vec<MgPerDl>>;

/// What a sensor would have read of free runs of a plant through parts of a person's record, and how
/// many of their starts are no steady states although these were asked for. Starts are those of the
/// plant of `steady`: of a twin, its population model's.
pub(crate) fn runs<S: Startable>(
    plant: &impl Plant<State = S::State>,
    steady: &SteadyStates<'_, S>,
    (person, cut): (&Person, &PersonWindows),
    parts: &[Range<usize>],
) -> Result<(Runs, usize), EvaluationError> {
    let steps: Vec<usize> = parts.iter().map(|part| part.start).collect();
    let starts =
        window_starts_with(steady, person, &cut.inputs, &steps, cut.start, cut.mean_basal)?;
    let runs = parts.iter().zip(starts.states);
    let runs = runs.map(|(part, start)| readings(plant, start, &cut.inputs[part.clone()]));
    Ok((runs.collect::<Result<_, _>>()?, starts.not_at_rest))
}

/// The steps from the first to the last reading of each window, whose inputs act on a run.
pub(crate) fn within(windows: &[Window]) -> Vec<Range<usize>> {
    windows.iter().map(|window| window.start..window.start + window.len - 1).collect()
}

/// What a sensor would have read of a free run, the start included.
pub(crate) fn readings<P: Plant>(
    plant: &P,
    start: P::State,
    inputs: &[StepInput],
) -> Result<Vec<MgPerDl>, EvaluationError> {
    let run = simulate(plant, start, &mut OpenLoop::new(inputs), inputs.len())?;
    let glucose = run.glucose(plant).into_iter();
    Ok(glucose.map(|glucose| MgPerDl(sensor_reading(glucose.0))).collect())
}

/// Glucose within a sensor's range, 40 to 400 mg/dL, so that all methods are judged on what the
/// record could have shown. A simulation has checked that it is finite.
pub(crate) fn sensor_reading(glucose: f64) -> f64 {
    glucose.clamp(GLUCOSE_RANGE.0.0, GLUCOSE_RANGE.1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sensor_reads_between_40_and_400() {
        for (glucose, expected) in [(-3.0, 40.0), (40.0, 40.0), (123.4, 123.4), (512.0, 400.0)] {
            assert_eq!(sensor_reading(glucose), expected);
        }
    }
}
