//! The library of effects that a glucose model may be missing.
//!
//! An effect is a *port* (a place in the model or the measurement), a *driver* (a time course known
//! from the record, or events hidden in it) and an *amplitude* that is 1 at the published size. Each
//! stands in its own file with its source, the channels that signal it, what it does to the residuals
//! and what it is easily mistaken for. The library is open: implement [`Effect`] and hand it to the
//! diagnosis beside [`library()`]; `examples/own_effect.rs` adds one. Its [`Relations`] say what a diagnosis allows for in
//! every body that is the effect itself.
//!
//! Three habits keep an effect from being named for another's gap. A driver that lasts for
//! many hours and is not about the clock is centred across days within the clock slot
//! ([`centre_within_clock_slots`]); one that follows a logged meal, a bout or a low for some hours is tied to
//! it and is not. One that looks at glucose looks at [`Course::glucose`], which is filtered, and never ahead. One
//! whose channel was recorded in less than a fifth of the steps has no [`Form`] for that person.
//!
//! Nothing here knows a model. A driver is written as a [`Modulation`] per five-minute step, and
//! whoever simulates decides what a port is in their equations.
//!
//! ```
//! use effects::{EffectId, Port, library};
//!
//! let dawn = library().into_iter().find(|e| e.card().id == EffectId::DAWN).expect("in the library");
//! assert_eq!(dawn.card().port, Port::Egp);
//! ```
//!
//! Research software. Not a medical device; not validated for any treatment decision.

mod activity;
mod card;
mod course;
mod effect;
mod effect_id;
mod library;
mod meals;
mod modulation;
mod overview;
mod port;
mod relations;
#[cfg(test)]
mod sample;
mod slot_centring;

pub use card::{Card, Channel, Prior};
pub use course::{Course, STEP_MINUTES};
pub use effect::{Effect, EventShape, Form, RandomUnit};
pub use effect_id::EffectId;
pub use library::{find, library, names};
pub use modulation::{FIELDS, Field, Modulation};
pub use overview::overview;
pub use port::Port;
pub use relations::{Allowance, Relations, ShownBy, Structure};
pub use slot_centring::centre_within_clock_slots;
