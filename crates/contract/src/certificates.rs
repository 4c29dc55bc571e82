//! `certificates.json`: proofs, as the prover writes them. Who checks them reads them by itself.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::conformance::Direction;
use crate::region::HalfSpace;

/// Certificates of one model over one region. Keys are in alphabetical order: the seal is made of the bytes.
#[apply(strict!)]
pub struct Certificates {
    /// The region: least and greatest value of each signal, scaled.
    pub bounds: BTreeMap<String, [f64; 2]>,
    /// One for each property that is proved.
    pub certificates: Vec<Certificate>,
    /// Half-spaces that cut pieces off the bounds, scaled.
    pub half_spaces: Vec<HalfSpace>,
    /// SHA-256 of the model file, hexadecimal.
    pub model_sha256: String,
    /// `certificate/2`.
    pub schema: String,
    /// SHA-256 of this file as compact JSON with sorted keys and without this entry, hexadecimal. Empty, and not
    /// written, before it is known.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sha256: String,
}

/// A proof that a slope against a property is at most `claim` over a region.
#[apply(strict!)]
pub struct Certificate {
    /// Upper bound, scaled output per minute per scaled input.
    pub claim: f64,
    /// The tested input.
    pub input: String,
    /// A point of the bounds strictly inside every half-space that speaks of the network's inputs alone, scaled, by
    /// input; absent if there is no such half-space.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inside: Option<BTreeMap<String, f64>>,
    /// Output name of the network.
    pub network: String,
    /// The direction asked for.
    pub property: Direction,
    /// Neurons that share a hyperplane, in groups of two or more; the first gives its side.
    pub together: Vec<Vec<usize>>,
    /// The tree in the order node, lower half, upper half.
    pub tree: Vec<TreeNode>,
}

/// A node of a certificate's tree.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(untagged, deny_unknown_fields)]
pub enum TreeNode {
    /// A box that is halved.
    Split {
        /// The value at which, scaled.
        at: f64,
        /// The input across which.
        split: String,
    },
    /// A box whose bound is at most the claim.
    Leaf {
        /// Pairs of neurons, each the first of its group, whose hopes exclude each other, and the input whose weight vanishes
        /// in the combination that shows it.
        apart: Vec<(usize, usize, String)>,
    },
}
