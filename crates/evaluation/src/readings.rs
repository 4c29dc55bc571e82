//! What a sensor would have read of a free run.

use nn_statespace::GLUCOSE_RANGE;
use physiology::{MgPerDl, OpenLoop, Plant, StepInput, simulate};

use crate::error::EvaluationError;

/// What a sensor would have read of a free run, the start included.
pub(crate) fn readings<P: Plant>(
    plant: &P,
    start: P::State,
    inputs: &[StepInput],
) -> Result<Vec<MgPerDl>, EvaluationError> {
    let run = simulate(plant, start, &mut OpenLoop::new(inputs), inputs.len())?;
    Ok(run.glucose(plant).into_iter().map(sensor_reading).collect())
}

/// Glucose within a sensor's range, 40 to 400 mg/dL, so that all methods are judged on what the
/// record could have shown. A simulation has checked that it is finite.
pub(crate) fn sensor_reading(glucose: MgPerDl) -> MgPerDl {
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
