//! Whether a network moves the way physiology says, over a whole region: proofs, not searches.
//!
//! The paper (Roquemen-Echeverri et al., section "Conformance Verification") compares two copies of
//! a sub-network in a mixed-integer programme and takes a failed search for a violation as
//! conformance. Here one number decides a row: **M**, the supremum over a box of the slope against
//! the property, `s dN/dx_k` with s = +1 for "decreasing" and -1 for "increasing". The output moves
//! against the property by at most `delta max(0, M)` when the input grows by `delta`, for every
//! `delta`; so M not above 0 is a proof.
//!
//! [`verify()`] brackets M by branch and bound with outward rounding, and replays its witness in exact
//! arithmetic. Beside it stand the gradient MILP through good_lp and HiGHS ([`milp`]), whose bounds
//! are reported as claims only, and the exact [`enumeration`](largest_slope_by_enumeration) of all
//! cells for networks of two inputs.
//!
//! [`certify`] writes a proof down for a checker of its own (the crate `certificate`), [`repair()`] changes a network until
//! every property is proved, [`milp::solve_step`] and [`step_bracket`] ask the paper's question of a step, and [`DeepNetwork`]
//! bounds slopes of several hidden layers as far as sound bounds reach.
//!
//! The crate is handed matrices; of the workspace it knows the types of its file alone.
//!
//! ```
//! use std::time::Duration;
//!
//! use conformance::{
//!     Direction, Limits, OneHiddenLayer, Property, PropertyKind, Region, Verdict, verify,
//! };
//!
//! // y = -2 max(0, x) falls with x wherever it moves.
//! let (weights, slopes) = (vec![1.0], vec![-2.0]);
//! let network = OneHiddenLayer::new("y", vec!["x".to_owned()], weights, vec![0.0], slopes, 0.0)?;
//! let property = Property {
//!     network: "y".to_owned(),
//!     input: "x".to_owned(),
//!     direction: Direction::Decreasing,
//!     kind: PropertyKind::Physical,
//! };
//! let region = Region::scaled([("x", [-1.0, 1.0])])?;
//! let time = Duration::from_secs(1);
//! let limits = Limits { relative_gap: 0.0, nodes: 1000, time, cross_check: None };
//! let row = verify(&network, &property, &region, &limits, &|| Duration::ZERO)?;
//! assert_eq!((row.verdict, row.m_upper), (Verdict::Proved, 0.0));
//! # Ok::<(), conformance::ConformanceError>(())
//! ```

mod bound;
mod branch;
mod cells;
mod change_cost;
mod deep;
mod error;
mod exact;
mod interior;
pub mod milp;
mod network;
mod property;
mod prove;
mod recorded;
mod region;
mod repair;
mod replay;
mod share;
mod slope;
mod verify;

pub use branch::Limits;
pub use cells::{Enumerated, largest_slope_by_enumeration};
pub use change_cost::ChangeCost;
pub use contract::certificates::{Certificate, TreeNode};
pub use contract::conformance::{Direction, Grounds, PropertyKind, Row, Stop, Verdict, Witness};
pub use contract::region::HalfSpace;
pub use deep::{DeepBracket, DeepLimits, DeepNetwork};
pub use error::ConformanceError;
pub use network::OneHiddenLayer;
pub use property::{Property, paper_properties};
pub use prove::{AcceptedClaim, Proofs, certify, prove};
pub use recorded::{SlopeBound, Summand, bounds_of_sum, extremes, verify_recorded};
pub use region::{BoxRegion, Region, Scaling, Signal};
pub use repair::{RepairRule, Repaired, repair};
pub use share::{share_of_points, share_of_region};
pub use verify::{step_bracket, verify, with_physical, with_slice, z_bound};
