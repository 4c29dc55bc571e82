//! The fused roll-out: all ten networks, forwards through a batch of sequences and back, without a
//! graph.
//!
//! A step moves each state by `STEP (v . max(0, W x + b) + b2)`, which is linear in `x` while the
//! same hidden units are active. So the forward pass sums up, over active units, the slopes and the
//! offset of that linear piece; the state follows from them, and they are all that the backward pass
//! through the steps needs. Each weight then needs two sums over samples and steps alone, of `m g x`
//! and of `m g`, with the unit's activity `m` and the slope `g` of the loss by the step. Hidden units
//! are computed anew for these sums; nothing of their size is stored.
//!
//! Samples are lanes. A batch is cut into blocks that stay in a core's cache, and a block is one
//! task. Sums over blocks are taken in the order of the batch, so that the number of threads changes
//! no byte. The candle graph ([`crate::training::RollOut`]) is the oracle
//! that this is tested against; `docs/decisions/0017-the-roll-out-is-a-kernel-of-its-own.md` gives
//! reasons and figures.

mod backward;
mod block;
mod forward;
mod instructions;
mod lane_steps;
mod lanes;
mod layout;
mod portable;
mod real;
mod roll_out;
mod units;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use instructions::Instructions;
pub use lane_steps::{LANES, LaneSteps, Signals};
pub use layout::{NetworkSpan, ParameterLayout};
pub use real::Real;
pub use roll_out::{FusedRollOut, Sequence, StateLoss};
