//! Slopes of networks with several hidden layers over boxes, as far as sound bounds reach.
//!
//! The slope by an input is a product of weight matrices and of the layers' switches. Over a box, each layer's inputs to its
//! ReLUs are bounded by intervals and by linear relaxation (the triangle between a ReLU and its chord, carried back to the
//! inputs; Zhang et al. 2018, "CROWN"); switches whose sign that settles are on or off, the others anything between. Carried back from the output, intervals of
//! slopes result. The box of the largest bound is halved, until the property is proved, a limit is reached, or nothing is left to halve.
//! Three hidden layers and ten inputs rarely close: `undecided` with its bracket is a usual answer.
//!
//! # Rounding
//! Every sum of products is followed by a bound on its rounding error, `GAMMA` times the sum of the sizes of its terms for each term,
//! which is added outwards. A relaxation's line is chosen by numbers as they are computed and its offset from the line as it was
//! chosen, so that it is valid whatever was rounded before. A product of two numbers that are not 0 counts as
//! `LEAST_SIZE` at least, which covers what is lost below the least normal number. Where sums overflow so that an end
//! is no number, nothing is known: the interval is everything.

use contract::conformance::{Direction, Stop};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::time::Duration;

use rayon::prelude::*;

use crate::bound::middle;
use crate::error::ConformanceError;
use crate::exact::Dyadic;
use crate::network::{check_arrays, check_point, position};

/// What errors call the network.
const NAME: &str = "deep";
/// More than the unit rounding error of a product and an addition.
const GAMMA: f64 = 2.0 * f64::EPSILON;
/// Least size that a product of two numbers other than 0 counts as: [`GAMMA`] of it is above 1e-300, and nothing beside
/// the rounding error of usual numbers.
const LEAST_SIZE: f64 = 1e-284;
/// Boxes taken from the queue at a time, bounded in parallel and put back in order.
const BATCH: usize = 32;

/// A network of fully connected layers with ReLUs between them and one output.
#[derive(Clone, Debug, PartialEq)]
pub struct DeepNetwork {
    inputs: Vec<String>,
    layers: Vec<Dense>,
}

#[derive(Clone, Debug, PartialEq)]
struct Dense {
    /// Shape (outputs, inputs), row by row.
    weights: Vec<f64>,
    biases: Vec<f64>,
    inputs: usize,
}

/// The outcome for one property.
#[derive(Clone, Debug, PartialEq)]
pub struct DeepBracket {
    /// Certified bound on the largest slope against the property, output per input.
    pub m_upper: f64,
    /// Boxes bounded.
    pub nodes: u64,
    /// Why the search ended; [`Stop::Gap`] where the bound is enough.
    pub stop: Stop,
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeepLimits {
    /// Bound that is enough.
    pub enough: f64,
    /// Most boxes.
    pub nodes: u64,
    /// Most time, by the caller's clock.
    pub time: Duration,
}

impl DeepNetwork {
    /// A network from its layers, two or more: weights of shape (outputs, inputs) row by row, and biases.
    ///
    /// # Errors
    /// [`ConformanceError::Shape`], [`ConformanceError::NonFiniteWeight`]; [`ConformanceError::Empty`] without inputs or
    /// hidden layers.
    pub fn new(
        inputs: Vec<String>,
        layers: Vec<(Vec<f64>, Vec<f64>)>,
    ) -> Result<Self, ConformanceError> {
        for (what, length) in
            [("inputs", inputs.len()), ("hidden layers", layers.len().saturating_sub(1))]
        {
            if length == 0 {
                return Err(ConformanceError::Empty { network: NAME.to_owned(), what });
            }
        }
        let mut width = inputs.len();
        let last = layers.len() - 1;
        let mut built = Vec::with_capacity(layers.len());
        for (number, (weights, biases)) in layers.into_iter().enumerate() {
            let outputs = if number == last { 1 } else { biases.len().max(1) };
            check_arrays(
                NAME,
                &[("weights", &weights, outputs * width), ("biases", &biases, outputs)],
            )?;
            built.push(Dense { weights, biases, inputs: width });
            width = outputs;
        }
        Ok(Self { inputs, layers: built })
    }

    /// Names of the inputs.
    #[must_use]
    pub fn inputs(&self) -> &[String] {
        &self.inputs
    }

    /// By how much the output is larger at `to` than at `from`: worked out without rounding, then rounded down.
    ///
    /// # Errors
    /// [`ConformanceError::Point`].
    pub fn exact_rise(&self, from: &[f64], to: &[f64]) -> Result<f64, ConformanceError> {
        for (index, point) in [from, to].into_iter().enumerate() {
            check_point(NAME, self.inputs.len(), point, index)?;
        }
        Ok(self.exact(to).minus(&self.exact(from)).round_down())
    }

    fn exact(&self, point: &[f64]) -> Dyadic {
        let mut values: Vec<Dyadic> = point.iter().map(|x| Dyadic::new(*x)).collect();
        for (number, layer) in self.layers.iter().enumerate() {
            let hidden = number + 1 < self.layers.len();
            values = layer
                .units()
                .map(|(row, bias)| {
                    let sum = row
                        .iter()
                        .zip(&values)
                        .fold(Dyadic::new(bias), |sum, (w, x)| sum.plus(&Dyadic::new(*w).times(x)));
                    let is_off = hidden && sum.sign() == Ordering::Less;
                    if is_off { Dyadic::default() } else { sum }
                })
                .collect();
        }
        values.swap_remove(0)
    }

    /// Place of an input.
    ///
    /// # Errors
    /// [`ConformanceError::UnknownInput`].
    pub(crate) fn input_index(&self, input: &str) -> Result<usize, ConformanceError> {
        position(NAME, &self.inputs, input)
    }

    /// Certified bound on the largest slope against a property of input `tested` over the box from `lower` to `upper`.
    ///
    /// # Errors
    /// [`ConformanceError::Point`] for bounds of another number than the inputs or that are not finite;
    /// [`ConformanceError::UnknownInput`].
    pub fn largest_slope(
        &self,
        tested: &str,
        direction: Direction,
        (lower, upper): (&[f64], &[f64]),
        limits: &DeepLimits,
        clock: &(dyn Fn() -> Duration + Sync),
    ) -> Result<DeepBracket, ConformanceError> {
        let tested = self.input_index(tested)?;
        for (index, ends) in [lower, upper].into_iter().enumerate() {
            check_point(NAME, self.inputs.len(), ends, index)?;
        }
        let against = direction.against();
        let began = clock();
        let mut queue = BinaryHeap::new();
        queue.push(self.bounded(lower.to_vec(), upper.to_vec(), tested, against));
        let mut nodes = 1;
        let mut stuck = f64::NEG_INFINITY;
        let stop = loop {
            let left = queue.peek().map_or(f64::NEG_INFINITY, |part: &Part| part.slope);
            if left <= limits.enough.max(stuck) {
                break if stuck <= limits.enough { Stop::Gap } else { Stop::Resolution };
            }
            if nodes >= limits.nodes {
                break Stop::Nodes;
            }
            if clock().saturating_sub(began) >= limits.time {
                break Stop::Time;
            }
            let parents: Vec<Part> = std::iter::from_fn(|| queue.pop()).take(BATCH).collect();
            let halves: Vec<Option<[Part; 2]>> = parents
                .par_iter()
                .map(|parent| {
                    let axis = parent.axis?;
                    let middle = middle(parent.lower[axis], parent.upper[axis]);
                    let half = |above: bool| {
                        let (mut lower, mut upper) = (parent.lower.clone(), parent.upper.clone());
                        if above {
                            lower[axis] = middle
                        } else {
                            upper[axis] = middle
                        }
                        let mut part = self.bounded(lower, upper, tested, against);
                        // What holds for the whole holds for its half.
                        part.slope = part.slope.min(parent.slope);
                        part
                    };
                    Some([half(false), half(true)])
                })
                .collect();
            for (parent, halves) in parents.into_iter().zip(halves) {
                match halves {
                    Some(halves) => {
                        nodes += 2;
                        queue.extend(halves);
                    }
                    None => stuck = stuck.max(parent.slope),
                }
            }
        };
        let left = queue.peek().map_or(f64::NEG_INFINITY, |part| part.slope);
        Ok(DeepBracket { m_upper: left.max(stuck), nodes, stop })
    }

    /// A box with the bound of its slope and the input to halve next.
    fn bounded(&self, lower: Vec<f64>, upper: Vec<f64>, tested: usize, against: f64) -> Part {
        let seen = self.seen_by_relus(&lower, &upper);
        let last = self.layers.len() - 1;
        // Slopes of the output by what each unit passes on, as intervals, from the last layer back.
        let mut slopes: Vec<[f64; 2]> =
            self.layers[last].weights.iter().map(|w| [against * w, against * w]).collect();
        for number in (0..last).rev() {
            for (slope, ends) in slopes.iter_mut().zip(&seen[number]) {
                if ends[1] <= 0.0 {
                    *slope = [0.0, 0.0];
                } else if ends[0] < 0.0 {
                    *slope = [slope[0].min(0.0), slope[1].max(0.0)];
                }
            }
            if number > 0 {
                let layer = &self.layers[number];
                slopes = (0..layer.inputs).map(|input| layer.pulled_back(&slopes, input)).collect();
            }
        }
        let first = &self.layers[0];
        let slope = first.pulled_back(&slopes, tested)[1];
        let influence = |axis: usize| -> f64 {
            let (mut sum, mut own) = (0.0, 0.0);
            for ((row, _), ends) in first.units().zip(&slopes) {
                sum += row[axis].abs() * (ends[1] - ends[0]);
                own += row[axis].abs() * ends[1].abs().max(ends[0].abs());
            }
            (sum + 0.1 * own) * (upper[axis] - lower[axis])
        };
        let axis = (0..lower.len())
            .filter(|axis| lower[*axis] < middle(lower[*axis], upper[*axis]))
            .max_by(|a, b| influence(*a).total_cmp(&influence(*b)).then(b.cmp(a)));
        Part { lower, upper, slope, axis }
    }

    /// Bounds of what each hidden layer's ReLUs see over a box.
    fn seen_by_relus(&self, lower: &[f64], upper: &[f64]) -> Vec<Vec<[f64; 2]>> {
        let mut seen: Vec<Vec<[f64; 2]>> = Vec::with_capacity(self.layers.len() - 1);
        for number in 0..self.layers.len() - 1 {
            let layer = &self.layers[number];
            let passed: Vec<[f64; 2]> = match seen.last() {
                None => lower.iter().zip(upper).map(|(l, u)| [*l, *u]).collect(),
                Some(before) => before.iter().map(|e| [e[0].max(0.0), e[1].max(0.0)]).collect(),
            };
            let bounds = layer
                .units()
                .map(|(row, bias)| {
                    let plain = interval(row, &passed, bias);
                    if number == 0 || plain[0] >= 0.0 || plain[1] <= 0.0 {
                        return plain;
                    }
                    let above = self.relaxed(&seen, row, bias, 1.0, lower, upper);
                    let below = -self.relaxed(&seen, row, bias, -1.0, lower, upper);
                    [plain[0].max(below), plain[1].min(above)]
                })
                .collect();
            seen.push(bounds);
        }
        seen
    }

    /// Upper bound of `sign (row h + bias)` over a box, h what the last bounded layer passes on.
    fn relaxed(
        &self,
        seen: &[Vec<[f64; 2]>],
        row: &[f64],
        bias: f64,
        sign: f64,
        lower: &[f64],
        upper: &[f64],
    ) -> f64 {
        let mut coefficients: Vec<f64> = row.iter().map(|w| sign * w).collect();
        let (mut constant, mut size, mut terms) = (sign * bias, bias.abs(), 1.0);
        let mut add = |constant: &mut f64, a: f64, b: f64| {
            *constant += a * b;
            size += size_of_product(a, b);
            terms += 1.0;
        };
        for (number, bounds) in seen.iter().enumerate().rev() {
            // From what the layer passes on to what its ReLUs see.
            for (c, [l, u]) in coefficients.iter_mut().zip(bounds) {
                if *u <= 0.0 {
                    *c = 0.0;
                } else if *l < 0.0 {
                    if *c > 0.0 {
                        // A line above the ReLU: its offset is what the line as rounded needs at both ends.
                        let line = *c * (u / (u - l));
                        let needed = (-line * l).max(*c * u - line * u);
                        let sizes = size_of_product(line, *l)
                            + size_of_product(*c, *u)
                            + size_of_product(line, *u);
                        add(&mut constant, needed + GAMMA * sizes, 1.0);
                        *c = line;
                    } else if *u <= -*l {
                        *c = 0.0;
                    }
                }
            }
            // From what the ReLUs see to what the layer before passes on.
            let layer = &self.layers[number];
            let mut next = vec![0.0; layer.inputs];
            let mut sizes = vec![0.0; layer.inputs];
            for (c, (row, bias)) in
                coefficients.iter().zip(layer.units()).filter(|(c, _)| **c != 0.0)
            {
                add(&mut constant, *c, bias);
                for ((next, size), w) in next.iter_mut().zip(&mut sizes).zip(row) {
                    *next += c * w;
                    *size += size_of_product(*c, *w);
                }
            }
            let units = coefficients.len() as f64 + 1.0;
            for (input, size) in sizes.iter().enumerate() {
                let reach = match number {
                    0 => lower[input].abs().max(upper[input].abs()),
                    _ => seen[number - 1][input][1].max(0.0),
                };
                add(&mut constant, units * GAMMA * size, reach);
            }
            coefficients = next;
        }
        for (c, (l, u)) in coefficients.iter().zip(lower.iter().zip(upper)) {
            add(&mut constant, *c, if *c >= 0.0 { *u } else { *l });
        }
        constant + 2.0 * terms * GAMMA * size
    }
}

impl Dense {
    /// Weights and bias of each unit.
    fn units(&self) -> impl Iterator<Item = (&[f64], f64)> {
        self.weights.chunks_exact(self.inputs).zip(self.biases.iter().copied())
    }

    /// Interval of the slope by one input from the intervals by the outputs.
    fn pulled_back(&self, slopes: &[[f64; 2]], input: usize) -> [f64; 2] {
        interval(self.weights[input..].iter().step_by(self.inputs), slopes, 0.0)
    }
}

/// Interval of `row x + bias`.
fn interval<'a>(
    row: impl IntoIterator<Item = &'a f64>,
    passed: &[[f64; 2]],
    bias: f64,
) -> [f64; 2] {
    let (mut low, mut high, mut size) = (bias, bias, bias.abs());
    for (w, ends) in row.into_iter().zip(passed) {
        let (a, b) = (w * ends[0], w * ends[1]);
        low += a.min(b);
        high += a.max(b);
        size += size_of_product(*w, ends[0]).max(size_of_product(*w, ends[1]));
    }
    let slack = 2.0 * (passed.len() as f64 + 2.0) * GAMMA * size;
    let (low, high) = (low - slack, high + slack);
    // Where an end is no number, nothing is known.
    if low.is_nan() || high.is_nan() { [f64::NEG_INFINITY, f64::INFINITY] } else { [low, high] }
}

/// The size of a product, of which its rounding error is a share; [`LEAST_SIZE`] at least, but for a factor of 0.
fn size_of_product(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { (a * b).abs().max(LEAST_SIZE) }
}

/// A box with the bound of the slope over it.
struct Part {
    lower: Vec<f64>,
    upper: Vec<f64>,
    slope: f64,
    axis: Option<usize>,
}

impl Ord for Part {
    fn cmp(&self, other: &Self) -> Ordering {
        let place = |part: &Self| -> Vec<u64> {
            part.lower.iter().chain(&part.upper).map(|x| x.to_bits()).collect()
        };
        self.slope.total_cmp(&other.slope).then_with(|| place(self).cmp(&place(other)))
    }
}

impl PartialOrd for Part {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Part {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Part {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::branch::Limits;
    use crate::network::OneHiddenLayer;
    use crate::property::Property;
    use crate::region::Region;
    use crate::verify::verify;
    use contract::conformance::PropertyKind;
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    fn limits(nodes: u64) -> DeepLimits {
        DeepLimits { enough: f64::NEG_INFINITY, nodes, time: Duration::from_secs(60) }
    }

    fn random(widths: &[usize], seed: u64) -> DeepNetwork {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = |count: usize| -> Vec<f64> {
            (0..count).map(|_| rng.random_range(-1.0..1.0)).collect()
        };
        let names = (0..widths[0]).map(|k| format!("x{k}")).collect();
        let layers = widths.windows(2).map(|pair| (draw(pair[0] * pair[1]), draw(pair[1])));
        DeepNetwork::new(names, layers.collect()).expect("shapes fit")
    }

    fn evaluate(network: &DeepNetwork, point: &[f64]) -> f64 {
        let mut values = point.to_vec();
        for (number, layer) in network.layers.iter().enumerate() {
            values = layer
                .units()
                .map(|(row, bias)| {
                    let sum: f64 = row.iter().zip(&values).map(|(w, x)| w * x).sum();
                    let sum = sum + bias;
                    if number + 1 < network.layers.len() { sum.max(0.0) } else { sum }
                })
                .collect();
        }
        values[0]
    }

    #[test]
    fn bounds_hold_at_random_points_and_tighten() {
        for seed in 0..20 {
            let network = random(&[3, 8, 6, 5, 1], seed);
            let (lower, upper) = ([-1.0, -0.5, 0.0], [1.0, 0.5, 0.3]);
            let of = |nodes| {
                let still = || Duration::ZERO;
                let ends = (lower.as_slice(), upper.as_slice());
                network
                    .largest_slope("x1", Direction::Decreasing, ends, &limits(nodes), &still)
                    .expect("bounded")
                    .m_upper
            };
            let (once, often) = (of(1), of(4000));
            assert!(often <= once);
            let mut rng = ChaCha8Rng::seed_from_u64(100 + seed);
            let mut largest = f64::NEG_INFINITY;
            for _ in 0..3000 {
                let from: Vec<f64> =
                    (0..3).map(|k| rng.random_range(lower[k]..upper[k] - 1e-5)).collect();
                let mut to = from.clone();
                to[1] += 1e-5;
                let rise = network.exact_rise(&from, &to).expect("inside");
                let rough = evaluate(&network, &to) - evaluate(&network, &from);
                assert!((rise - rough).abs() < 1e-12);
                largest = largest.max(rise / (to[1] - from[1]));
            }
            assert!(largest <= often + 1e-9, "seed {seed}: {largest} above {often}");
            // Not just sound: within a half of the range that a single box leaves.
            assert!(often - largest <= 0.5 * (once - largest) + 1e-9, "{largest} {often} {once}");
        }
    }

    /// One hidden layer, where the other engine knows the answer.
    #[test]
    fn agrees_with_the_exact_search_on_one_hidden_layer() {
        for seed in 0..10 {
            let network = random(&[2, 9, 1], seed);
            let flat = OneHiddenLayer::new(
                "N",
                network.inputs.clone(),
                network.layers[0].weights.clone(),
                network.layers[0].biases.clone(),
                network.layers[1].weights.clone(),
                0.0,
            )
            .expect("shapes fit");
            let property = Property {
                network: "N".to_owned(),
                input: "x0".to_owned(),
                direction: Direction::Increasing,
                kind: PropertyKind::Physical,
            };
            let region = Region::scaled([("x0", [-1.0, 1.0]), ("x1", [-1.0, 1.0])]).expect("a box");
            let exact = verify(
                &flat,
                &property,
                &region,
                &Limits {
                    relative_gap: 0.0,
                    nodes: 1_000_000,
                    time: Duration::from_secs(60),
                    cross_check: None,
                },
                &|| Duration::ZERO,
            )
            .expect("decided");
            let found = network
                .largest_slope(
                    "x0",
                    Direction::Increasing,
                    (&[-1.0, -1.0], &[1.0, 1.0]),
                    &limits(20_000),
                    &|| Duration::ZERO,
                )
                .expect("bounded");
            assert!(found.m_upper >= exact.m_lower);
            assert!(found.m_upper <= exact.m_upper + 0.02 * (1.0 + exact.m_upper.abs()), "{seed}");
        }
    }

    /// Largest slope that a single box leaves.
    fn over_one_box(network: &DeepNetwork, input: &str, ends: (&[f64], &[f64])) -> f64 {
        let still = || Duration::ZERO;
        let found = network.largest_slope(input, Direction::Decreasing, ends, &limits(1), &still);
        found.expect("bounded").m_upper
    }

    fn named(inputs: usize, layers: Vec<(Vec<f64>, Vec<f64>)>) -> DeepNetwork {
        let names = (0..inputs).map(|k| format!("x{k}")).collect();
        DeepNetwork::new(names, layers).expect("shapes fit")
    }

    #[test]
    fn products_below_the_least_number_are_not_lost() {
        // 1e-200 max(0, 1e-200 x + 1): the slope is 1e-400.
        let network = named(1, vec![(vec![1e-200], vec![1.0]), (vec![1e-200], vec![0.0])]);
        let bound = over_one_box(&network, "x0", (&[-1.0], &[1.0]));
        assert!(bound > 0.0 && bound < 1e-290, "{bound}");
        let [low, high] = interval(&[1e-200], &[[-1e-200, 1e-200]], 0.0);
        assert!(low < 0.0 && 0.0 < high, "{low} {high}");
        // A factor of 0 loses nothing.
        assert_eq!(interval(&[0.0, 1.0], &[[-1.0, 1.0], [0.0, 0.0]], 0.0), [0.0, 0.0]);
        let flat = named(1, vec![(vec![1.0], vec![1.0]), (vec![0.0], vec![0.0])]);
        assert_eq!(over_one_box(&flat, "x0", (&[0.0], &[1.0])), 0.0);
    }

    #[test]
    fn overflow_leaves_nothing_known() {
        // -max(0, 1e308 (x0 - x1)): what the ReLU sees is infinity less infinity, and it may be off.
        let network = named(2, vec![(vec![1e308, -1e308], vec![0.0]), (vec![-1.0], vec![0.0])]);
        let bound = over_one_box(&network, "x0", (&[10.0, 10.0], &[11.0, 11.0]));
        assert!(bound >= 0.0, "{bound}");
        // Two slopes of 1e309 and -1e309, whose sum is no number.
        let layers = vec![(vec![1e307; 2], vec![0.0; 2]), (vec![100.0, -100.0], vec![0.0])];
        let bound = over_one_box(&named(1, layers), "x0", (&[1.0], &[2.0]));
        assert_eq!(bound, f64::INFINITY);
    }

    #[test]
    fn says_why_it_stopped() {
        let network = random(&[3, 8, 6, 5, 1], 1);
        let stop = |enough: f64, nodes: u64, time: Duration, upper: &[f64]| {
            let limits = DeepLimits { enough, nodes, time };
            let lower = [0.0; 3];
            let ends = (lower.as_slice(), upper);
            network
                .largest_slope("x1", Direction::Decreasing, ends, &limits, &|| Duration::ZERO)
                .expect("bounded")
                .stop
        };
        let (never, minute) = (f64::NEG_INFINITY, Duration::from_secs(60));
        assert_eq!(stop(1e9, 10, minute, &[1.0; 3]), Stop::Gap);
        assert_eq!(stop(never, 10, minute, &[1.0; 3]), Stop::Nodes);
        assert_eq!(stop(never, 10, Duration::ZERO, &[1.0; 3]), Stop::Time);
        // A single point cannot be halved.
        assert_eq!(stop(never, 10, minute, &[0.0; 3]), Stop::Resolution);
    }

    #[test]
    fn refuses_what_does_not_fit() {
        let network = random(&[2, 4, 1], 1);
        let still = || Duration::ZERO;
        let of = |input: &str, ends: (&[f64], &[f64])| {
            network.largest_slope(input, Direction::Increasing, ends, &limits(1), &still)
        };
        assert!(of("y", (&[0.0; 2], &[1.0; 2])).is_err());
        assert!(of("x0", (&[0.0; 1], &[1.0; 2])).is_err());
        assert!(of("x0", (&[f64::NAN; 2], &[1.0; 2])).is_err());
        assert!(network.exact_rise(&[0.0], &[0.0]).is_err());
        let of_layers = |layers| DeepNetwork::new(vec!["a".to_owned()], layers);
        let last = (vec![1.0; 2], vec![0.0]);
        assert!(of_layers(vec![(vec![1.0; 3], vec![0.0; 2]), last.clone()]).is_err());
        assert!(of_layers(vec![(vec![1.0; 2], vec![0.0; 2]), last]).is_ok());
        // Without a hidden layer the slope is a weight, and nothing is to be searched.
        assert!(of_layers(vec![(vec![1.0], vec![0.0])]).is_err());
    }
}
