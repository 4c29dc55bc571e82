//! A stretch of time in which something acts.

use physiology::STEPS_PER_HOUR;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::behaviour::Life;
use crate::calendar::within;

/// A stretch with gradual onset and decay at its edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// First step; negative when that was before the record.
    pub from: i64,
    /// Length, h, edges included.
    pub hours: f64,
    /// Time of its onset, and of its decay, h.
    pub edge: f64,
    /// Size relative to the published one.
    pub size: f64,
}

impl Event {
    /// The steps of a record of `steps` steps within the event.
    #[must_use]
    pub fn steps(&self, steps: usize) -> std::ops::Range<usize> {
        let length = (self.hours * STEPS_PER_HOUR as f64).ceil() as i64;
        within(self.from..self.from + length, steps)
    }

    /// Its strength in a step: the size, less on the edges.
    #[must_use]
    pub fn course(&self, step: usize) -> f64 {
        let hours = (step as i64 - self.from) as f64 / STEPS_PER_HOUR as f64;
        let side = |hours: f64| {
            let x = if self.edge > 0.0 { (hours / self.edge).clamp(0.0, 1.0) } else { 1.0 };
            x * x * (3.0 - 2.0 * x)
        };
        self.size * side(hours) * side(self.hours - hours)
    }
}

/// An event with this probability and a size from 0.75 to 1.25, at a step and of a length in hours
/// that `when` draws. Every draw is made.
pub(super) fn perhaps(
    chance: f64,
    edge: f64,
    rng: &mut ChaCha8Rng,
    when: impl FnOnce(&mut ChaCha8Rng) -> (i64, f64),
) -> Option<Event> {
    let (draw, size) = (rng.random::<f64>(), rng.random_range(0.75..1.25));
    let (from, hours) = when(rng);
    (draw < chance).then_some(Event { from, hours, edge, size })
}

/// Draws at most one event a day, with probability `chance`, at a clock hour within `hours` (may
/// pass midnight) and of a length within `lengths`.
pub(super) fn on_some_days(
    life: &Life,
    chance: f64,
    hours: (f64, f64),
    lengths: (f64, f64),
    edge: f64,
    rng: &mut ChaCha8Rng,
) -> Vec<Event> {
    let on_day = |day| {
        perhaps(chance, edge, rng, |rng| {
            let from = life.calendar.signed_step(day, rng.random_range(hours.0..hours.1));
            (from, rng.random_range(lengths.0..lengths.1))
        })
    };
    (0..life.calendar.days()).filter_map(on_day).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_event_begins_holds_and_ends() {
        let event = Event { from: -6, hours: 4.0, edge: 1.0, size: 2.0 };
        assert_eq!(event.steps(100), 0..42);
        assert_eq!(event.steps(20), 0..20);
        assert_eq!(event.course(0), 1.0); // half an hour in: the middle of the edge
        assert_eq!(event.course(18), 2.0);
        assert_eq!(event.course(36), 1.0);
        assert_eq!(event.course(42), 0.0);
        let sharp = Event { edge: 0.0, ..event };
        assert_eq!(sharp.course(0), 2.0);
    }
}
