//! The state of the filter's model: a body's, and what stands between it and a reading.

use ode_sim::{OdeState, OdeVector};
use physiology::MgPerDl;

/// Number of augmented states; the first ten are the compartments in the order of [`slot`](ode_sim::slot).
pub const STATES: usize = 14;
/// Index of the flux into Q1, mmol/kg/min.
pub const FLUX: usize = 10;
/// Index of interstitial glucose, mg/dL.
pub const INTERSTITIAL: usize = 11;
/// Index of the sensor error, mg/dL.
pub const SENSOR: usize = 12;
/// Index of the sensor error one step before, mg/dL.
pub const SENSOR_BEFORE: usize = 13;

/// The augmented state.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AugmentedState {
    /// The plant's state.
    pub body: OdeState,
    /// Unexplained flux into Q1, mmol/kg/min.
    pub flux: f64,
    /// Interstitial glucose.
    pub interstitial: MgPerDl,
    /// Sensor error.
    pub sensor: MgPerDl,
    /// Sensor error one step before.
    pub sensor_before: MgPerDl,
}

impl AugmentedState {
    /// The fourteen values in the order of [`Transition`](crate::filter::transition::Transition).
    #[inline]
    #[must_use]
    pub fn vector(&self) -> [f64; STATES] {
        let mut all = [0.0; STATES];
        all[..FLUX].copy_from_slice(&self.body.vector().0);
        all[FLUX] = self.flux;
        all[INTERSTITIAL] = self.interstitial.0;
        all[SENSOR] = self.sensor.0;
        all[SENSOR_BEFORE] = self.sensor_before.0;
        all
    }

    /// The same state with its fourteen values replaced.
    #[must_use]
    pub fn with_vector(self, all: &[f64; STATES]) -> Self {
        let body: [f64; FLUX] = std::array::from_fn(|k| all[k]);
        Self {
            body: self.body.with_vector(&OdeVector(body)),
            flux: all[FLUX],
            interstitial: MgPerDl(all[INTERSTITIAL]),
            sensor: MgPerDl(all[SENSOR]),
            sensor_before: MgPerDl(all[SENSOR_BEFORE]),
        }
    }
}
