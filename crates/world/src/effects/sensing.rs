//! Effects on the readings beyond the sensor's own model.

use physiology::Minutes;

use super::forms::LagForm;
use super::happenings::Happenings;
use super::outside;
use super::sensor_drift::{self, Drift};
use super::shapes::Shapes;
use super::{Amplitudes, Effect, compression_lows, sensor_lag};
use crate::behaviour::Life;
use crate::wear::SensorWear;

/// What is added to the sensors of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensing {
    /// Lag before the sensor.
    pub lag: Minutes,
    /// Its form.
    pub lag_form: LagForm,
    /// Added to the gain, one value a step.
    pub gain: Vec<f64>,
    /// Added to the offset, mg/dL, one value a step.
    pub offset: Vec<f64>,
}

impl Sensing {
    /// Sensors as their model describes them.
    #[must_use]
    pub fn undisturbed() -> Self {
        let lag_form = LagForm::FirstOrder;
        Self { lag: Minutes(0.0), lag_form, gain: Vec::new(), offset: Vec::new() }
    }

    /// What is added to gain and offset in a step.
    #[must_use]
    pub fn at(&self, step: usize) -> (f64, f64) {
        let of = |values: &[f64]| values.get(step).copied().unwrap_or(0.0);
        (of(&self.gain), of(&self.offset))
    }
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
    let (gain, mut offset): (Vec<f64>, Vec<f64>) = (0..life.calendar.steps())
        .map(|step| {
            let drift = happenings.drifts.get(wear.sensor(step)).unwrap_or(&none);
            sensor_drift::at(shapes.forms.drift, drift, wear.age_days(step), drifts)
        })
        .unzip();
    let pressed = amplitudes.of(Effect::CompressionLows);
    compression_lows::act(shapes.forms.compression, &mut offset, &happenings.compressions, pressed);
    outside::act_on_sensor(&mut offset, &happenings.outside, amplitudes);
    Sensing {
        lag_form: shapes.forms.lag,
        lag: sensor_lag::lag(shapes.sensor_lag, amplitudes.of(Effect::SensorLag)),
        gain,
        offset,
    }
}
