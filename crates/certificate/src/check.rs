//! The check of one certificate after the other.

use std::collections::BTreeMap;

use num_bigint::BigInt;

use crate::Rejection;
use crate::format::{Certificate, Certificates, HalfSpace, Node, hexadecimal};
use crate::grid::{last_bit, whole};
use crate::model::Network;

/// A certificate that was found to prove its claim.
#[derive(Clone, Debug, PartialEq)]
pub struct Accepted {
    /// The sub-network.
    pub network: String,
    /// The tested input.
    pub input: String,
    /// "decreasing" or "increasing".
    pub property: String,
    /// Upper bound on the slope against the property; the property holds if it is not above 0.
    pub claim: f64,
    /// Where: the network's inputs with their bounds, scaled units.
    pub over: Vec<(String, [f64; 2])>,
    /// How many half-spaces cut pieces off that box.
    pub half_spaces: usize,
    /// Boxes that were looked at.
    pub leaves: usize,
}

/// Checks all certificates of a file against a model file.
///
/// # Errors
/// The first [`Rejection`].
pub fn check(certificates: &[u8], model: &[u8]) -> Result<Vec<Accepted>, Rejection> {
    let read = Certificates::read(certificates)?;
    let found = hexadecimal(model);
    if found != read.model_sha256 {
        return Err(Rejection::OtherModel { found, named: read.model_sha256 });
    }
    read.certificates
        .iter()
        .map(|certificate| {
            let network = Network::read(model, &certificate.network)?;
            let unproved = |reason| Rejection::Unproved {
                network: certificate.network.clone(),
                input: certificate.input.clone(),
                property: certificate.property.clone(),
                reason,
            };
            let leaves =
                prove(certificate, &network, &read.bounds, &read.half_spaces).map_err(unproved)?;
            let bounds = |input: &String| Some((input.clone(), *read.bounds.get(input)?));
            let half_spaces = cuts(&network, &read.half_spaces).map_err(unproved)?.len();
            Ok(Accepted {
                network: certificate.network.clone(),
                input: certificate.input.clone(),
                property: certificate.property.clone(),
                claim: certificate.claim,
                over: network.inputs.iter().filter_map(bounds).collect(),
                half_spaces,
                leaves,
            })
        })
        .collect()
}

/// A hyperplane and what crossing it to its positive side adds to the slope, in units of the grids.
struct Switch {
    /// The first of its neurons.
    neuron: usize,
    weights: Vec<BigInt>,
    bias: BigInt,
    gain: BigInt,
}

/// A box that is still to be looked at, with what is known of the box it comes from.
#[derive(Clone)]
struct Open {
    lower: Vec<BigInt>,
    upper: Vec<BigInt>,
    /// Constant and gains of switches that are on.
    settled: BigInt,
    /// Places of switches without a fixed state.
    undecided: Vec<usize>,
}

/// The number of leaves, or what does not hold.
fn prove(
    certificate: &Certificate,
    network: &Network,
    bounds: &BTreeMap<String, [f64; 2]>,
    half_spaces: &[HalfSpace],
) -> Result<usize, String> {
    let tested = place(network, &certificate.input)?;
    let against = match certificate.property.as_str() {
        "decreasing" => 1.0,
        "increasing" => -1.0,
        other => return Err(format!("there is no property '{other}'")),
    };
    let boxed: Vec<[f64; 2]> = network
        .inputs
        .iter()
        .map(|input| match bounds.get(input) {
            Some([lower, upper]) if lower.is_finite() && upper.is_finite() && lower <= upper => {
                Ok([*lower, *upper])
            }
            Some(_) => Err(format!("the bounds of '{input}' are no interval")),
            None => Err(format!("the box has no bounds for '{input}'")),
        })
        .collect::<Result<_, _>>()?;
    let has_room = boxed[tested][0] < boxed[tested][1];
    ensure(has_room, || format!("the box leaves '{}' no room to move", certificate.input))?;
    ensure(certificate.claim.is_finite(), || "the claim is not a finite number".to_owned())?;

    // Grids: of input weights, of coordinates, of output weights. Products lie on sums of exponents.
    let ats = certificate.tree.iter().filter_map(|node| match node {
        Node::Split { at, .. } => Some(*at),
        Node::Leaf { .. } => None,
    });
    let ats: Vec<f64> = ats.collect();
    let all_finite = ats.iter().all(|at| at.is_finite());
    ensure(all_finite, || "a split is not at a finite number".to_owned())?;
    let finest =
        |values: &mut dyn Iterator<Item = f64>| values.filter_map(last_bit).min().unwrap_or(0);
    let cuts = cuts(network, half_spaces)?;
    let inside = if cuts.is_empty() { Vec::new() } else { inside(certificate, network, &boxed)? };
    let of_cuts = cuts.iter().flat_map(|(weights, _)| weights);
    let by_weight = finest(&mut network.weights.iter().flatten().chain(of_cuts).copied());
    let ends = cuts.iter().map(|(_, at_most)| at_most);
    let by_bias = finest(&mut network.biases.iter().chain(ends).copied());
    let points = boxed.iter().flatten().chain(&ats).chain(&inside);
    let by_point = finest(&mut points.copied()).min(by_bias - by_weight);
    let by_claim = finest(&mut std::iter::once(certificate.claim));
    let by_output = finest(&mut network.output.iter().copied()).min(by_claim - by_weight);

    let (constant, mut switches) =
        switches(certificate, network, tested, against, [by_weight, by_point, by_output])?;
    let claim = whole(certificate.claim, by_weight + by_output);
    // Beyond everything that could make up for it.
    let gains = switches.iter().map(|switch| size(&switch.gain));
    let outside = gains.sum::<BigInt>() + size(&constant) + size(&claim) + 1;
    let coordinate = |value: f64| whole(value, by_point);
    let inside: Vec<BigInt> = inside.iter().map(|value| coordinate(*value)).collect();
    for (number, (weights, at_most)) in cuts.iter().enumerate() {
        let switch = Switch {
            neuron: network.biases.len() + number,
            weights: weights.iter().map(|weight| whole(*weight, by_weight)).collect(),
            bias: whole(-at_most, by_weight + by_point),
            gain: -&outside,
        };
        ensure(value_at(&switch, &inside) < BigInt::ZERO, || {
            format!(
                "the point inside is not strictly inside half-space {number} of those that bind"
            )
        })?;
        switches.push(switch);
    }
    let mut open = vec![Open {
        lower: boxed.iter().map(|ends| coordinate(ends[0])).collect(),
        upper: boxed.iter().map(|ends| coordinate(ends[1])).collect(),
        settled: constant,
        undecided: (0..switches.len()).collect(),
    }];
    let mut leaves = 0;
    for (number, node) in certificate.tree.iter().enumerate() {
        let Some(parent) = open.pop() else {
            return Err(format!("node {number} and what follows belong to no box"));
        };
        let known = settle(parent, &switches);
        match node {
            Node::Split { split, at } => {
                let axis = place(network, split)?;
                let at = coordinate(*at);
                let is_within = known.lower[axis] < at && at < known.upper[axis];
                ensure(is_within, || format!("node {number} is split outside of its box"))?;
                let (mut above, mut below) = (known.clone(), known);
                above.lower[axis] = at.clone();
                below.upper[axis] = at;
                // The lower half comes next.
                open.extend([above, below]);
            }
            Node::Leaf { apart } => {
                leaves += 1;
                let bound = bound(apart, &known, &switches, network)
                    .map_err(|reason| format!("node {number}: {reason}"))?;
                ensure(bound <= claim, || {
                    format!("node {number}: its bound is above the claim of {}", certificate.claim)
                })?;
            }
        }
    }
    ensure(open.is_empty(), || format!("{} boxes have no leaf", open.len()))?;
    Ok(leaves)
}

/// Weights of the network's inputs and largest sums of the half-spaces that speak of its inputs alone.
fn cuts(network: &Network, half_spaces: &[HalfSpace]) -> Result<Vec<(Vec<f64>, f64)>, String> {
    let mut cuts = Vec::new();
    'half_spaces: for (number, HalfSpace { weights, at_most }) in half_spaces.iter().enumerate() {
        let all_finite = weights.values().chain([at_most]).all(|value| value.is_finite());
        ensure(all_finite, || format!("half-space {number} holds what is not a finite number"))?;
        let mut row = vec![0.0; network.inputs.len()];
        for (name, weight) in weights.iter().filter(|(_, weight)| **weight != 0.0) {
            let Ok(place) = place(network, name) else { continue 'half_spaces };
            row[place] = *weight;
        }
        cuts.push((row, *at_most));
    }
    Ok(cuts)
}

/// The point that shows that a region cut out by half-spaces has an inside, in the order of the inputs; within the box.
fn inside(
    certificate: &Certificate,
    network: &Network,
    boxed: &[[f64; 2]],
) -> Result<Vec<f64>, String> {
    let Some(named) = &certificate.inside else {
        return Err("half-spaces bind the network, and no point inside them is named".to_owned());
    };
    if let Some(other) = named.keys().find(|name| !network.inputs.contains(name)) {
        return Err(format!("the point inside names '{other}', which is no input"));
    }
    let mut point = Vec::with_capacity(boxed.len());
    for (input, [lower, upper]) in network.inputs.iter().zip(boxed) {
        let Some(value) = named.get(input) else {
            return Err(format!("the point inside has no value of '{input}'"));
        };
        let is_within = (*lower..=*upper).contains(value);
        ensure(is_within, || format!("the point inside is outside of the box by '{input}'"))?;
        point.push(*value);
    }
    Ok(point)
}

/// What a switch sees at a point.
fn value_at(switch: &Switch, point: &[BigInt]) -> BigInt {
    let products = switch.weights.iter().zip(point).map(|(weight, coordinate)| weight * coordinate);
    products.sum::<BigInt>() + &switch.bias
}

/// The slope's constant and its switches, one for each group of neurons.
fn switches(
    certificate: &Certificate,
    network: &Network,
    tested: usize,
    against: f64,
    [by_weight, by_point, by_output]: [i64; 3],
) -> Result<(BigInt, Vec<Switch>), String> {
    let hidden = network.biases.len();
    let mut grouped = vec![false; hidden];
    for &neuron in certificate.together.iter().flatten() {
        match grouped.get_mut(neuron) {
            None => return Err(format!("there is no neuron {neuron}")),
            Some(true) => return Err(format!("neuron {neuron} is in two groups")),
            Some(free) => *free = true,
        }
    }
    let alone = (0..hidden).filter(|neuron| !grouped[*neuron]).map(|neuron| vec![neuron]);
    let of = |neuron: usize| -> Vec<BigInt> {
        let weights = network.weights[neuron].iter().map(|w| whole(*w, by_weight));
        weights.chain([whole(network.biases[neuron], by_weight + by_point)]).collect()
    };
    let mut constant = BigInt::ZERO;
    let mut found = Vec::new();
    for group in certificate.together.iter().cloned().chain(alone) {
        let Some(&first) = group.first() else {
            return Err("a group has no neuron".to_owned());
        };
        let mut row = of(first);
        if row[tested] == BigInt::ZERO {
            ensure(group.len() == 1, || format!("neuron {first} does not see the tested input"))?;
            continue;
        }
        let mut gain = BigInt::ZERO;
        for &neuron in &group {
            let other = of(neuron);
            let same = row.iter().zip(&other).all(|(a, b)| a * &other[tested] == b * &row[tested]);
            ensure(same && other[tested] != BigInt::ZERO, || {
                format!("neurons {first} and {neuron} do not share a hyperplane")
            })?;
            let slope = &other[tested] * whole(against * network.output[neuron], by_output);
            if (row[tested] > BigInt::ZERO) == (other[tested] > BigInt::ZERO) {
                gain += slope;
            } else {
                // On where the first is off: always, less where the first is on.
                constant += &slope;
                gain -= slope;
            }
        }
        if gain != BigInt::ZERO {
            let bias = row.pop().expect("weights and a bias");
            found.push(Switch { neuron: first, weights: row, bias, gain });
        }
    }
    Ok((constant, found))
}

/// Takes switches that have one state over the box out of the undecided ones.
fn settle(mut known: Open, switches: &[Switch]) -> Open {
    let mut still = Vec::with_capacity(known.undecided.len());
    for place in known.undecided {
        let switch = &switches[place];
        let (mut least, mut greatest) = (switch.bias.clone(), switch.bias.clone());
        for (weight, (lower, upper)) in
            switch.weights.iter().zip(known.lower.iter().zip(&known.upper))
        {
            let (one, other) = (weight * lower, weight * upper);
            if *weight >= BigInt::ZERO {
                (least, greatest) = (least + one, greatest + other);
            } else {
                (least, greatest) = (least + other, greatest + one);
            }
        }
        if least >= BigInt::ZERO {
            known.settled += &switch.gain;
        } else if greatest > BigInt::ZERO {
            still.push(place);
        }
    }
    Open { undecided: still, ..known }
}

/// What the slope is at most in a leaf, which names pairs that are `apart` there.
fn bound(
    apart: &[(usize, usize, String)],
    known: &Open,
    switches: &[Switch],
    network: &Network,
) -> Result<BigInt, String> {
    let gains = known.undecided.iter().map(|place| &switches[*place].gain);
    let mut sum = &known.settled + gains.filter(|gain| **gain > BigInt::ZERO).sum::<BigInt>();
    let mut used = Vec::new();
    for (first, second, input) in apart {
        let find = |neuron: usize| {
            let mut places = known.undecided.iter();
            let place = places.find(|place| switches[**place].neuron == neuron);
            place.copied().ok_or_else(|| format!("neuron {neuron} leads no undecided group"))
        };
        let pair = [find(*first)?, find(*second)?];
        let is_new = pair[0] != pair[1] && pair.iter().all(|place| !used.contains(place));
        ensure(is_new, || format!("neuron {first} or {second} is counted twice"))?;
        used.extend(pair);
        let axis = self::place(network, input)?;
        let pair = pair.map(|place| &switches[place]);
        let are_apart = exclude_each_other(pair, axis, known);
        ensure(are_apart, || format!("neurons {first} and {second} are not apart"))?;
        // One of the two hopes fails: the one that costs less, at best.
        sum -= pair.map(|switch| size(&switch.gain)).into_iter().min().expect("two");
    }
    Ok(sum)
}

/// Whether a combination of two switches, each turned to its hoped-for side, without weight on `axis`, is negative in the
/// whole box.
fn exclude_each_other(pair: [&Switch; 2], axis: usize, known: &Open) -> bool {
    let turned = |switch: &Switch, value: &BigInt| {
        if switch.gain > BigInt::ZERO { value.clone() } else { -value }
    };
    let [one, other] = pair;
    let (a, b) = (turned(one, &one.weights[axis]), turned(other, &other.weights[axis]));
    if &a * &b >= BigInt::ZERO {
        return false;
    }
    let (by_one, by_other) = (size(&b), size(&a));
    let combined = |p: &BigInt, q: &BigInt| &by_one * turned(one, p) + &by_other * turned(other, q);
    let mut greatest = combined(&one.bias, &other.bias);
    for ((p, q), (lower, upper)) in
        one.weights.iter().zip(&other.weights).zip(known.lower.iter().zip(&known.upper))
    {
        let weight = combined(p, q);
        greatest += if weight >= BigInt::ZERO { &weight * upper } else { &weight * lower };
    }
    greatest < BigInt::ZERO
}

/// Refuses, for a reason, what does not hold.
fn ensure(holds: bool, reason: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(reason()) }
}

fn size(value: &BigInt) -> BigInt {
    BigInt::from(value.magnitude().clone())
}

fn place(network: &Network, input: &str) -> Result<usize, String> {
    let found = network.inputs.iter().position(|name| name == input);
    found.ok_or_else(|| format!("'{}' is no input", input))
}
