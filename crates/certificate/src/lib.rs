//! Whether a certificate proves what it claims: that a sub-network of a model file moves in one direction only with one of
//! its inputs, over a box.
//!
//! This crate is the small half of a proof. The large half, which searches, is `conformance`; nothing of it is used here, and
//! nothing here is used there. Who trusts the few hundred lines of this crate, and the libraries for integers, JSON,
//! safetensors and SHA-256, need not trust the search.
//!
//! ```
//! // `verify` writes certificates.json beside conformance.json; the program `check-certificates` reads it as here.
//! let changed = br#"{"schema": "certificate/2", "model_sha256": "", "bounds": {}, "certificates": [], "sha256": "0"}"#;
//! let refused = certificate::check(changed, b"the bytes of the model file");
//! assert!(refused.is_err(), "the seal does not fit");
//! ```
//!
//! # What is claimed
//! A sub-network is `N(x) = b2 + sum of v_j max(0, a_j(x))`, `a_j(x) = w_j x + b_j`. With s = +1 for "decreasing" and -1 for
//! "increasing" and the tested input k, the slope against the property where no `a_j` is 0 is the sum of
//! `c_j = s v_j w_jk` over the neurons with `a_j > 0`. A certificate claims that it is at most `claim` in the box, everywhere.
//! `claim <= 0` proves the property: N is continuous and piecewise linear.
//!
//! # What is checked, in integers, without any rounding
//! 1. The seal: SHA-256 of the certificates as JSON without it, and SHA-256 of the model file.
//! 2. Neurons said to share a hyperplane do. They then switch together, and `|a| = max(0, a) + max(0, -a)` costs one
//!    switch.
//! 3. The tree: each split lies strictly inside of its box, so that its halves cover it; the leaves cover the box, none is
//!    missing, none is left over.
//! 4. Each leaf. A switch whose least value over the leaf is not below 0 is on there, one whose greatest value is not above 0
//!    is off; of the others those with positive gain are counted. Two of them that a leaf names are *apart*: no point
//!    of the leaf is on the hoped-for side of both, which a combination of the two shows that is negative on
//!    the whole leaf (Farkas). One of the two hopes then fails. The sum is at most the claim.
//!
//! **Half-spaces** may cut pieces off the box. Each is a switch too, on outside of it, with a negative gain beyond everything
//! else: what is claimed of the slope less that number, over the whole box, is claimed of the slope strictly inside them
//! all. Of a region without an inside that would be true whatever the claim. Where half-spaces bind the network, the
//! certificate therefore names a point of the box, and the checker finds it strictly inside each of them. One is enough:
//! the region is convex and N is continuous, so that every step on its boundary is a limit of steps in the same
//! direction strictly inside, those moved a little towards that point.
//!
//! A switch with `a = 0` on a face of a leaf is counted on one side only. That is enough: such points are limits of
//! points inside, on whose linear pieces the slope is one that was counted.

mod check;
mod format;
mod grid;
mod model;

pub use check::{Accepted, check};
pub use format::{Certificate, Certificates, HalfSpace, Node};
pub use model::Network;

/// Why certificates are not accepted.
#[derive(Debug, thiserror::Error)]
pub enum Rejection {
    /// The certificates are not JSON of the expected form.
    #[error("the certificates are not of the form certificate/2")]
    Form(#[source] serde_json::Error),
    /// The certificates are of another schema.
    #[error("the certificates are of schema '{0}'; this program checks certificate/2")]
    Schema(String),
    /// The seal does not fit the certificates.
    #[error(
        "the certificates were changed after they were sealed: SHA-256 {found}, sealed as {sealed}"
    )]
    Seal {
        /// Of the certificates as they are.
        found: String,
        /// What they say.
        sealed: String,
    },
    /// The certificates are of another model file.
    #[error("the certificates are of another model: its SHA-256 is {found}, they name {named}")]
    OtherModel {
        /// Of the model file.
        found: String,
        /// What the certificates say.
        named: String,
    },
    /// The model file cannot be read.
    #[error("the model file: {0}")]
    Model(String),
    /// A certificate proves nothing.
    #[error("{network} {property} in {input}: {reason}")]
    Unproved {
        /// The sub-network.
        network: String,
        /// The tested input.
        input: String,
        /// "decreasing" or "increasing".
        property: String,
        /// What does not hold, and where.
        reason: String,
    },
}
