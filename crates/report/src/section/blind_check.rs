//! The blind check: what was promised, what was found, and every world.

pub(super) mod ceiling;
pub(super) mod confusion;
pub(super) mod power;
pub(super) mod reliability;
pub(super) mod scores;
pub(super) mod targets;
pub(super) mod worlds;
