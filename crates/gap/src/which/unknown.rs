//! Events of no known effect: something happens at a port for some hours, and nothing in the library does
//! that there.
//!
//! They stand beside the library as rivals. Without them the effect that looks most like the events would be
//! named for them.

pub(super) mod bins;
mod body;
pub(super) mod courses;
mod sensor;

use effects::{
    Card, Course, Effect, EffectId, EventShape, Field, Form, Modulation, Port, Prior, Relations,
};
use physiology::STEPS_PER_HOUR;

/// Unexplained events at a port.
#[derive(Debug, Clone, Copy)]
pub(super) struct UnknownEvents {
    id: EffectId,
    port: Port,
    field: Field,
    /// What an event adds to the field; the opposite is tried too.
    change: f64,
    /// How long it may last.
    hours: &'static [usize],
}

/// Shares of an event in which it may rise.
const RISES: [f64; 2] = [0.3, 0.08];
/// Onsets are tried this many steps apart.
const APART: usize = 4;

/// Every kind of unexplained event.
fn kinds() -> impl Iterator<Item = UnknownEvents> {
    sensor::KINDS.into_iter().chain(body::KINDS)
}

/// Every kind of unexplained event, as effects.
pub(super) fn unknown_events() -> Vec<Box<dyn Effect>> {
    kinds().map(|kind| Box::new(kind) as Box<dyn Effect>).collect()
}

/// Whether a name is that of a kind of unexplained events.
pub(super) fn is_kind(name: &str) -> bool {
    kinds().any(|kind| kind.id.name() == name)
}

impl Effect for UnknownEvents {
    fn card(&self) -> Card {
        Card {
            id: self.id,
            port: self.port,
            summary: "something happens for some hours that no effect of the library does",
            size_at_one: "see the port",
            source: "none: a rival of the library",
            signature: "runs of errors at no particular time",
            channels: &[],
            confusable_with: &[],
            relations: Relations::USUAL,
            prior: Prior { median: 1.0, log_sd: 0.7, largest: 4.0 },
        }
    }

    fn form(&self, course: &Course) -> Option<Form> {
        // Fast up and slowly down, as most things that happen to a body are.
        let profile = |hours: usize, rise: f64| -> Vec<f64> {
            let length = hours * STEPS_PER_HOUR;
            (0..length)
                .map(|k| {
                    let share = (k as f64 + 0.5) / length as f64;
                    let x = if share < rise { share / rise } else { (1.0 - share) / (1.0 - rise) };
                    self.change * 0.5 * (1.0 - (std::f64::consts::PI * x).cos())
                })
                .collect()
        };
        let lengths = self.hours.iter();
        let profiles = lengths.flat_map(|h| RISES.map(|rise| profile(*h, rise))).collect();
        Some(Form::Events(EventShape {
            field: self.field,
            profiles,
            onsets: (0..course.len()).step_by(APART).collect(),
            per_day: 0.3,
            sizes: vec![(0.5, 0.35), (1.0, 0.35), (1.7, 0.2), (2.5, 0.1)],
        }))
    }

    fn modulate(&self, _: usize, _: f64, _: &Course, _: &mut [Modulation]) {}
}
