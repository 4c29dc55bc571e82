//! Unexplained events of the body.

use effects::{EffectId, Field, Port};

use super::UnknownEvents;

/// The kinds of unexplained events of the body that are tried.
pub(super) const KINDS: [UnknownEvents; 2] = [
    UnknownEvents {
        id: EffectId::new("unknown_production_events"),
        port: Port::Egp,
        field: Field::Production,
        change: 0.4,
        hours: &[4, 8],
    },
    // In mmol/kg/min: an event of size 1 is as much as half of nominal production.
    UnknownEvents {
        id: EffectId::new("unknown_flux_events"),
        port: Port::GlucoseFlux,
        field: Field::Flux,
        change: 0.008,
        hours: &[3, 5, 8],
    },
];
