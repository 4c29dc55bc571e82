//! One file a command. Each reads what it is given, calls the crates, and writes one folder.

pub mod check;
pub mod diagnose;
pub mod evaluate;
pub mod example_day;
pub mod fixture;
pub mod import;
pub mod import_model;
pub mod pipeline;
pub mod replay;
pub mod report;
pub mod simulate;
pub mod steady_state;
pub mod train;
pub mod twin;
pub mod verify;
