//! The blind check: labels sealed by a hash, answers scored against them.
//!
//! Worlds with known effects are made, their labels hidden, and a diagnosis is asked what it finds.
//! This crate holds the two parts that keep such a check honest and that need to know neither the
//! worlds nor the diagnosis: the [seal] that protects the labels until every answer is written, and
//! the [score](score()) of answers against labels.
//!
//! ```
//! use blind::{ScoredWorld, score};
//! use contract::blind_check::{Answer, Label};
//!
//! let label = Label::null("world_0001", "hovorka", "aid", 5, 14);
//! let answer = Answer::none();
//! let check = score(1, &[ScoredWorld { label, answer }])?;
//! assert_eq!(check.false_alarms.count, 0);
//! # Ok::<(), blind::BlindError>(())
//! ```
//!
//! Everything is counted per world. Proportions have exact (Clopper-Pearson) and score (Wilson)
//! intervals; other figures have bootstrap intervals over worlds.

mod amplitude;
mod answer;
mod by_hand;
mod ceiling;
mod check;
mod confusion;
mod error;
mod localisation;
mod outcome;
mod pairs;
#[cfg(test)]
mod planted;
mod power;
mod real_people;
pub mod realism;
mod reliability;
mod scored_world;
mod share;
mod targets;
mod text_table;
mod true_where;
mod unknown;

pub mod seal;

pub use answer::answer;
pub use by_hand::hand_table;
pub use ceiling::with_ceiling;
pub use check::score;
pub use error::BlindError;
pub use localisation::world_where;
pub use outcome::outcome;
pub use power::SHIFT_BINS;
pub use real_people::{
    AnsweredCohort, NOTHING, RISEN_NATS, TELLABLE_NATS, calibrated_people, planted_check,
};
pub use scored_world::ScoredWorld;
pub use true_where::{
    ABOVE_MEAN, HORIZONS, OF_BEST, OF_BEST_CONTEXT, RARE, has_hot_place, is_hot, mean_at,
};
