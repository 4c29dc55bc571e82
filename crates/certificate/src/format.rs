//! The file: `certificates.json`.

use std::collections::BTreeMap;

use serde::Deserialize;
use sha2::{Digest as _, Sha256};

use crate::Rejection;

const SCHEMA: &str = "certificate/2";
const SEAL: &str = "sha256";

/// Certificates of one model over one box.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificates {
    /// `certificate/2`.
    pub schema: String,
    /// SHA-256 of the model file, hexadecimal.
    pub model_sha256: String,
    /// The box: least and greatest value of each signal, scaled.
    pub bounds: BTreeMap<String, [f64; 2]>,
    /// Half-spaces that cut pieces off the box. A network is bound by those of them that speak of its inputs alone.
    #[serde(default)]
    pub half_spaces: Vec<HalfSpace>,
    /// One for each property that is proved.
    pub certificates: Vec<Certificate>,
    /// SHA-256 of this file as compact JSON with sorted keys and without this entry, hexadecimal.
    pub sha256: String,
}

/// The points at which a weighted sum of signals is at most a number, scaled.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HalfSpace {
    /// Weight of each signal.
    pub weights: BTreeMap<String, f64>,
    /// The largest value of the sum.
    pub at_most: f64,
}

/// A claim about one sub-network and its proof.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// The sub-network, by its output.
    pub network: String,
    /// The tested input.
    pub input: String,
    /// A point of the box strictly inside every half-space that binds the network, by input. Where one does, the proof
    /// needs the point; else nobody looks at it.
    #[serde(default)]
    pub inside: Option<BTreeMap<String, f64>>,
    /// "decreasing" or "increasing".
    pub property: String,
    /// Upper bound on the slope against the property over the box, scaled output per minute per scaled input.
    pub claim: f64,
    /// Neurons that share a hyperplane, in groups of two or more. A neuron in none stands alone.
    pub together: Vec<Vec<usize>>,
    /// The tree in the order node, lower half, upper half.
    pub tree: Vec<Node>,
}

/// A node of a tree of boxes.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
pub enum Node {
    /// A box that is halved.
    Split {
        /// The input across which.
        split: String,
        /// The value at which, scaled.
        at: f64,
    },
    /// A box that is decided.
    Leaf {
        /// Pairs of neurons, each the first of its group, or of half-spaces, numbered after the neurons, whose hopes
        /// exclude each other here, and the input whose weight vanishes in the combination that shows it.
        apart: Vec<(usize, usize, String)>,
    },
}

impl Certificates {
    /// Reads certificates and checks their seal.
    ///
    /// # Errors
    /// [`Rejection::Form`], [`Rejection::Schema`], [`Rejection::Seal`].
    pub fn read(bytes: &[u8]) -> Result<Self, Rejection> {
        let mut value: serde_json::Value =
            serde_json::from_slice(bytes).map_err(Rejection::Form)?;
        let read: Self = serde_json::from_value(value.clone()).map_err(Rejection::Form)?;
        if read.schema != SCHEMA {
            return Err(Rejection::Schema(read.schema));
        }
        if let Some(object) = value.as_object_mut() {
            object.remove(SEAL);
        }
        let found = hexadecimal(&serde_json::to_vec(&value).map_err(Rejection::Form)?);
        if found != read.sha256 {
            return Err(Rejection::Seal { found, sealed: read.sha256 });
        }
        Ok(read)
    }
}

/// SHA-256 of bytes in hexadecimal.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
