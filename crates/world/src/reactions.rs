//! Chance in how a person reacts to a reading.

use rand::{Rng, RngExt};

use crate::calendar::Calendar;

/// Uniform draws from 0 to 1 for one step, used or not.
///
/// Each is tied to its step. So a reaction that does not happen leaves the later ones unchanged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reaction {
    /// Whether a low reading is treated in this step.
    pub(crate) treat: f64,
    /// How much is eaten against it.
    pub(crate) treat_size: f64,
    /// Whether that is logged.
    pub(crate) treat_log: f64,
    /// Whether a high reading is corrected in this step.
    pub(crate) correct: f64,
    /// Whether something is eaten before exercise.
    pub(crate) snack: f64,
}

/// Draws the reactions of every step.
#[must_use]
pub(crate) fn reactions(calendar: &Calendar, rng: &mut (impl Rng + ?Sized)) -> Vec<Reaction> {
    (0..calendar.steps())
        .map(|_| Reaction {
            treat: rng.random(),
            treat_size: rng.random(),
            treat_log: rng.random(),
            correct: rng.random(),
            snack: rng.random(),
        })
        .collect()
}
