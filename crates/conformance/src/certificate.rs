//! Split trees that a checker can follow without the search that found them.

use std::collections::BTreeMap;

use contract::certificates::{Certificate, TreeNode};

use crate::bound::{Bounded, Search};
use crate::error::ConformanceError;
use crate::interior::point_inside;
use crate::network::OneHiddenLayer;
use crate::property::Property;
use crate::region::Region;
use crate::share::slope_sum;

/// The certificate that a slope against `property` is at most `claim`, in at most so many nodes; `None` if the search's own
/// splits do not show it in as many.
///
/// Splits follow from boxes alone, so that the tree is part of the one that found the claim. Where half-spaces bind the
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
    let boxed = region.box_of(network)?;
    let sum = slope_sum(network, property)?.within(&boxed, network.hidden());
    boxed.check_free(network, sum.tested)?;
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
