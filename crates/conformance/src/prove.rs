//! From bounds to proofs: a certificate for each row whose bound is not above 0, checked by another program.

use std::collections::BTreeMap;

use contract::certificates::{Certificate, Certificates, TreeNode};
use contract::conformance::{Direction, Grounds, Row, Verdict};
use contract::{Document as _, RegionFile};
use sha2::{Digest as _, Sha256};

use crate::bound::{Bounded, Search};
use crate::error::ConformanceError;
use crate::interior::point_inside;
use crate::network::OneHiddenLayer;
use crate::property::Property;
use crate::region::Region;
use crate::slope::SlopeSum;

/// Boxes of a certificate after which a row counts as undecided; three hundred bytes each.
const MOST_NODES: usize = 1_000_000;

/// A claim that the checker accepted.
#[derive(Debug, Clone, PartialEq)]
pub struct AcceptedClaim {
    /// Output name of the network.
    pub network: String,
    /// The tested input.
    pub input: String,
    /// The property.
    pub property: Direction,
    /// Upper bound on the slope against the property, scaled output per minute per scaled input.
    pub claim: f64,
}

/// The certificates, and how many the checker accepted.
#[derive(Debug, Clone, PartialEq)]
pub struct Proofs {
    /// The file `certificates.json`, described in the crate `certificate`.
    pub file: Vec<u8>,
    /// Certificates that were accepted.
    pub accepted: usize,
}

/// The certificate that a slope against `property` is at most `claim`, in at most so many nodes; `None` if the search's own
/// splits do not show it in as many.
///
/// A checker can follow the tree of splits without the search that found it. Splits follow from
/// boxes alone, so that the tree is part of the one that found the claim. Where half-spaces bind the
/// network, a point strictly inside of them shows that the region has an inside.
///
/// # Errors
/// What [`verify()`](crate::verify()) refuses.
pub fn certify(
    network: &OneHiddenLayer,
    property: &Property,
    region: &Region,
    claim: f64,
    nodes: usize,
) -> Result<Option<Certificate>, ConformanceError> {
    let (boxed, tested) = property.box_in(network, region)?;
    let sum = SlopeSum::new(network, tested, property.direction).within(&boxed);
    let inside: Option<BTreeMap<String, f64>> = point_inside(network, &sum, &boxed)?
        .map(|point| network.inputs().iter().cloned().zip(point).collect());
    let search = Search::new(&sum, &boxed);
    let name = |input: usize| network.inputs()[input].clone();
    let mut tree = Vec::new();
    let mut open = vec![search.whole(&boxed, claim)];
    while let Some(Bounded { node, pairs, .. }) = open.pop() {
        if tree.len() == nodes {
            return Ok(None);
        }
        if node.upper <= claim {
            let undecided: Vec<usize> = node.undecided().collect();
            let first = |place: usize| search.rest.switches[undecided[place]].neurons[0];
            let apart = pairs.iter().map(|p| (first(p.first), first(p.second), name(p.bend)));
            tree.push(TreeNode::Leaf { apart: apart.collect() });
            continue;
        }
        let (Some((axis, at)), Some([below, above])) = (node.cut(), search.children(&node, claim))
        else {
            return Ok(None);
        };
        tree.push(TreeNode::Split { split: name(axis), at });
        // The lower half comes next.
        open.extend([above, below]);
    }
    Ok(Some(Certificate {
        network: property.network.clone(),
        input: property.input.clone(),
        property: property.direction,
        claim,
        inside,
        together: sum.together,
        tree,
    }))
}

/// Writes a certificate for each row that is proved by its bound, and has them checked against the bytes of the
/// model file. A row is proved by [`Grounds::Certificate`] afterwards, or undecided. Where the row's bound takes too
/// many boxes, the certificate claims no more than the property: a slope of at most 0.
///
/// `check` is the program that reads the file of certificates beside the model file; it shares no code with this
/// crate. `rows` and `of` are in one order.
///
/// # Errors
/// Those of [`certify`], and [`ConformanceError::Rejected`] where `check` refuses the file.
pub fn prove(
    rows: &mut [Row],
    of: &[(&OneHiddenLayer, &Property)],
    region: &Region,
    model: &[u8],
    check: impl FnOnce(&[u8]) -> Result<Vec<AcceptedClaim>, String>,
) -> Result<Proofs, ConformanceError> {
    let mut found: Vec<Certificate> = Vec::new();
    for (row, (network, property)) in rows.iter_mut().zip(of) {
        if row.grounds != Some(Grounds::Bound) {
            continue;
        }
        let of_claim = |claim: f64| certify(network, property, region, claim, MOST_NODES);
        if let Some(certificate) = first_of([row.m_upper, 0.0], of_claim)? {
            row.m_upper = certificate.claim;
            found.push(certificate);
        } else {
            (row.verdict, row.grounds) = (Verdict::Undecided, None);
        }
    }
    let file = sealed(found, model, region);
    let accepted = check(&file).map_err(|reason| ConformanceError::Rejected { reason })?;
    for row in rows.iter_mut().filter(|row| row.grounds == Some(Grounds::Bound)) {
        let is_accepted = accepted.iter().any(|claim| {
            claim.network == row.network
                && claim.input == row.input
                && claim.property == row.property
                && claim.claim == row.m_upper
        });
        (row.verdict, row.grounds) = if is_accepted {
            (Verdict::Proved, Some(Grounds::Certificate))
        } else {
            (Verdict::Undecided, None)
        };
    }
    Ok(Proofs { file, accepted: accepted.len() })
}

/// The certificate of the first claim that has one.
fn first_of<E>(
    claims: [f64; 2],
    of_claim: impl Fn(f64) -> Result<Option<Certificate>, E>,
) -> Result<Option<Certificate>, E> {
    claims.into_iter().find_map(|claim| of_claim(claim).transpose()).transpose()
}

fn sealed(certificates: Vec<Certificate>, model: &[u8], region: &Region) -> Vec<u8> {
    let RegionFile { bounds, half_spaces, .. } = region.file();
    let mut file = Certificates {
        bounds,
        certificates,
        half_spaces,
        model_sha256: hexadecimal(&Sha256::digest(model)),
        schema: Certificates::SCHEMA.to_owned(),
        sha256: String::new(),
    };
    let bytes = |file: &Certificates| serde_json::to_vec(file).expect("numbers, names and lists");
    file.sha256 = hexadecimal(&Sha256::digest(bytes(&file)));
    bytes(&file)
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use contract::conformance::PropertyKind;

    #[test]
    fn where_a_bound_takes_too_many_boxes_the_property_alone_is_claimed() {
        // -a for a from 0 on: its slope is -1.
        let names = vec!["a".to_owned()];
        let network = OneHiddenLayer::new("y", names, vec![1.0], vec![0.0], vec![-1.0], 0.0)
            .expect("shapes fit");
        let region = Region::scaled([("a", [0.0, 1.0])]).expect("a box");
        let property = Property {
            network: "y".to_owned(),
            input: "a".to_owned(),
            direction: Direction::Decreasing,
            kind: PropertyKind::Physical,
        };
        let claimed = |bound: f64| {
            let of_claim = |claim| certify(&network, &property, &region, claim, 100);
            first_of([bound, 0.0], of_claim).expect("a box").map(|certificate| certificate.claim)
        };
        assert_eq!(claimed(-1.0), Some(-1.0));
        assert_eq!(claimed(-1.5), Some(0.0)); // as if -1.5 took more boxes than there are
    }
}
