//! The sensor and the pump that a person wears.

use physiology::{MgPerDl, Units, UnitsPerHour};

use crate::wear::SensorWear;

/// A sensor as it is worn.
#[derive(Debug, Clone)]
pub(crate) struct Sensor {
    wear: SensorWear,
}

impl Sensor {
    /// Sensors worn as `wear` says.
    #[must_use]
    pub(crate) fn new(wear: SensorWear) -> Self {
        Self { wear }
    }

    /// The reading of a step.
    pub(crate) fn read(&mut self, step: usize, glucose: MgPerDl) -> Option<MgPerDl> {
        (!self.wear.is_lost(step)).then(|| MgPerDl(glucose.0.round().clamp(40.0, 400.0)))
    }
}

/// A pump.
#[derive(Debug, Clone, Default)]
pub(crate) struct Pump {}

impl Pump {
    /// A pump.
    #[must_use]
    pub(crate) fn new() -> Self {
        Self {}
    }
    /// Delivered rate.
    pub(crate) fn basal(&mut self, rate: UnitsPerHour) -> UnitsPerHour {
        UnitsPerHour((rate.0 * 1000.0).round() / 1000.0)
    }
    /// Delivered bolus.
    pub(crate) fn bolus(&mut self, amount: Units) -> Units {
        Units((amount.0 * 20.0).round() / 20.0)
    }
}
