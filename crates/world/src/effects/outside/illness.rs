//! An infection: days of low insulin action.

use rand::{Rng, RngExt};

use super::super::Condition;
use super::event::Event;
use crate::behaviour::Life;

/// Fall of the action, as a logarithm: 35 %. Acute infections with fever lowered the glucose that
/// insulin disposes of by half (Yki-Jarvinen et al., J Clin Endocrinol Metab 1989;69:317); these
/// are milder ones.
const FALL: f64 = 0.43;
/// Days of which one begins an illness; high, so that short records hold one.
const DAYS: f64 = 14.0;

/// Two to three days within each two weeks (assumed).
pub(super) fn events(life: &Life, rng: &mut (impl Rng + ?Sized)) -> Vec<Event> {
    let blocks = (life.calendar.days() as f64 / DAYS).ceil() as usize;
    (0..blocks)
        .map(|block| {
            let day = DAYS * block as f64 + rng.random_range(1.0..DAYS - 4.0);
            let from = life.calendar.signed_step(0, 24.0 * day);
            let (hours, size) = (rng.random_range(48.0..72.0), rng.random_range(0.75..1.25));
            Event { from, hours, edge: 8.0, size }
        })
        .collect()
}

/// Lowers the action in the periphery and, by half, in the liver.
pub(super) fn act(condition: &mut Condition, strength: f64) {
    condition.action *= (-FALL * strength).exp();
    condition.liver_action *= (-0.5 * FALL * strength).exp();
}
