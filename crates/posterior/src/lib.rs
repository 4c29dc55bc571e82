//! Probabilities of what a cohort lacks, learned on worlds whose truth is known.
//!
//! A [`Posterior`] reads the statistics of a cohort by name and answers with probabilities of nothing, something
//! unknown, every effect, and the likeliest sets of effects. It is an ensemble of small networks and of logistic
//! regressions on few statistics each, trained on a [`Table`] of made worlds ([`train`]): amortised model comparison (Radev et al., IEEE Trans Neural Netw Learn Syst
//! 2023;34:4903; Elsemueller et al., Psychol Methods 2024). What it saw is in its [`PosteriorCard`].
//!
//! Nothing here knows a plant or a filter: a downstream tool can train a posterior on statistics of its own.
//!
//! ```
//! use std::collections::BTreeMap;
//!
//! use posterior::Posterior;
//!
//! let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../gap/posterior/working.safetensors");
//! let posterior = Posterior::from_bytes(&std::fs::read(file)?)?;
//! // Of a cohort of which nothing could be read, little is known.
//! let answer = posterior.answer(&BTreeMap::new())?;
//! assert!(answer.effects.iter().all(|(_, p)| *p < 0.5));
//! assert!(posterior.effects().iter().any(|effect| effect == "dawn"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Research software. Not a medical device; not validated for any treatment decision.

mod any_number;
mod error;
mod joint;
mod network;
mod posterior;
mod reading;
mod regression;
mod table;
mod training;

pub use contract::posterior::PosteriorCard;
pub use error::PosteriorError;
pub use posterior::{Answer, Gap, Posterior};
pub use table::{Table, Truth};
pub use training::{Training, train};
