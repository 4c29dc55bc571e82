//! Certified bound on a slope over one box.
//!
//! Each switch is on throughout, off throughout, or undecided. The slope is at most the constant
//! plus the gains that are on plus the positive gains that are undecided. Two undecided switches
//! whose hoped-for states exclude each other over the box (nearly parallel hyperplanes) are counted
//! together: one of the two hopes fails. They exclude each other if some non-negative combination of
//! the two is below zero over the whole box (Farkas' lemma, tried at the few combinations where its
//! maximum over a box can be least).
//!
//! # Why it is sound
//! - A switch is called on or off over a box, and two switches exclusive, only if the computed
//!   extreme clears zero by more than twice [`rounding_error`] over the whole root box, or if the
//!   exact extreme does not lie beyond zero.
//! - Sums are rounded up: each addition is followed by its exact rounding error (Knuth's
//!   two-sum), and the result moved up by one number where that error is positive. Gains enter as
//!   upper enclosures of their exact values.
//! - Comparisons are written so that an overflow, or a NaN from one, leaves a switch undecided.

use std::cmp::Ordering;

use crate::exact::Dyadic;
use crate::region::BoxRegion;
use crate::slope::{SlopeSum, Switch, rounding_error};

/// Most undecided switches for which pairs are examined; the work is quadratic.
const PAIRED: usize = 16;

/// The switches undecided over the root box, laid out for fast bounds.
pub(crate) struct Search {
    /// The switches undecided over the root box; the others are in its constant.
    pub(crate) rest: SlopeSum,
    inputs: usize,
    /// (switches x inputs), row by row.
    weights: Vec<f64>,
    biases: Vec<f64>,
    /// Size of each gain, of half-spaces that of the largest gain, over half the switch's range over the root box.
    steepness: Vec<f64>,
    /// Enclosures of the gains, upper ends.
    gains: Vec<f64>,
    /// Bound on the rounding error of a switch's value anywhere in the root box.
    errors: Vec<f64>,
}

/// A box, which of the switches are undecided over it, and its bound.
pub(crate) struct Node {
    lower: Box<[f64]>,
    upper_corner: Box<[f64]>,
    undecided: Box<[Undecided]>,
    /// Constant plus the gains that are on, rounded up.
    settled: f64,
    /// Certified bound on the slope over the box.
    pub(crate) upper: f64,
    /// The input to halve next, if any can be halved.
    split: Option<usize>,
}

/// A switch without a fixed state over a box, and the state that a bound counts on.
#[derive(Clone, Copy)]
pub(crate) struct Undecided {
    switch: u32,
    hoped_on: bool,
}

/// Two undecided switches whose hopes exclude each other over a box.
#[derive(Clone, Copy)]
pub(crate) struct Apart {
    /// Places among the undecided ones.
    pub(crate) first: usize,
    pub(crate) second: usize,
    /// The input whose weight vanishes in the combination that shows it.
    pub(crate) bend: usize,
}

/// A bounded box, what its bound rests on, and a point that may be better than the best known.
pub(crate) struct Bounded {
    pub(crate) node: Node,
    pub(crate) pairs: Vec<Apart>,
    pub(crate) candidate: Option<Vec<f64>>,
}

impl Search {
    pub(crate) fn new(sum: &SlopeSum, region: &BoxRegion) -> Self {
        let rest = sum.restricted_to(region);
        let inputs = region.lower().len();
        let reach: Vec<f64> = region.ends().map(|(l, u)| l.abs().max(u.abs())).collect();
        let halves: Vec<f64> = region.ends().map(|(l, u)| (u - l) / 2.0).collect();
        let size = |switch: &Switch, of: &[f64]| -> f64 {
            switch.weights.iter().zip(of).map(|(w, x)| (w * x).abs()).sum()
        };
        let each =
            |of: &dyn Fn(&Switch) -> f64| -> Vec<f64> { rest.switches.iter().map(of).collect() };
        // Centre and radius are two sums of this size each.
        let errors =
            each(&|switch| 2.0 * rounding_error(inputs, switch.bias.abs() + size(switch, &reach)));
        let is_half_space = |switch: &Switch| switch.neurons[0] >= rest.hidden;
        let of_neurons = rest.switches.iter().filter(|switch| !is_half_space(switch));
        let largest = of_neurons.map(|s| s.gain.round_up().abs()).fold(0.0, f64::max).max(1e-12);
        let steepness = each(&|switch| {
            let gain = if is_half_space(switch) { largest } else { switch.gain.round_up().abs() };
            gain / size(switch, &halves)
        });
        Self {
            inputs,
            steepness,
            weights: rest.switches.iter().flat_map(|switch| switch.weights.clone()).collect(),
            biases: each(&|switch| switch.bias),
            gains: each(&|switch| switch.gain.round_up()),
            errors,
            rest,
        }
    }

    /// The whole box, with its middle.
    pub(crate) fn root(&self, region: &BoxRegion) -> (Node, Vec<f64>) {
        let root = self.whole(region, f64::INFINITY).node;
        (root, region.ends().map(|(l, u)| middle(l, u)).collect())
    }

    /// The whole box with what its bound rests on, if a bound of `known` is enough.
    pub(crate) fn whole(&self, region: &BoxRegion, known: f64) -> Bounded {
        let all: Vec<Undecided> = (0..self.biases.len() as u32)
            .map(|switch| Undecided { switch, hoped_on: false })
            .collect();
        let settled = self.rest.constant.round_up();
        self.bound(region.lower().into(), region.upper().into(), &all, settled, known)
    }

    /// The switches that would be on where a box's bound is attained: those on at its centre,
    /// but for the undecided ones, which are as the bound counts on.
    pub(crate) fn hoped_for(&self, node: &Node) -> Vec<bool> {
        let bounds = node.lower.iter().zip(&node.upper_corner);
        let centre: Vec<f64> = bounds.map(|(&l, &u)| middle(l, u)).collect();
        let switches = self.rest.switches.iter();
        let mut on: Vec<bool> =
            switches.map(|switch| switch.on_to_the_right(&centre, self.rest.tested)).collect();
        for &Undecided { switch, hoped_on } in &*node.undecided {
            on[switch as usize] = hoped_on;
        }
        on
    }

    /// Bounds both halves of a box, the lower one first; `None` if the box is too small to halve.
    pub(crate) fn children(&self, parent: &Node, known: f64) -> Option<[Bounded; 2]> {
        let (axis, cut) = parent.cut()?;
        let half = |upper_half: bool| {
            let (mut lower, mut upper) = (parent.lower.clone(), parent.upper_corner.clone());
            if upper_half {
                lower[axis] = cut
            } else {
                upper[axis] = cut
            }
            self.bound(lower, upper, &parent.undecided, parent.settled, known)
        };
        Some([half(false), half(true)])
    }

    /// Bounds a box from what is undecided over a box that contains it.
    fn bound(
        &self,
        lower: Box<[f64]>,
        upper: Box<[f64]>,
        undecided: &[Undecided],
        settled: f64,
        known: f64,
    ) -> Bounded {
        let centre: Vec<f64> = lower.iter().zip(&upper).map(|(&l, &u)| middle(l, u)).collect();
        let reach: Vec<f64> = centre
            .iter()
            .zip(lower.iter().zip(&upper))
            .map(|(&c, (&l, &u))| (c - l).max(u - c).next_up())
            .collect();
        let mut settled = settled;
        let mut still = Vec::with_capacity(undecided.len());
        let mut values = Vec::with_capacity(undecided.len());
        let mut influence = vec![0.0; self.inputs];
        let mut at_centre = 0.0;
        let mut optimistic = 0.0;
        for &Undecided { switch, .. } in undecided {
            let index = switch as usize;
            let row = self.row(index);
            let mut value = self.biases[index];
            let mut radius = 0.0;
            for ((&w, &c), &r) in row.iter().zip(&centre).zip(&reach) {
                value += w * c;
                radius += w.abs() * r;
            }
            let error = self.errors[index];
            let (low, high) = (value - radius, value + radius);
            let gain = self.gains[index];
            // Strictly: an infinite value does not clear an infinite error.
            let (mut on, mut off) = (low > error, high < -error);
            if !on && !off && (low >= -error || high <= error) {
                let (least, greatest) = self.rest.switches[index].extremes(&lower, &upper);
                on = least != Ordering::Less;
                off = greatest != Ordering::Greater;
            }
            if on {
                settled = add_up(settled, gain);
            } else if !off {
                still.push(Undecided { switch, hoped_on: gain > 0.0 });
                values.push(value);
                optimistic = add_up(optimistic, gain.max(0.0));
                if value > 0.0 {
                    at_centre += gain;
                }
                // By the switch's range over the whole region, not over the box: of a switch that sees few of the inputs,
                // and whose hope is fulfilled on one side, boxes would otherwise be cut along those for ever.
                let steepness = self.steepness[index];
                for ((share, &w), &r) in influence.iter_mut().zip(row).zip(&reach) {
                    *share += steepness * w.abs() * r;
                }
            }
        }
        let mut bound = add_up(settled, optimistic);
        let mut pairs = Vec::new();
        if bound > known && (2..=PAIRED).contains(&still.len()) {
            (optimistic, pairs) = self.optimistic_in_pairs(&mut still, &values, &reach);
            bound = bound.min(add_up(settled, optimistic));
        }
        // The sum at the centre is only an estimate: it decides whether to compute the exact one.
        let slack = 1e-12 * (settled.abs() + optimistic + at_centre.abs());
        let promising = bound > known && settled + at_centre + slack > known;
        if bound > known && (still.is_empty() || bound - slack <= known) {
            // Settled, or above what is known by no more than rounding may have added.
            bound = bound.min(self.exact_bound(&centre, &still, &pairs));
        }
        let split = (0..self.inputs)
            .filter(|&i| lower[i] < centre[i] && centre[i] < upper[i])
            .max_by(|&i, &j| influence[i].total_cmp(&influence[j]).then(j.cmp(&i)));
        let node = Node {
            lower,
            upper_corner: upper,
            undecided: still.into(),
            settled,
            upper: bound,
            split,
        };
        Bounded { node, pairs, candidate: promising.then_some(centre) }
    }

    /// The bound of a box summed without rounding; `centre` tells the states of the switches that
    /// are not undecided.
    fn exact_bound(&self, centre: &[f64], undecided: &[Undecided], pairs: &[Apart]) -> f64 {
        let mut decided = vec![true; self.rest.switches.len()];
        for u in undecided {
            decided[u.switch as usize] = false;
        }
        let switches = self.rest.switches.iter().zip(&decided);
        let mut sum = switches
            .filter(|(switch, decided)| {
                **decided && switch.on_to_the_right(centre, self.rest.tested)
            })
            .fold(self.rest.constant.clone(), |sum, (switch, _)| sum.plus(&switch.gain));
        let zero = Dyadic::default();
        let gain = |n: usize| &self.rest.switches[undecided[n].switch as usize].gain;
        let hoped = |n| if gain(n).sign() == Ordering::Greater { gain(n) } else { &zero };
        let failed = |n| if gain(n).sign() == Ordering::Less { gain(n) } else { &zero };
        let paired = |n: usize| pairs.iter().any(|pair| pair.first == n || pair.second == n);
        for n in (0..undecided.len()).filter(|&n| !paired(n)) {
            sum = sum.plus(hoped(n));
        }
        for &Apart { first: m, second: n, .. } in pairs {
            let (first, second) = (failed(m).plus(hoped(n)), hoped(m).plus(failed(n)));
            let larger = first.minus(&second).sign() == Ordering::Greater;
            sum = sum.plus(if larger { &first } else { &second });
        }
        sum.round_up()
    }

    /// Upper bound on what the undecided switches add, where pairs of hopes that exclude each
    /// other are counted together, and those pairs; sets the hopes that attain it. `values` are at
    /// the centre.
    fn optimistic_in_pairs(
        &self,
        undecided: &mut [Undecided],
        values: &[f64],
        reach: &[f64],
    ) -> (f64, Vec<Apart>) {
        let gain = |u: &Undecided| self.gains[u.switch as usize];
        let mut conflicts = Vec::new();
        for m in 1..undecided.len() {
            for n in 0..m {
                if let Some(bend) = self.exclude_each_other(undecided, values, reach, m, n) {
                    let loss = gain(&undecided[m]).abs().min(gain(&undecided[n]).abs());
                    conflicts.push((loss, m, n, bend));
                }
            }
        }
        // Pairs must be disjoint for their losses to add up; the costliest first.
        conflicts.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut paired = vec![false; undecided.len()];
        let mut pairs = Vec::new();
        let mut sum = 0.0;
        for (_, m, n, bend) in conflicts {
            if paired[m] || paired[n] {
                continue;
            }
            (paired[m], paired[n]) = (true, true);
            pairs.push(Apart { first: m, second: n, bend });
            let (p, q) = (gain(&undecided[m]), gain(&undecided[n]));
            let first_fails = add_up(p.min(0.0), q.max(0.0));
            let second_fails = add_up(p.max(0.0), q.min(0.0));
            let fails = if first_fails > second_fails { m } else { n };
            undecided[fails].hoped_on = !undecided[fails].hoped_on;
            // Both failing adds no more than one failing.
            sum = add_up(sum, first_fails.max(second_fails));
        }
        for (u, _) in undecided.iter().zip(&paired).filter(|(_, paired)| !**paired) {
            sum = add_up(sum, gain(u).max(0.0));
        }
        (sum, pairs)
    }

    /// Where a combination of both switches bends that shows that no point of the box lies on the hoped-for side of both.
    fn exclude_each_other(
        &self,
        undecided: &[Undecided],
        values: &[f64],
        reach: &[f64],
        m: usize,
        n: usize,
    ) -> Option<usize> {
        let (j, l) = (undecided[m].switch as usize, undecided[n].switch as usize);
        // Sides as signs: positive where the hope is fulfilled.
        let side = |index: usize| if self.gains[index] > 0.0 { 1.0 } else { -1.0 };
        let (s, t) = (side(j), side(l));
        let (p, q) = (self.row(j), self.row(l));
        // The maximum over the box is convex and piecewise linear in the share of the first
        // switch; it bends where a coefficient of the combination vanishes.
        (0..self.inputs).find(|&bend| {
            let (a, b) = (s * p[bend], t * q[bend]);
            if a * b >= 0.0 {
                return false;
            }
            let (x, y) = (b.abs() / (a.abs() + b.abs()), a.abs() / (a.abs() + b.abs()));
            let mut greatest = x * s * values[m] + y * t * values[n];
            for ((&p, &q), &r) in p.iter().zip(q).zip(reach) {
                greatest += (x * s * p + y * t * q).abs() * r;
            }
            // Strictly, as above; and where the sum of sizes is infinite, both shares are 0.
            greatest < -(x * self.errors[j] + y * self.errors[l])
        })
    }

    fn row(&self, index: usize) -> &[f64] {
        &self.weights[index * self.inputs..(index + 1) * self.inputs]
    }
}

/// A number between two, the lower where there is none.
pub(crate) fn middle(lower: f64, upper: f64) -> f64 {
    let middle = lower / 2.0 + upper / 2.0;
    if middle > lower && middle < upper { middle } else { lower }
}

/// `a + b`, rounded up.
fn add_up(a: f64, b: f64) -> f64 {
    let sum = a + b;
    let virtual_b = sum - a;
    let error = (a - (sum - virtual_b)) + (b - virtual_b);
    // An overflowed sum leaves no usable error: infinity is an upper bound as it stands, minus
    // infinity is none.
    if error > 0.0 || sum == f64::NEG_INFINITY { sum.next_up() } else { sum }
}

impl Node {
    /// The input across which the box is halved, and where; `None` if it is too small.
    pub(crate) fn cut(&self) -> Option<(usize, f64)> {
        let axis = self.split?;
        Some((axis, middle(self.lower[axis], self.upper_corner[axis])))
    }

    /// The switches undecided over the box.
    pub(crate) fn undecided(&self) -> impl Iterator<Item = usize> + '_ {
        self.undecided.iter().map(|undecided| undecided.switch as usize)
    }

    /// The bound without its last 16 bits, ordered as the bound is. Where many boxes share a
    /// bound, as along the flat in which a few switches meet, rounding must not decide.
    fn rank(&self) -> i64 {
        let bits = self.upper.to_bits() as i64;
        (if bits < 0 { bits ^ i64::MAX } else { bits }) >> 16
    }
}

impl Ord for Node {
    /// Largest bound first; among equals the box that is closest to being settled, so that a shared
    /// bound is followed into depth; then by position, so that the order is total.
    fn cmp(&self, other: &Self) -> Ordering {
        let by_position = || {
            let mine = self.lower.iter().chain(&self.upper_corner);
            let theirs = other.lower.iter().chain(&other.upper_corner);
            let mut order = mine.zip(theirs).map(|(a, b)| a.total_cmp(b));
            order.find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
        };
        self.rank()
            .cmp(&other.rank())
            .then_with(|| other.undecided.len().cmp(&self.undecided.len()))
            .then_with(by_position)
    }
}

impl PartialOrd for Node {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Node {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Node {}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::network::OneHiddenLayer;
    use crate::region::Region;
    use contract::conformance::Direction;

    /// Products that overflow leave a value that is infinite, and an error that is.
    #[test]
    fn an_infinite_value_settles_no_switch() {
        let network = OneHiddenLayer::new(
            "y",
            ["a", "b", "c"].map(str::to_owned).to_vec(),
            vec![1.5e308, -1.5e308, -1.5e308],
            vec![0.0],
            vec![-1e-300],
            0.0,
        )
        .expect("valid network");
        let bounds = [("a", [2.0, 2.02]), ("b", [0.0, 2.2]), ("c", [0.0, 2.2])];
        let region = Region::scaled(bounds).expect("valid region");
        let boxed = region.box_of(&network).expect("bounded");
        let sum = SlopeSum::new(&network, 0, Direction::Decreasing);
        let search = Search::new(&sum, &boxed);
        let all = [Undecided { switch: 0, hoped_on: false }];
        // Off throughout this part of the box: a is less than b + c.
        let (lower, upper) = (Box::new([2.0, 1.1, 1.1]), Box::new([2.02, 1.12, 1.12]));
        let found = search.bound(lower, upper, &all, 0.0, f64::NEG_INFINITY);
        assert!(found.node.upper >= 0.0, "{}", found.node.upper);
    }

    proptest! {
        #[test]
        fn rounds_sums_up(a in -1e3..1e3_f64, b in -1e-12..1e3_f64) {
            let exact = Dyadic::new(a).plus(&Dyadic::new(b));
            prop_assert_eq!(add_up(a, b), exact.round_up());
        }

        #[test]
        fn bounds_contain_points(
            weights in proptest::collection::vec(-1.0..1.0_f64, 5 * 12),
            spread in 0.001..0.3_f64,
            shares in proptest::collection::vec(0.0..1.0_f64, 3 * 40),
        ) {
            // Pairs of nearly parallel hyperplanes, so that conflicts occur.
            let mut w1 = weights[..36].to_vec();
            for j in (1..12).step_by(2) {
                for i in 0..3 {
                    w1[3 * j + i] = -w1[3 * (j - 1) + i] + spread * w1[3 * j + i];
                }
            }
            let network = OneHiddenLayer::new(
                "y",
                ["a", "b", "c"].map(str::to_owned).to_vec(),
                w1,
                weights[36..48].to_vec(),
                weights[48..].to_vec(),
                0.0,
            ).expect("valid network");
            let region = Region::scaled(["a", "b", "c"].map(|name| (name, [-1.0, 1.0])))
                .expect("valid region");
            let boxed = region.box_of(&network).expect("bounded");
            let sum = SlopeSum::new(&network, 1, Direction::Decreasing);
            let search = Search::new(&sum, &boxed);
            let (mut node, _) = search.root(&boxed);
            for point in shares.chunks_exact(3) {
                let inside: Vec<f64> = point
                    .iter()
                    .zip(node.lower.iter().zip(&node.upper_corner))
                    .map(|(t, (lo, hi))| lo + (hi - lo) * t)
                    .collect();
                let slope = sum.at(&inside).round_down();
                prop_assert!(slope <= node.upper, "{slope} above {}", node.upper);
                // Descend into one of the halves; nothing is known, so both are kept.
                let Some([first, second]) = search.children(&node, f64::NEG_INFINITY) else {
                    break;
                };
                node = if point[0] < 0.5 { first } else { second }.node;
            }
        }
    }
}
