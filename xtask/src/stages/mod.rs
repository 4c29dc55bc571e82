//! One file a command. Each reads what it is given, calls the crates, and writes one folder.

pub(crate) mod bench;
pub(crate) mod blind_check;
pub(crate) mod check;
pub(crate) mod development_set;
pub(crate) mod diagnose;
pub(crate) mod evaluate;
pub(crate) mod example_day;
pub(crate) mod glucose_profile;
pub(crate) mod held_out;
pub(crate) mod import;
pub(crate) mod import_model;
pub(crate) mod pipeline;
pub(crate) mod repair;
pub(crate) mod replay;
pub(crate) mod report;
pub(crate) mod simulate;
pub(crate) mod steady_state;
pub(crate) mod train;
pub(crate) mod training_step;
pub(crate) mod trajectories;
pub(crate) mod twin;
pub(crate) mod verify;
pub(crate) mod verify_twin;
pub(crate) mod widths;
pub(crate) mod worlds;
