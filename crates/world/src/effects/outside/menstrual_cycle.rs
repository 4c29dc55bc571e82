//! The monthly cycle: weeks of lower insulin action.

use rand::{Rng, RngExt};

use super::super::Condition;
use super::event::Event;
use crate::behaviour::Life;

/// Fall of the action through the luteal phase, as a logarithm: 20 %; insulin sensitivity falls by
/// about that in women with type 1 diabetes, in some by more and in some not at all (Brown et al.,
/// J Diabetes Sci Technol 2015;9:1192).
const FALL: f64 = 0.22;
/// Length of a cycle and of the phase of lower action, days.
const CYCLE: f64 = 28.0;
const PHASE: f64 = 12.0;

/// Phases of twelve days in 28, from a random day of the cycle on.
pub(super) fn events(life: &Life, rng: &mut (impl Rng + ?Sized)) -> Vec<Event> {
    let mut day = -rng.random_range(0.0..CYCLE);
    let mut phases = Vec::new();
    while day < life.calendar.days() as f64 {
        let from = life.calendar.signed_step(0, 24.0 * day);
        let size = rng.random_range(0.75..1.25);
        phases.push(Event { from, hours: 24.0 * PHASE, edge: 36.0, size });
        day += CYCLE;
    }
    phases
}

/// Lowers the action in the periphery and, by half, in the liver.
pub(super) fn act(condition: &mut Condition, strength: f64) {
    condition.action *= (-FALL * strength).exp();
    condition.liver_action *= (-0.5 * FALL * strength).exp();
}
