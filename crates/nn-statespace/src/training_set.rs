//! Training data at the size of the paper: millions of overlapping windows over tens of thousands
//! of simulated weeks, each row stored once.
//!
//! Runs are kept in single precision ([`CompactRun`]: 48 bytes a step), the scaler is fitted to
//! them by counting ([`CoarseCounts`], then [`FineCounts`]), exactly and without sorting, and
//! [`WindowSet`] scales them where they lie and hands out windows by index.

mod compact_run;
mod rank_counts;
mod window_store;

pub use compact_run::CompactRun;
pub use rank_counts::{CoarseCounts, FineCounts};
pub use window_store::WindowSet;
