//! Unexplained events of the sensor.

use effects::{EffectId, Field, Port};

use super::UnknownEvents;

/// The kinds of unexplained events of the sensor that are tried. What the electrode takes for glucose may add to the
/// reading rather than multiply it (1 g of acetaminophen, up to 60 mg/dL for hours: Maahs et al., Diabetes Care
/// 2015;38:e158); over hours of little change the two are alike.
pub(super) const KINDS: [UnknownEvents; 1] = [UnknownEvents {
    id: EffectId::new("unknown_sensor_events"),
    port: Port::Sensor,
    field: Field::SensorGain,
    change: 0.2,
    hours: &[2, 4, 6, 9],
}];
