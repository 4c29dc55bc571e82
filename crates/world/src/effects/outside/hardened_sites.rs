//! Sets in hardened tissue, from which less insulin arrives.

use physiology::STEPS_PER_HOUR;
use rand::{Rng, RngExt};

use super::super::Condition;
use super::event::Event;
use crate::behaviour::Life;

/// Loss, as a logarithm: 22 %, as after injections into lipohypertrophic tissue (Famulla et al.,
/// Diabetes Care 2016;39:1486).
const LOSS: f64 = 0.25;
/// Share of sets at such sites (assumed).
const SHARE: f64 = 0.3;

/// For as long as such a set is worn.
pub(super) fn events(life: &Life, rng: &mut (impl Rng + ?Sized)) -> Vec<Event> {
    let changes = life.sets.changes();
    let end = life.calendar.steps() as i64;
    let until = changes.iter().skip(1).copied().chain([end]);
    changes
        .iter()
        .zip(until)
        .filter_map(|(from, until)| {
            let (draw, size) = (rng.random::<f64>(), rng.random_range(0.75..1.25));
            let hours = (until - from) as f64 / STEPS_PER_HOUR as f64;
            (draw < SHARE).then_some(Event { from: *from, hours, edge: 0.0, size })
        })
        .collect()
}

/// Lets less insulin arrive.
pub(super) fn act(condition: &mut Condition, strength: f64) {
    condition.bioavailability *= (-LOSS * strength).exp();
}
