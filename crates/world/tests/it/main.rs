//! Worlds whose effects are known.

mod balance;
mod bodies;
mod determinism;
mod effects;
mod embedded_fixture;
mod planted;
mod plausibility;
mod switches;
mod therapy;
mod true_gap;
mod two_bodies;
