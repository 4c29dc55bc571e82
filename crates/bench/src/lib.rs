//! Benchmarks: how fast diagnosis, training and twins are, and how well meals are found.
//!
//! - [`diagnosis`]: how time and memory grow with the cohort;
//! - [`training_step`]: one update of the population network, beside candle and PyTorch;
//! - [`twin_speed`]: training and running of twins, beside PyTorch;
//! - [`meal_detection`]: detectors and rules for logs against worlds whose truth is known.
//!
//! Each writes `bench.json` and `bench.txt` into a folder, as a stage of `pipeline` does. Times are of the clock: they hold
//! for the machine and the load of the moment.
//!
//! ```
//! use bench::diagnosis::{Settings, run};
//!
//! pipeline::be_quiet();
//! let folder = tempfile::tempdir()?;
//! let (effect, out) = ("none".to_owned(), folder.path().join("bench"));
//! run(&Settings { people: 2, days: 7, effect, amplitude: 0.0, out: out.clone(), seed: 1 })?;
//! assert!(std::fs::read_to_string(out.join("bench.txt"))?.contains("person-days a second"));
//! # anyhow::Ok(())
//! ```

pub mod diagnosis;
pub mod meal_detection;
mod peer;
pub mod training_step;
pub mod twin_speed;
