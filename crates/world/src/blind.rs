//! Worlds for a blind check: their plan, the amplitudes that reach a given shift, and what is
//! missing from their records.
//!
//! A [`Plan`] says how many worlds there are of each kind; [`Plan::worlds`] draws them in an order
//! that reveals nothing. [`PlannedWorld::realise`] draws the people and finds the common factor on
//! an effect's amplitudes at which it moves glucose as far as planned, and lives the days. A
//! diagnosis gets [`LivedWorld::cohort`]; everything else is the label.
//!
//! ```no_run
//! use world::blind::Plan;
//!
//! for planned in Plan::check(28, 12).worlds(7) {
//!     let lived = planned.realise()?;
//!     println!("{}: {:?}", planned.seed, lived.world.effects);
//!     let cohort = lived.cohort();
//!     assert_eq!(cohort.people.len(), planned.people);
//! }
//! # Ok::<(), world::WorldError>(())
//! ```

mod amplitude_search;
mod exact_course;
mod nuisances;
mod plan;
mod planned_effect;
mod realised;
mod streams;
mod true_where;

pub use exact_course::ExactCourse;
pub use nuisances::Nuisances;
pub use plan::{DAYS, PEOPLE, Plan, PlannedWorld, Role, SHIFTS, Variation};
pub use planned_effect::PlannedEffect;
pub use realised::{LivedWorld, RealisedEffect, RealisedWorld};
pub use true_where::TrueWhere;
