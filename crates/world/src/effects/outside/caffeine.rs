//! Coffee after getting up: insulin acts less in the periphery while the caffeine lasts.

use physiology::STEPS_PER_HOUR;
use rand::{Rng, RngExt};

use super::super::Condition;
use super::event::Event;
use crate::behaviour::Life;

/// Fall of the action, as a logarithm: 24 %. Caffeine of 5 mg/kg lowered the glucose disposal of a
/// clamp by that (Greer et al., Diabetes 2001;50:2349); two strong cups hold about as much.
const FALL: f64 = 0.27;
/// Share of the days that begin with coffee (assumed).
const SHARE: f64 = 0.9;
/// Hours in which it acts, half-lives of 3 to 7 h after a peak within the first hour (Blanchard &
/// Sawers, Eur J Clin Pharmacol 1983;24:93), and hours of its onset and decay.
const HOURS: (f64, f64) = (5.0, 8.0);
const EDGE: f64 = 1.0;

/// From a quarter to three quarters of an hour after waking, on nine days in ten. Every draw is
/// made.
pub(super) fn events(life: &Life, rng: &mut (impl Rng + ?Sized)) -> Vec<Event> {
    life.nights
        .iter()
        .filter_map(|night| {
            let (draw, size) = (rng.random::<f64>(), rng.random_range(0.75..1.25));
            let after = rng.random_range(0.25..0.75) * STEPS_PER_HOUR as f64;
            let hours = rng.random_range(HOURS.0..HOURS.1);
            let from = night.wake + after as i64;
            (draw < SHARE).then_some(Event { from, hours, edge: EDGE, size })
        })
        .collect()
}

/// Lowers the action in the periphery.
pub(super) fn act(condition: &mut Condition, strength: f64) {
    condition.action *= (-FALL * strength).exp();
}
