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
        hours: 3,
    },
    UnknownEvents {
        name: "unknown_long_sensor_events",
        port: Port::Sensor,
        field: Field::SensorGain,
        change: 0.2,
        hours: 7,
    },
];
