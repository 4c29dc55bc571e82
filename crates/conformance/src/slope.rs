//! The slope of a network along one input, as a sum over switches.
//!
//! With `a_j = w_j x + b_j`, the slope against a property of direction s in input k is
//! `s dN/dx_k = sum of c_j over a_j > 0`, `c_j = s v_j w_jk`. Only neurons with `c_j` other than 0
//! matter. Neurons that share a hyperplane are merged, and with it `|x| = max(0, x) + max(0, -x)`
//! costs one switch: the slope is a constant plus the sum of the gains of the switches that are on.
//!
//! **On kinks** the slope is not defined. Every statement of this crate is about the one-sided
//! slope to the right, the limit of `s (N(x + t e_k) - N(x)) / t` for t falling to 0, at points of
//! the box below its face `x_k = hi_k`. Since all switches that lie exactly at `a_j = 0` have
//! `w_jk` other than 0, this equals the slope of an open linear piece that the segment enters, and
//! every linear piece met by a segment of the box parallel to axis k is reached. The supremum over
//! the box is therefore a maximum over finitely many pieces, and non-positive exactly where the
//! property holds on every such segment.

use contract::conformance::Direction;
use std::cmp::Ordering;

use crate::exact::Dyadic;
use crate::network::OneHiddenLayer;
use crate::region::BoxRegion;

/// A hyperplane `w x + b = 0` and what crossing it to `w x + b > 0` adds to the slope.
#[derive(Clone, Debug)]
pub(crate) struct Switch {
    /// The neurons on this hyperplane; the first gives its side.
    pub(crate) neurons: Vec<usize>,
    /// Normal, one weight per input; the weight of the tested input is not 0, but for half-spaces.
    pub(crate) weights: Vec<f64>,
    /// Offset.
    pub(crate) bias: f64,
    /// Added slope, exact; never 0.
    pub(crate) gain: Dyadic,
}

/// Slope against a property: `constant + sum of gains of the switches that are on`.
#[derive(Clone, Debug)]
pub(crate) struct SlopeSum {
    /// Position of the tested input.
    pub(crate) tested: usize,
    /// Number of neurons of the network; from it on, half-spaces are numbered.
    pub(crate) hidden: usize,
    pub(crate) constant: Dyadic,
    pub(crate) switches: Vec<Switch>,
    /// Groups of two or more neurons that share a hyperplane, also of those whose gains cancel.
    pub(crate) together: Vec<Vec<usize>>,
}

impl SlopeSum {
    pub(crate) fn new(network: &OneHiddenLayer, tested: usize, direction: Direction) -> Self {
        let mut constant = Dyadic::default();
        let mut switches: Vec<Switch> = Vec::new();
        let against = Dyadic::new(direction.against());
        for j in 0..network.hidden() {
            let (weights, bias) = (network.input_weights(j), network.hidden_biases()[j]);
            let gain = Dyadic::new(network.output_weights()[j])
                .times(&Dyadic::new(weights[tested]))
                .times(&against);
            if gain.sign() == Ordering::Equal {
                continue;
            }
            match switches.iter_mut().find(|known| known.shares_hyperplane(weights, bias, tested)) {
                None => {
                    let neurons = vec![j];
                    switches.push(Switch { neurons, weights: weights.to_vec(), bias, gain });
                }
                Some(known) if (known.weights[tested] > 0.0) == (weights[tested] > 0.0) => {
                    known.neurons.push(j);
                    known.gain = known.gain.plus(&gain);
                }
                // On the far side of the same hyperplane: always on, and off where `known` is on.
                Some(known) => {
                    known.neurons.push(j);
                    constant = constant.plus(&gain);
                    known.gain = known.gain.minus(&gain);
                }
            }
        }
        let shared = switches.iter().filter(|switch| switch.neurons.len() > 1);
        let together = shared.map(|switch| switch.neurons.clone()).collect();
        switches.retain(|switch| switch.gain.sign() != Ordering::Equal);
        Self { tested, hidden: network.hidden(), constant, switches, together }
    }

    /// The same sum less a number beyond all gains outside of each half-space: where that is largest is where the slope is
    /// largest inside. A half-space is a switch without a neuron, numbered after the neurons.
    ///
    /// A half-space that does not see the tested input keeps its state along it; at a sum of exactly `at_most` it counts as
    /// inside.
    pub(crate) fn within(mut self, region: &BoxRegion) -> Self {
        // Exact: gains may sum to more than the largest floating-point number.
        let one = Dyadic::new(1.0).plus(&self.constant.absolute());
        let gains = self.switches.iter().map(|switch| switch.gain.absolute());
        let size = gains.fold(one, |sum, gain| sum.plus(&gain));
        let outside = size.times(&Dyadic::new(-2.0));
        for (number, (weights, at_most)) in region.half_spaces().iter().enumerate() {
            self.switches.push(Switch {
                neurons: vec![self.hidden + number],
                weights: weights.clone(),
                bias: -at_most,
                gain: outside.clone(),
            });
        }
        self
    }

    /// Exact one-sided slope to the right at `point`.
    pub(crate) fn at(&self, point: &[f64]) -> Dyadic {
        self.switches
            .iter()
            .filter(|switch| switch.on_to_the_right(point, self.tested))
            .fold(self.constant.clone(), |sum, switch| sum.plus(&switch.gain))
    }

    /// Whether the slope to the right at `point` goes against the property, decided exactly.
    pub(crate) fn fails_at(&self, point: &[f64]) -> bool {
        let on = || self.switches.iter().filter(|s| s.on_to_the_right(point, self.tested));
        let start = self.constant.round_up();
        let (rough, size) = on()
            .map(|switch| switch.gain.round_up())
            .fold((start, start.abs()), |(sum, size), gain| (sum + gain, size + gain.abs()));
        // Each gain and each addition errs by at most EPSILON of the sum of sizes.
        let error = (2 * self.switches.len() + 2) as f64 * f64::EPSILON * size;
        if rough.abs() > error { rough > 0.0 } else { self.at(point).sign() == Ordering::Greater }
    }

    /// Splits the switches over a box: those on throughout are added to the constant, those off
    /// throughout dropped. Signs are decided exactly.
    pub(crate) fn restricted_to(&self, region: &BoxRegion) -> Self {
        let mut rest = Self { switches: Vec::new(), ..self.clone() };
        for switch in &self.switches {
            let (low, high) = switch.extremes(region.lower(), region.upper());
            if low != Ordering::Less {
                rest.constant = rest.constant.plus(&switch.gain);
            } else if high == Ordering::Greater {
                rest.switches.push(switch.clone());
            }
        }
        rest
    }
}

impl Switch {
    /// Exact `w x + b`.
    pub(crate) fn value(&self, point: &[f64]) -> Dyadic {
        Dyadic::affine(self.bias, &self.weights, point)
    }

    /// Whether the switch is on just to the right of `point` along the tested input.
    pub(crate) fn on_to_the_right(&self, point: &[f64], tested: usize) -> bool {
        let products = self.weights.iter().zip(point).map(|(w, x)| w * x);
        let approximate = products.clone().fold(self.bias, |sum, product| sum + product);
        let size = products.fold(self.bias.abs(), |sum, product| sum + product.abs());
        if approximate.abs() > rounding_error(self.weights.len(), size) {
            return approximate > 0.0;
        }
        match self.value(point).sign() {
            Ordering::Greater => true,
            Ordering::Less => false,
            Ordering::Equal => self.weights[tested] > 0.0,
        }
    }

    /// Exact signs of the least and the greatest value of `w x + b` over a box.
    pub(crate) fn extremes(&self, lower: &[f64], upper: &[f64]) -> (Ordering, Ordering) {
        let corner = |high: bool| -> Vec<f64> {
            self.weights
                .iter()
                .zip(lower.iter().zip(upper))
                .map(|(&w, (&lo, &hi))| if (w > 0.0) == high { hi } else { lo })
                .collect()
        };
        (self.value(&corner(false)).sign(), self.value(&corner(true)).sign())
    }

    /// Whether `weights x + bias = 0` is this switch's hyperplane, decided exactly.
    fn shares_hyperplane(&self, weights: &[f64], bias: f64, tested: usize) -> bool {
        let (p, q) = (self.weights[tested], weights[tested]);
        let ours = self.weights.iter().chain(std::iter::once(&self.bias));
        let theirs = weights.iter().chain(std::iter::once(&bias));
        ours.zip(theirs).all(|(&a, &b)| {
            let (left, right) = (a * q, b * p);
            // Products differ by more than their rounding: settled without exact arithmetic.
            if (left - right).abs() > 4.0 * f64::EPSILON * (left.abs() + right.abs()) + 1e-300 {
                return false;
            }
            let left = Dyadic::new(a).times(&Dyadic::new(q));
            left.minus(&Dyadic::new(b).times(&Dyadic::new(p))).sign() == Ordering::Equal
        })
    }
}

/// Bound on the rounding error of `b + sum w x` evaluated in floating point in any order, with or
/// without fused operations, where `size` is the computed `|b| + sum |w x|`.
///
/// The classical bound is `(n + 1) u size` with `u = EPSILON / 2` (Higham, Accuracy and Stability
/// of Numerical Algorithms, section 3.1); four times the next integer in whole EPSILONs also covers
/// the rounding of `size`, and the last term gradual underflow.
pub(crate) fn rounding_error(inputs: usize, size: f64) -> f64 {
    4.0 * (inputs as f64 + 3.0) * f64::EPSILON * size + 1e-300
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::region::Region;

    fn network(rows: &[([f64; 2], f64, f64)]) -> OneHiddenLayer {
        OneHiddenLayer::new(
            "y",
            vec!["a".to_owned(), "b".to_owned()],
            rows.iter().flat_map(|row| row.0).collect(),
            rows.iter().map(|row| row.1).collect(),
            rows.iter().map(|row| row.2).collect(),
            0.0,
        )
        .expect("valid network")
    }

    #[test]
    fn merges_neurons_on_one_hyperplane() {
        // |a - 2b + 1| and a third neuron at three times the same hyperplane.
        let rows = [([1.0, -2.0], 1.0, 1.0), ([-1.0, 2.0], -1.0, 1.0), ([3.0, -6.0], 3.0, 0.5)];
        let sum = SlopeSum::new(&network(&rows), 0, Direction::Decreasing);
        assert_eq!(sum.switches.len(), 1);
        assert_eq!(sum.at(&[5.0, 0.0]).round_up(), 2.5);
        assert_eq!(sum.at(&[-5.0, 0.0]).round_up(), -1.0);
        // Exactly on the hyperplane: the slope to the right.
        assert_eq!(sum.at(&[1.0, 1.0]).round_up(), 2.5);
        let sum = SlopeSum::new(&network(&rows), 0, Direction::Increasing);
        assert_eq!(sum.at(&[1.0, 1.0]).round_up(), -2.5);
    }

    #[test]
    fn outside_of_a_half_space_outweighs_gains_beyond_the_largest_number() {
        let network = network(&[([1e200, 0.0], 0.0, 1e200), ([1e200, 1.0], 0.0, 1e200)]);
        let region = Region::scaled([("a", [-1.0, 1.0]), ("b", [-1.0, 1.0])])
            .and_then(|region| region.within([("a", 1.0)], 0.5))
            .expect("valid");
        let boxed = region.box_of(&network).expect("bounded");
        let sum = SlopeSum::new(&network, 0, Direction::Decreasing).within(&boxed);
        assert_eq!(sum.at(&[0.25, 0.0]).sign(), Ordering::Greater);
        assert_eq!(sum.at(&[0.75, 0.0]).sign(), Ordering::Less);
    }

    #[test]
    fn leaves_out_what_cannot_matter() {
        // No weight on the tested input, no output weight, and one neuron that matters.
        let rows = [([0.0, 1.0], 1.0, 1.0), ([1.0, 1.0], 1.0, 0.0), ([1.0, 0.0], 0.0, 2.0)];
        let sum = SlopeSum::new(&network(&rows), 0, Direction::Decreasing);
        assert_eq!(sum.switches.len(), 1);
        // A hyperplane that only touches the box belongs to one side of it.
        let network = network(&rows);
        for (bounds, constant) in [([0.0, 1.0], 2.0), ([-1.0, 0.0], 0.0)] {
            let region = Region::scaled([("a", bounds), ("b", [0.0, 1.0])]).expect("valid");
            let rest = sum.restricted_to(&region.box_of(&network).expect("bounded"));
            assert!(rest.switches.is_empty());
            assert_eq!(rest.constant.round_up(), constant);
        }
    }
}
