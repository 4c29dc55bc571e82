//! The blind check: labels sealed by a hash, answers scored against them.
//!
//! Worlds with known effects are made, their labels hidden, and a diagnosis is asked for what it
//! can find. This crate holds the two parts that keep such a check honest and that need to know
//! neither the worlds nor the diagnosis: the [seal] under which labels lie until every answer is
//! written, and the [score](BlindCheck::score) of answers against labels.
//!
//! ```
//! use blind::{Answer, BlindCheck, Label, ScoredWorld};
//!
//! let label = Label::null("world_0001", "hovorka", "aid", 5, 14);
//! let answer = Answer::none();
//! let check = BlindCheck::score(1, &[ScoredWorld { label, answer }])?;
//! assert_eq!(check.false_alarms.count, 0);
//! # Ok::<(), blind::BlindError>(())
//! ```
//!
//! Everything is counted per world. Proportions carry exact (Clopper-Pearson) and score (Wilson)
//! intervals; figures that are no proportions carry bootstrap intervals over worlds.

mod amplitude;
mod answer;
mod by_hand;
mod calibration_table;
mod ceiling;
mod check;
mod confusion;
mod error;
mod label;
mod localisation;
mod outcome;
mod pairs;
#[cfg(test)]
mod planted;
mod power;
mod real_people;
pub mod realism;
mod reliability;
mod share;
mod targets;
mod text_table;
mod true_where;

pub mod seal;

pub use amplitude::AmplitudeRecovery;
pub use answer::{Amplitude, Answer, Candidate, CellGap, CoursePart, Found, PortEvidence, Verdict};
pub use by_hand::{HandRow, hand_table};
pub use calibration_table::{CalibrationTable, CalibrationWorld};
pub use ceiling::{Ceiling, ExactCourse};
pub use check::{BlindCheck, ScoredWorld, UnknownScore, WorldRow};
pub use confusion::{Confusion, ConfusionRow};
pub use error::BlindError;
pub use label::{Kind, Label, TrueEffect};
pub use localisation::{ContextScore, CoverageScore, EquationScore, WhereScore, WorldWhere};
pub use outcome::Outcome;
pub use pairs::PairScore;
pub use power::{PowerRow, SHIFT_BINS};
pub use real_people::{
    AnsweredCohort, CalibratedPeople, EvidencePair, NOTHING, PLANTED_SCHEMA, PlantedCheck,
    PlantedLabel, PlantedRow, PlantedTotals, RISEN_NATS, TELLABLE_NATS,
};
pub use reliability::{Reliability, ReliabilityBin};
pub use seal::{OpenedLabel, Seal, SealedWorld};
pub use share::Share;
pub use targets::{Bound, Target};
pub use true_where::{
    ABOVE_MEAN, HORIZONS, OF_BEST, OF_BEST_CONTEXT, PortCourse, RARE, TrueCell, TrueWhere,
};
