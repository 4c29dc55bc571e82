//! The blind check: what was promised, what was found, and every world.

mod ceiling;
mod confusion;
mod power;
mod reliability;
mod scores;
mod targets;
mod worlds;

pub(super) use ceiling::body as ceiling;
pub(super) use confusion::body as confusion;
pub(super) use power::body as power;
pub(super) use reliability::body as reliability;
pub(super) use scores::body as scores;
pub(super) use targets::body as targets;
pub(super) use worlds::body as worlds;
