//! Unexplained events of the sensor.

use effects::{Field, Port};

use super::UnknownEvents;

/// The kinds of unexplained events of the sensor that are tried.
pub(super) const KINDS: [UnknownEvents; 2] = [
    UnknownEvents {
        name: "unknown_sensor_events",
        port: Port::Sensor,
        field: Field::SensorGain,
        change: 0.2,
        hours: &[3, 5, 8],
    },
    // What the electrode takes for glucose adds to the reading, whatever glucose is: 1 g of acetaminophen reads as up to 60
    // mg/dL more for hours (Maahs et al., Diabetes Care 2015;38:e158).
    UnknownEvents {
        name: "unknown_sensor_offsets",
        port: Port::Sensor,
        field: Field::SensorOffset,
        change: 30.0,
        hours: &[3, 5, 8],
    },
];
