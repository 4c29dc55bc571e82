//! Networks that fail some properties, changed as little as it takes to have all of them.
//!
//! With the hidden layer as it is, the slope on every linear piece is linear in the output weights v, so that the
//! networks with the properties are a polyhedron in v. It has too many faces to be written down; but the verifier names one that
//! is violated as long as there is one. Repair by cutting planes: find violated pieces, find the v nearest to
//! the original that satisfies all pieces named so far, and again, until the verifier proves every property. Nearest is
//! in the mean squared change of the output over points of the caller's, so that what changes least is what is used most.
//! Output weights are rounded to single precision, in which weight files keep them, before they are verified.

use std::time::Duration;

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver as _, NonnegativeConeT, SolverStatus,
};
use faer::{Mat, Side};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use crate::error::ConformanceError;
use crate::network::OneHiddenLayer;
use crate::property::Property;
use crate::region::{BoxRegion, Region};
use crate::verify::{CrossCheck, Limits, Row, Verdict, verify};

/// How a network is repaired.
#[derive(Clone, Debug, PartialEq)]
pub struct RepairRule {
    /// Rounds of verification after which an unproved network is given back as it is then.
    pub rounds: usize,
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
            rounds: 100,
            margin: 2e-6,
            points: 20_000,
            pieces: 20,
            limits: Limits {
                relative_gap: 1e-3,
                nodes: u64::MAX,
                time,
                cross_check: CrossCheck::None,
            },
            seed,
        }
    }
}

/// A network after its repair.
#[derive(Clone, Debug)]
pub struct Repaired {
    /// The network, its output weights of single precision; the original one if that was proved as it came.
    pub network: OneHiddenLayer,
    /// The last verification of each property.
    pub rows: Vec<Row>,
    /// Whether every property is proved.
    pub proved: bool,
    /// Rounds of verification.
    pub rounds: usize,
    /// Pieces that were named.
    pub pieces: usize,
    /// Root mean square change of the output over the caller's points, scaled output per minute.
    pub change: f64,
}

/// The nearest network with these properties, all of which are of `network`.
///
/// `points` are where the output should stay as it is: scaled, one value per input.
///
/// # Errors
/// What [`verify()`] refuses; [`ConformanceError::Point`]; [`ConformanceError::Limit`] without points.
pub fn repair(
    network: &OneHiddenLayer,
    properties: &[Property],
    region: &Region,
    points: &[Vec<f64>],
    rule: &RepairRule,
    clock: &(dyn Fn() -> Duration + Sync),
) -> Result<Repaired, ConformanceError> {
    if points.is_empty() {
        let range = "at least one point is needed";
        return Err(ConformanceError::Limit { limit: "points", value: 0.0, range });
    }
    for (place, point) in points.iter().enumerate() {
        network.check_point(point, place)?;
    }
    let tested: Vec<usize> = properties
        .iter()
        .map(|property| network.input_index(&property.input))
        .collect::<Result<_, _>>()?;
    let boxed = region.box_of(network)?;
    let metric = Metric::new(network, points);
    let mut rng = ChaCha8Rng::seed_from_u64(rule.seed);
    let mut current = network.clone();
    let mut pieces: Vec<Vec<f64>> = Vec::new();
    let mut round = 0;
    loop {
        round += 1;
        let rows: Vec<Row> = properties
            .iter()
            .map(|property| verify(&current, property, region, &rule.limits, clock))
            .collect::<Result<_, _>>()?;
        let proved = rows.iter().all(|row| row.verdict == Verdict::Proved);
        let before = pieces.len();
        if !proved && round < rule.rounds {
            for ((property, tested), row) in properties.iter().zip(&tested).zip(&rows) {
                if row.verdict == Verdict::Proved {
                    continue;
                }
                let against = property.direction.against();
                let worst = row.witness.as_ref().map(|witness| {
                    network.inputs().iter().map(|name| witness.point[name]).collect::<Vec<f64>>()
                });
                let mut found: Vec<(f64, Vec<f64>)> = worst
                    .into_iter()
                    .chain((0..rule.points).map(|_| drawn(&boxed, &mut rng)))
                    .filter_map(|point| violated(&current, &point, *tested, against))
                    .collect();
                // The worst first; the verifier's own stays among them.
                found.sort_by(|a, b| b.0.total_cmp(&a.0));
                for (_, piece) in found.into_iter().take(rule.pieces) {
                    if !pieces.contains(&piece) {
                        pieces.push(piece);
                    }
                }
            }
        }
        let nearest = if proved || pieces.len() == before {
            None
        } else {
            metric.nearest(network, &pieces, rule.margin)
        };
        let Some((weights, bias)) = nearest else {
            let change = metric.change(network, &current);
            let pieces = pieces.len();
            return Ok(Repaired { network: current, rows, proved, rounds: round, pieces, change });
        };
        current = network.with_output(weights, bias)?;
    }
}

/// A point of the box.
fn drawn(region: &BoxRegion, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let ends = region.lower().iter().zip(region.upper());
    ends.map(|(lower, upper)| lower + (upper - lower) * rng.random::<f64>()).collect()
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
            let activation = activation(network, unit, point);
            let on = activation > 0.0 || (activation == 0.0 && weights[tested] > 0.0);
            let by = if on { against * weights[tested] } else { 0.0 };
            slope += by * network.output_weights()[unit];
            by
        })
        .collect();
    (slope > 0.0).then_some((slope, piece))
}

fn activation(network: &OneHiddenLayer, unit: usize, point: &[f64]) -> f64 {
    let products = network.input_weights(unit).iter().zip(point).map(|(w, x)| w * x);
    products.sum::<f64>() + network.hidden_biases()[unit]
}

/// Share of the mean curvature that is added to every direction of the output weights: what the points do not see
/// must not change without need either.
const RIDGE: f64 = 1e-6;
/// Tolerance of the search for the nearest weights: below half of any margin that survives rounding.
const TOLERANCE: f64 = 1e-9;

/// How much the output changes with the output weights and bias.
struct Metric {
    /// Mean outer product of the hidden layer's activity, the bias as its last unit; shape (hidden + 1, hidden + 1).
    curvature: Mat<f64>,
    /// Inverse of the lower Cholesky factor of the curvature and the ridge.
    whitening: Mat<f64>,
}

impl Metric {
    fn new(network: &OneHiddenLayer, points: &[Vec<f64>]) -> Self {
        let n = network.hidden() + 1;
        let activity = Mat::from_fn(n, points.len(), |unit, place| {
            if unit + 1 == n { 1.0 } else { activation(network, unit, &points[place]).max(0.0) }
        });
        let share = 1.0 / points.len() as f64;
        let product = &activity * activity.transpose();
        let curvature = Mat::from_fn(n, n, |row, column| share * product[(row, column)]);
        let mean = (0..n).map(|unit| curvature[(unit, unit)]).sum::<f64>() / n as f64;
        let ridged = Mat::from_fn(n, n, |row, column| {
            curvature[(row, column)] + if row == column { RIDGE * mean.max(1e-12) } else { 0.0 }
        });
        let factor = ridged.llt(Side::Lower).expect("a sum of squares and a ridge");
        let mut whitening = Mat::<f64>::identity(n, n);
        factor.L().solve_lower_triangular_in_place(whitening.as_mut());
        Self { curvature, whitening }
    }

    /// The nearest output weights and bias whose slope on every piece is `margin` in the right direction; `None` if there
    /// are none. A quadratic programme in coordinates in which the distance is the usual one.
    fn nearest(
        &self,
        network: &OneHiddenLayer,
        pieces: &[Vec<f64>],
        margin: f64,
    ) -> Option<(Vec<f64>, f64)> {
        let (n, count) = (network.hidden() + 1, pieces.len());
        let original = network.output_weights();
        let rows =
            Mat::from_fn(count, n, |piece, unit| pieces[piece].get(unit).copied().unwrap_or(0.0));
        let whitened = &rows * self.whitening.transpose();
        // Each piece in units of its own length, so that the tolerance means the same for all.
        let lengths: Vec<f64> =
            (0..count).map(|piece| whitened.row(piece).norm_l2().max(f64::MIN_POSITIVE)).collect();
        let columns: Vec<f64> = (0..n)
            .flat_map(|column| (0..count).map(move |piece| (piece, column)))
            .map(|(piece, column)| whitened[(piece, column)] / lengths[piece])
            .collect();
        let left = CscMatrix::new(
            count,
            n,
            (0..=n).map(|column| column * count).collect(),
            (0..n).flat_map(|_| 0..count).collect(),
            columns,
        );
        let right: Vec<f64> = pieces
            .iter()
            .zip(&lengths)
            .map(|(piece, length)| {
                let slope: f64 = piece.iter().zip(original).map(|(by, weight)| by * weight).sum();
                -(slope + margin) / length
            })
            .collect();
        let settings = DefaultSettings {
            verbose: false,
            max_threads: 1,
            tol_feas: TOLERANCE,
            tol_gap_abs: TOLERANCE,
            tol_gap_rel: TOLERANCE,
            ..DefaultSettings::default()
        };
        let distance = CscMatrix::identity(n);
        let linear = vec![0.0; n];
        let cones = [NonnegativeConeT(count)];
        let mut solver =
            DefaultSolver::new(&distance, &linear, &left, &right, &cones, settings).ok()?;
        solver.solve();
        let found =
            matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved);
        let change = |unit: usize| -> f64 {
            (0..n).map(|other| self.whitening[(other, unit)] * solver.solution.x[other]).sum()
        };
        let single = |value: f64| f64::from(value as f32);
        let weights = original.iter().enumerate().map(|(unit, w)| single(w + change(unit)));
        found.then(|| (weights.collect(), single(network.output_bias() + change(n - 1))))
    }

    /// Root mean square change of the output between two networks with this hidden layer.
    fn change(&self, before: &OneHiddenLayer, after: &OneHiddenLayer) -> f64 {
        let n = before.hidden() + 1;
        let difference = Mat::from_fn(n, 1, |unit, _| {
            if unit + 1 == n {
                after.output_bias() - before.output_bias()
            } else {
                after.output_weights()[unit] - before.output_weights()[unit]
            }
        });
        (difference.transpose() * &self.curvature * &difference)[(0, 0)].max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::property::{Direction, PropertyKind};

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
            let points: Vec<Vec<f64>> = (0..500).map(|_| drawn(&boxed, &mut rng)).collect();
            let rule = RepairRule::working(Duration::from_secs(60), seed);
            let found = repair(&network, &properties, &region, &points, &rule, &|| Duration::ZERO)
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
            let metric = Metric::new(&network, &points);
            assert!(found.change < metric.change(&network, &crude), "seed {seed}");
        }
        assert!(repaired_some > 6, "{repaired_some}");
    }

    #[test]
    fn a_network_that_cannot_be_repaired_in_time_is_given_back_unproved() {
        let region = Region::scaled([("a", [-2.0, 3.0]), ("b", [-1.0, 4.0])]).expect("a box");
        let network = random(40, 2);
        let rule = RepairRule { rounds: 1, ..RepairRule::working(Duration::from_secs(60), 1) };
        let properties = [property("a", Direction::Decreasing)];
        let points = [vec![0.0, 0.0]];
        let found = repair(&network, &properties, &region, &points, &rule, &|| Duration::ZERO);
        let found = found.expect("bounded inputs");
        assert!(!found.proved && found.network == network);
        let none = repair(&network, &properties, &region, &[], &rule, &|| Duration::ZERO);
        assert!(none.expect_err("no points").to_string().contains("points"));
    }
}
