//! Networks that fail some properties, changed as little as it takes to have all of them.
//!
//! With the hidden layer as it is, the slope on every linear piece is linear in the output weights v, so that the
//! networks with the properties are a polyhedron in v. It has too many faces to be written down; but the verifier names one that
//! is violated as long as there is one. Repair by cutting planes: find violated pieces, find the cheapest v
//! that satisfies all pieces named so far, and again, until the verifier proves every property. What is cheap says the
//! caller: a quadratic function of the change ([`ChangeCost`]), taken anew about the proved network if the caller
//! says so, as in sequential quadratic programming. Where the pieces named leave no network with a margin, units alone are
//! asked for the right signs: of these networks there is always one, if only a constant. Output weights are rounded to single precision, in which weight files
//! keep them, before they are verified.

use contract::conformance::{Row, Verdict};
use std::time::Duration;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use crate::branch::Limits;
use crate::change_cost::{ChangeCost, Sign};
use crate::error::ConformanceError;
use crate::network::OneHiddenLayer;
use crate::property::Property;
use crate::region::Region;
use crate::verify::verify;

/// How a network is repaired.
#[derive(Clone, Debug, PartialEq)]
pub struct RepairRule {
    /// Rounds of verification after which a network is given back as it is then.
    pub rounds: usize,
    /// How often the cost is taken anew about a proved network, in search of a cheaper one.
    pub refits: usize,
    /// Slope in the right direction that a named piece is given, scaled output per minute per scaled input: above what
    /// rounding of weights takes away.
    pub margin: f64,
    /// Random points at which pieces are looked for in each round, besides the verifier's worst one.
    pub points: usize,
    /// Most pieces of a property that are added in a round.
    pub pieces: usize,
    /// Limits of each verification.
    pub limits: Limits,
    /// Seed of the random points.
    pub seed: u64,
}

impl RepairRule {
    /// The values in use.
    #[must_use]
    pub fn working(time: Duration, seed: u64) -> Self {
        Self {
            rounds: 200,
            refits: 4,
            margin: 2e-6,
            points: 20_000,
            pieces: 20,
            limits: Limits { relative_gap: 1e-3, nodes: u64::MAX, time, cross_check: None },
            seed,
        }
    }
}

/// Times a rule's margin up to which it is widened where pieces that were named stay violated.
const MOST_MARGINS: f64 = 1e3;

/// A network after its repair.
#[derive(Clone, Debug)]
pub struct Repaired {
    /// The network, its output weights of single precision; the original one if that was proved as it came.
    pub network: OneHiddenLayer,
    /// Its verification, a row a property.
    pub rows: Vec<Row>,
    /// Whether every property is proved.
    pub proved: bool,
    /// Rounds of verification.
    pub rounds: usize,
    /// Pieces that were named.
    pub pieces: usize,
    /// Whether no network had a margin on all of them, so that each unit has the right signs by itself.
    pub by_unit: bool,
    /// What the original network costs; 0 if it was proved as it came, and nothing was worked out.
    pub cost_before: f64,
    /// What this network costs; 0 likewise.
    pub cost: f64,
}

/// The cheapest network with these properties, all of which are of `network`, among those that differ from it in the output
/// weights and bias alone.
///
/// `cost` is what a network costs, and a change about it. It is asked for `network`, then for each proved network.
///
/// # Errors
/// What [`verify()`] refuses, and what `cost` fails with.
pub fn repair<E: From<ConformanceError>>(
    network: &OneHiddenLayer,
    properties: &[Property],
    region: &Region,
    cost: &dyn Fn(&OneHiddenLayer) -> Result<ChangeCost, E>,
    rule: &RepairRule,
    clock: &(dyn Fn() -> Duration + Sync),
) -> Result<Repaired, E> {
    let tested: Vec<usize> = properties
        .iter()
        .map(|property| network.input_index(&property.input))
        .collect::<Result<_, _>>()?;
    let boxed = region.box_of(network)?;
    let verified = |network: &OneHiddenLayer| -> Result<(Vec<Row>, bool), ConformanceError> {
        let rows: Vec<Row> = properties
            .iter()
            .map(|property| verify(network, property, region, &rule.limits, clock))
            .collect::<Result<_, _>>()?;
        let proved = rows.iter().all(|row| row.verdict == Verdict::Proved);
        Ok((rows, proved))
    };
    let (mut rows, mut proved) = verified(network)?;
    let mut found = Repaired {
        network: network.clone(),
        rows: rows.clone(),
        proved,
        rounds: 1,
        pieces: 0,
        by_unit: false,
        cost_before: 0.0,
        cost: 0.0,
    };
    if proved {
        return Ok(found);
    }
    let mut rng = ChaCha8Rng::seed_from_u64(rule.seed);
    let mut about = cost(network)?;
    found.cost_before = about.value();
    let (mut centre, mut current) = (network.clone(), network.clone());
    let mut pieces: Vec<Vec<f64>> = Vec::new();
    let (mut refits, mut by_unit, mut margin) = (0, false, rule.margin);
    loop {
        if proved {
            let here = cost(&current)?;
            let better = !found.proved || here.value() < found.cost;
            if better {
                (found.network, found.rows, found.proved) = (current.clone(), rows, true);
                (found.cost, found.by_unit) = (here.value(), by_unit);
            }
            if !better || refits == rule.refits {
                return Ok(found);
            }
            refits += 1;
            (about, centre) = (here, current);
        } else {
            if !found.proved {
                (found.network, found.rows) = (current.clone(), rows.clone());
            }
            let before = pieces.len();
            for ((property, tested), row) in properties.iter().zip(&tested).zip(&rows) {
                if row.verdict == Verdict::Proved {
                    continue;
                }
                let against = property.direction.against();
                let worst = row.witness.as_ref().map(|witness| {
                    network.inputs().iter().map(|name| witness.point[name]).collect::<Vec<f64>>()
                });
                let mut named: Vec<(f64, Vec<f64>)> = worst
                    .into_iter()
                    .chain((0..rule.points).map(|_| boxed.drawn(&mut rng)))
                    .filter(|point| boxed.contains(point))
                    .filter_map(|point| violated(&current, &point, *tested, against))
                    .collect();
                // The worst first; the verifier's own stays among them.
                named.sort_by(|a, b| b.0.total_cmp(&a.0));
                for (_, piece) in named.into_iter().take(rule.pieces) {
                    if !pieces.contains(&piece) {
                        pieces.push(piece);
                    }
                }
            }
            found.pieces = pieces.len();
            if pieces.len() == before {
                // Named already: what the search for the cheapest change leaves within its tolerance.
                margin *= 4.0;
            }
        }
        if found.rounds == rule.rounds {
            return Ok(found);
        }
        // The last round is for what cannot fail.
        let last = !found.proved && found.rounds + 1 == rule.rounds;
        let mut next = if by_unit || last || margin > MOST_MARGINS * rule.margin {
            None
        } else {
            about.least(&centre, &pieces, margin)
        };
        if next.is_none() && (by_unit || !found.proved) {
            by_unit = true;
            next = about.least_with_signs(&centre, &signs(network, properties, &tested));
        }
        let Some((weights, bias)) = next else {
            return Ok(found);
        };
        current = network.with_output(weights, bias)?;
        (rows, proved) = verified(&current)?;
        found.rounds += 1;
    }
}

/// Signs of output weights with which no unit by itself moves against a property.
fn signs(network: &OneHiddenLayer, properties: &[Property], tested: &[usize]) -> Vec<Sign> {
    let of = |unit: usize| {
        let against = properties
            .iter()
            .zip(tested)
            .map(|(property, tested)| {
                property.direction.against() * network.input_weights(unit)[*tested]
            })
            .collect::<Vec<f64>>();
        match (against.iter().any(|by| *by > 0.0), against.iter().any(|by| *by < 0.0)) {
            (false, false) => Sign::Free,
            (true, false) => Sign::NotAbove,
            (false, true) => Sign::NotBelow,
            (true, true) => Sign::Zero,
        }
    };
    (0..network.hidden()).map(of).collect()
}

/// The slope against a property on the piece to the right of a point, and its derivative by the output weights; `None`
/// where it is not above zero.
fn violated(
    network: &OneHiddenLayer,
    point: &[f64],
    tested: usize,
    against: f64,
) -> Option<(f64, Vec<f64>)> {
    let mut slope = 0.0;
    let piece: Vec<f64> = (0..network.hidden())
        .map(|unit| {
            let weights = network.input_weights(unit);
            let activation = network.activation(unit, point);
            let on = activation > 0.0 || (activation == 0.0 && weights[tested] > 0.0);
            let by = if on { against * weights[tested] } else { 0.0 };
            slope += by * network.output_weights()[unit];
            by
        })
        .collect();
    (slope > 0.0).then_some((slope, piece))
}

#[cfg(test)]
mod tests {
    use super::*;
    use contract::conformance::{Direction, PropertyKind};
    use rand::RngExt as _;

    fn property(input: &str, direction: Direction) -> Property {
        let (network, kind) = ("N".to_owned(), PropertyKind::Physical);
        Property { network, input: input.to_owned(), direction, kind }
    }

    /// Random weights of single precision over two inputs, falling in the first and rising in the second on the whole, not
    /// everywhere.
    fn random(hidden: usize, seed: u64) -> OneHiddenLayer {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = |count: usize| -> Vec<f64> {
            (0..count).map(|_| f64::from(rng.random_range(-1.0_f32..1.0))).collect()
        };
        let (mut w1, b1, w2) = (draw(2 * hidden), draw(hidden), draw(hidden));
        for (unit, row) in w1.chunks_exact_mut(2).enumerate() {
            // Of four units one moves as it should, the others as they happen to.
            if unit % 4 == 0 {
                row[0] = -row[0].abs().copysign(w2[unit]);
                row[1] = row[1].abs().copysign(w2[unit]);
            }
        }
        let inputs = vec!["a".to_owned(), "b".to_owned()];
        OneHiddenLayer::new("N", inputs, w1, b1, w2, 0.25).expect("shapes fit")
    }

    #[test]
    fn random_networks_are_proved_after_repair_and_change_little() {
        let region = Region::scaled([("a", [-2.0, 3.0]), ("b", [-1.0, 4.0])]).expect("a box");
        let properties =
            [property("a", Direction::Decreasing), property("b", Direction::Increasing)];
        let mut repaired_some = 0;
        for seed in 0..12 {
            let network = random(10 + 5 * seed as usize, seed);
            let mut rng = ChaCha8Rng::seed_from_u64(100 + seed);
            let boxed = region.box_of(&network).expect("bounded");
            let points: Vec<Vec<f64>> = (0..500).map(|_| boxed.drawn(&mut rng)).collect();
            let rule = RepairRule::working(Duration::from_secs(60), seed);
            let cost = |changed: &OneHiddenLayer| ChangeCost::of_output(&network, changed, &points);
            let found = repair(&network, &properties, &region, &cost, &rule, &|| Duration::ZERO)
                .expect("bounded inputs");
            assert!(
                found.proved,
                "seed {seed}: {} {} {:?}",
                found.rounds, found.pieces, found.rows
            );
            for property in &properties {
                let row =
                    verify(&found.network, property, &region, &rule.limits, &|| Duration::ZERO);
                assert_eq!(row.expect("decided").verdict, Verdict::Proved);
            }
            for unit in 0..network.hidden() {
                assert_eq!(found.network.input_weights(unit), network.input_weights(unit));
                let weight = found.network.output_weights()[unit];
                assert_eq!(weight, f64::from(weight as f32), "of single precision");
            }
            if found.rounds == 1 {
                assert_eq!(found.network, network, "what is proved stays as it is");
                continue;
            }
            repaired_some += 1;
            // As much as setting the output weights of all other units to zero, or less.
            let mut crude = network.output_weights().to_vec();
            for (unit, weight) in crude.iter_mut().enumerate() {
                *weight *= if unit % 4 == 0 { 1.0 } else { 0.0 };
            }
            let crude = network.with_output(crude, network.output_bias()).expect("as many");
            assert!(found.cost < cost(&crude).expect("as many").value(), "seed {seed}");
            assert_eq!(found.cost_before, 0.0);
        }
        assert!(repaired_some > 6, "{repaired_some}");
    }

    #[test]
    fn a_network_that_cannot_be_repaired_in_time_is_given_back_unproved() {
        let region = Region::scaled([("a", [-2.0, 3.0]), ("b", [-1.0, 4.0])]).expect("a box");
        let network = random(40, 2);
        let rule = RepairRule { rounds: 1, ..RepairRule::working(Duration::from_secs(60), 1) };
        let properties = [property("a", Direction::Decreasing)];
        let cost =
            |changed: &OneHiddenLayer| ChangeCost::of_output(&network, changed, &[vec![0.0, 0.0]]);
        let found = repair(&network, &properties, &region, &cost, &rule, &|| Duration::ZERO);
        let found = found.expect("bounded inputs");
        assert!(!found.proved && found.network == network);
        let none = ChangeCost::of_output(&network, &network, &[]);
        assert!(none.expect_err("no points").to_string().contains("points"));
    }

    #[test]
    fn what_no_margin_can_mend_is_mended_unit_by_unit() {
        let region = Region::scaled([("a", [-1.0, 1.0]), ("b", [-1.0, 1.0])]).expect("a box");
        let properties =
            [property("a", Direction::Decreasing), property("b", Direction::Increasing)];
        let inputs = vec!["a".to_owned(), "b".to_owned()];
        // The first unit moves wrongly in one of the two whatever its sign; the second need not.
        let w1 = vec![1.0, 1.0, -1.0, 2.0];
        let network = OneHiddenLayer::new("N", inputs, w1, vec![0.1, 0.2], vec![1.0, 1.0], 0.0)
            .expect("shapes fit");
        let points = [vec![0.5, 0.5], vec![-0.5, 0.5], vec![0.0, 0.0], vec![-0.5, -0.9]];
        let rule = RepairRule::working(Duration::from_secs(60), 1);
        let cost = |changed: &OneHiddenLayer| ChangeCost::of_output(&network, changed, &points);
        let found = repair(&network, &properties, &region, &cost, &rule, &|| Duration::ZERO);
        let found = found.expect("bounded inputs");
        assert!(found.proved && found.by_unit, "{found:?}");
        assert_eq!(found.network.output_weights()[0], 0.0);
        assert!(found.network.output_weights()[1] > 0.5);
    }

    /// A cost that is not quadratic: the fourth power of the distance of the output weights from others, which a single
    /// quadratic about the start does not find.
    #[test]
    fn the_cost_is_taken_anew_about_proved_networks() {
        let region = Region::scaled([("a", [-2.0, 3.0]), ("b", [-1.0, 4.0])]).expect("a box");
        let network = random(40, 2);
        let properties = [property("a", Direction::Decreasing)];
        let cost = |changed: &OneHiddenLayer| {
            let n = network.hidden() + 1;
            let mut distances: Vec<f64> = changed
                .output_weights()
                .iter()
                .zip(network.output_weights())
                .map(|(now, then)| now - then - 0.1)
                .collect();
            distances.push(changed.output_bias() - network.output_bias());
            let value = distances.iter().map(|d| d.powi(4)).sum();
            let gradient = distances.iter().map(|d| 4.0 * d.powi(3)).collect();
            let mut curvature = vec![0.0; n * n];
            for (unit, d) in distances.iter().enumerate() {
                curvature[unit * n + unit] = 12.0 * d * d;
            }
            ChangeCost::new(changed, value, gradient, &curvature)
        };
        let of = |refits: usize| {
            let rule = RepairRule { refits, ..RepairRule::working(Duration::from_secs(60), 1) };
            let found = repair(&network, &properties, &region, &cost, &rule, &|| Duration::ZERO);
            let found = found.expect("bounded inputs");
            assert!(found.proved);
            assert_eq!(found.cost, cost(&found.network).expect("a cost").value());
            found.cost
        };
        let (once, again) = (of(0), of(4));
        assert!(again < 0.9 * once, "{once} {again}");
    }
}
