//! Effects on the readings beyond the sensor's own model.

use physiology::Minutes;

use super::forms::LagForm;
use super::happenings::Happenings;
use super::outside;
use super::sensor_drift::{self, Drift};
use super::shapes::Shapes;
use super::{Amplitudes, Effect, compression_lows};
use crate::behaviour::Life;
use crate::wear::SensorWear;

/// What is added to the sensors of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensing {
    /// Lag before the sensor.
    pub lag: Minutes,
    /// Its form.
    pub lag_form: LagForm,
    /// Added to gain and offset, mg/dL, one pair a step.
    pub added: Vec<(f64, f64)>,
}

/// What acts on the sensors worn through a life.
#[must_use]
pub fn sensing(
    life: &Life,
    wear: &SensorWear,
    happenings: &Happenings,
    shapes: &Shapes,
    amplitudes: &Amplitudes,
) -> Sensing {
    let drifts = amplitudes.of(Effect::SensorDrift);
    let none = Drift { loss: 0.0, offset: 0.0 };
    let mut added: Vec<(f64, f64)> = (0..life.calendar.steps())
        .map(|step| {
            let drift = happenings.drifts.get(wear.sensor(step)).unwrap_or(&none);
            sensor_drift::at(shapes.forms.drift, drift, wear.age_days(step), drifts)
        })
        .collect();
    let pressed = amplitudes.of(Effect::CompressionLows);
    compression_lows::act(shapes.forms.compression, &mut added, &happenings.compressions, pressed);
    outside::act_on_sensor(&mut added, &happenings.outside, amplitudes);
    Sensing {
        lag_form: shapes.forms.lag,
        lag: Minutes(amplitudes.of(Effect::SensorLag) * shapes.sensor_lag.0),
        added,
    }
}
