//! Sensors lose sensitivity over their days, and their offset moves.

use rand::Rng;

use super::forms::DriftForm;
use crate::stream::standard_normal;

/// Loss of gain late in the life of a sensor at amplitude 1, as a share, and its spread between
/// sensors. The gains of the sensors behind the G5 and G6 error models scatter by about this around
/// their means (Vettoretti et al., Sensors 2019;19:5320, of the order of). That every sensor tends
/// to lose gain is assumed.
const LOSS: (f64, f64) = (0.08, 0.035);
/// Days over which the loss sets in.
const DAYS: f64 = 4.0;
/// Spread of the offset between sensors after ten days, mg/dL; assumed.
const OFFSET: f64 = 5.0;

/// How one sensor would drift beyond the mean of its kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// Final loss of gain, as a share.
    pub loss: f64,
    /// Offset after ten days, mg/dL.
    pub offset: f64,
}

/// Draws the drifts of `sensors` sensors.
#[must_use]
pub(super) fn sample(sensors: usize, rng: &mut (impl Rng + ?Sized)) -> Vec<Drift> {
    let (loss, spread) = LOSS;
    (0..sensors)
        .map(|_| Drift {
            loss: (loss + spread * standard_normal(rng)).clamp(0.0, 0.2),
            offset: OFFSET * standard_normal(rng).clamp(-2.5, 2.5),
        })
        .collect()
}

/// What a drift adds to gain and offset (mg/dL) of a sensor worn for `age_days`.
#[must_use]
pub(super) fn at(form: DriftForm, drift: &Drift, age_days: f64, amplitude: f64) -> (f64, f64) {
    let sign = drift.offset.signum();
    let lost = match form {
        DriftForm::Loss => drift.loss * (1.0 - (-age_days / DAYS).exp()),
        DriftForm::Signed => sign * drift.loss * age_days / 7.0,
        DriftForm::FirstDay => 2.0 * sign * drift.loss * (-age_days / 0.8).exp(),
        DriftForm::EndOfLife => 1.2 * drift.loss * ((age_days - 5.0) / 2.0).clamp(0.0, 2.0),
    };
    let offset = match form {
        DriftForm::Loss => drift.offset * age_days / 10.0,
        DriftForm::Signed | DriftForm::FirstDay | DriftForm::EndOfLife => 0.0,
    };
    (-(amplitude * lost).clamp(-0.7, 0.7), amplitude * offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_sensor_has_not_drifted_and_an_old_one_reads_low() {
        let drift = Drift { loss: 0.08, offset: 3.0 };
        let at = |drift, age, amplitude| at(DriftForm::Loss, drift, age, amplitude);
        assert_eq!(at(&drift, 0.0, 1.0), (-0.0, 0.0));
        let (gain, offset) = at(&drift, 10.0, 1.0);
        assert!((-0.08..-0.07).contains(&gain) && (offset - 3.0).abs() < 1e-12); // rounding
        assert_eq!(at(&drift, 10.0, 0.0), (-0.0, 0.0));
    }
}
