//! Unexplained events of the body.

use effects::{Field, Port};

use super::UnknownEvents;

/// The kinds of unexplained events of the body that are tried.
pub(super) const KINDS: [UnknownEvents; 1] = [UnknownEvents {
    name: "unknown_production_events",
    port: Port::Egp,
    field: Field::Production,
    change: 0.4,
    hours: &[4, 8],
}];
