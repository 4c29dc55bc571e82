//! The two engines, their steps, and published networks.

mod engines;
mod polytopes;
mod proofs;
mod published;
mod steps;
mod weights;
