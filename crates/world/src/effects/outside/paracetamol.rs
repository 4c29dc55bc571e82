//! Paracetamol, which some sensors read as glucose.

use rand::Rng;

use super::event::{Event, on_some_days};
use crate::behaviour::Life;

/// Rise of the reading at its height, mg/dL: 61 mg/dL two hours after 1 g (Maahs et al., Diabetes
/// Care 2015;38:e158); some take less.
const RISE: f64 = 50.0;

/// Six hours from any time awake on, a quarter of days (assumed).
pub(super) fn events(life: &Life, rng: &mut (impl Rng + ?Sized)) -> Vec<Event> {
    on_some_days(life, 0.25, (7.0, 23.0), (5.0, 7.0), 2.0, rng)
}

/// What is added to the reading, mg/dL.
pub(super) fn offset(strength: f64) -> f64 {
    RISE * strength
}
