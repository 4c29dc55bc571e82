//! Certified maximum of a slope over a box, by spatial branch and bound with outward rounding.
//!
//! Over a sub-box each switch is on throughout, off throughout, or undecided. The slope is at most
//! the constant plus the gains that are on plus the positive gains that are undecided; the box is
//! halved along the input with the largest influence on the undecided ones, most promising box
//! first. A box without undecided switches is one linear piece, whose slope is known exactly.
//!
//! Two switches whose hoped-for states exclude each other over a box (nearly parallel hyperplanes)
//! are counted together: one of the two hopes fails. They exclude each other if some non-negative
//! combination of the two is below zero over the whole box (Farkas' lemma, tried at the few
//! combinations where its maximum over a box can be least).
//!
//! # Why the upper bound is sound
//! - A switch is called on or off over a box only if its computed extreme clears zero by more than
//!   [`rounding_error`] over the whole root box, or if the exact extreme does not lie beyond zero.
//! - Sums are rounded up: each addition is followed by its exact rounding error (Knuth's
//!   two-sum), and the result moved up by one number where that error is positive. Gains enter as
//!   upper enclosures of their exact values.
//! - A box is dropped only if its bound does not exceed a slope that is attained; the bounds of
//!   all boxes left, of boxes too small to halve, and the attained slope make up the upper bound.
//!
//! Halving uses numbers that are exactly representable, so the two halves cover their parent.
//!
//! # Whether it ends
//! Where at most as many switches meet at a point as there are inputs, in general position, the
//! search closes. Where more meet (a network whose biases are all 0, say), boxes around the meeting
//! point keep a bound that no piece attains, and the search stops at a limit with a bracket.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::time::Duration;

use rayon::prelude::*;
use serde::Serialize;

use crate::interior::deepest_point;
use crate::region::BoxRegion;
use crate::slope::{SlopeSum, rounding_error};

/// Boxes taken from the queue at a time. Their halves are bounded in parallel and put back in
/// order, so the result does not depend on the number of threads.
const BATCH: usize = 64;

/// Rounds between two proposals for a better point, from the pattern that the most promising box
/// hopes for. A proposal takes about as long as ten rounds.
const PROPOSE_EVERY: u64 = 64;

/// Most undecided switches for which pairs are examined; the work is quadratic.
const PAIRED: usize = 16;

/// Why the search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stop {
    /// The bracket closed to within the asked relative gap.
    Gap,
    /// The limit on boxes was reached.
    Nodes,
    /// The limit on time was reached.
    Time,
    /// Only boxes too small to halve in floating point were left.
    Resolution,
}

/// Lower and upper bound on the largest slope against a property.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Bracket {
    /// Attained at the first of `points`, to the right; rounded down.
    pub(crate) lower: f64,
    /// Certified.
    pub(crate) upper: f64,
    /// The points at which the slope was larger than known before, best first.
    pub(crate) points: Vec<Vec<f64>>,
    /// Boxes bounded.
    pub(crate) nodes: u64,
    pub(crate) stop: Stop,
}

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Budget {
    pub(crate) relative_gap: f64,
    pub(crate) nodes: u64,
    pub(crate) time: Duration,
}

/// The largest slope over the box; `clock` says how much time has passed since any fixed moment.
pub(crate) fn maximise(
    sum: &SlopeSum,
    region: &BoxRegion,
    budget: Budget,
    clock: &(dyn Fn() -> Duration + Sync),
) -> Bracket {
    let began = clock();
    let search = Search::new(sum, region);
    let (root, middle) = search.root(region);
    let mut best = Best { lower: f64::NEG_INFINITY, upper: f64::NEG_INFINITY, points: Vec::new() };
    best.offer(&search, middle);
    let mut nodes = 1;
    let mut round = 0;
    let mut stuck = f64::NEG_INFINITY;
    let mut queue = BinaryHeap::new();
    queue.extend((root.upper > best.lower).then_some(root));

    let stop = loop {
        let Some(top) = queue.peek() else {
            let closed = stuck <= best.lower + budget.relative_gap * best.lower.abs();
            break if closed { Stop::Gap } else { Stop::Resolution };
        };
        if top.upper <= best.lower + budget.relative_gap * best.lower.abs() {
            break Stop::Gap;
        }
        if nodes >= budget.nodes {
            break Stop::Nodes;
        }
        if clock().saturating_sub(began) >= budget.time {
            break Stop::Time;
        }
        let parents: Vec<Node> = std::iter::from_fn(|| queue.pop()).take(BATCH).collect();
        if round % PROPOSE_EVERY == PROPOSE_EVERY / 4 {
            // Boxes meet a thin best piece late; its pattern can be tried before that.
            let hoped = search.hoped_for(&parents[0]);
            if let Some(point) = deepest_point(&search.rest, region, &hoped) {
                best.offer(&search, point);
            }
        }
        round += 1;
        let known = best.lower;
        let halves: Vec<Halves> =
            parents.par_iter().map(|parent| search.halve(parent, known)).collect();
        for (parent, halves) in parents.into_iter().zip(halves) {
            let Some(halves) = halves else {
                stuck = stuck.max(parent.upper);
                continue;
            };
            for (child, candidate) in halves {
                nodes += 1;
                if let Some(point) = candidate {
                    best.offer(&search, point);
                }
                queue.extend(child.filter(|child| child.upper > best.lower));
            }
        }
    };
    // The first box need not have the largest bound to the last bit.
    let left = queue.iter().map(|node| node.upper).fold(f64::NEG_INFINITY, f64::max);
    let upper = left.max(stuck).max(best.upper);
    best.points.reverse();
    Bracket { lower: best.lower, upper, points: best.points, nodes, stop }
}

/// The best slope attained so far.
struct Best {
    lower: f64,
    upper: f64,
    /// Best last.
    points: Vec<Vec<f64>>,
}

impl Best {
    fn offer(&mut self, search: &Search<'_>, point: Vec<f64>) {
        let slope = search.sum.at(&point);
        if slope.round_down() > self.lower {
            self.lower = slope.round_down();
            self.upper = slope.round_up();
            self.points.push(point);
        }
    }
}

/// The switches undecided over the root box, laid out for fast bounds.
struct Search<'a> {
    sum: &'a SlopeSum,
    /// Undecided over the root box.
    rest: SlopeSum,
    inputs: usize,
    /// (switches x inputs), row by row.
    weights: Vec<f64>,
    biases: Vec<f64>,
    /// Enclosures of the gains, upper ends.
    gains: Vec<f64>,
    /// Bound on the rounding error of a switch's value anywhere in the root box.
    errors: Vec<f64>,
}

/// A box, which of the switches are undecided over it, and its bound.
struct Node {
    lower: Box<[f64]>,
    upper_corner: Box<[f64]>,
    undecided: Box<[Undecided]>,
    /// Constant plus the gains that are on, rounded up.
    settled: f64,
    /// Certified bound on the slope over the box.
    upper: f64,
    /// The input to halve next, if any can be halved.
    split: Option<usize>,
}

/// A switch without a fixed state over a box, and the state that a bound counts on.
#[derive(Clone, Copy)]
struct Undecided {
    switch: u32,
    hoped_on: bool,
}

/// Two children with, for each, a point that may be better than the best known.
type Halves = Option<[(Option<Node>, Option<Vec<f64>>); 2]>;

impl<'a> Search<'a> {
    fn new(sum: &'a SlopeSum, region: &BoxRegion) -> Self {
        let rest = sum.restricted_to(region);
        let inputs = region.lower().len();
        let reach: Vec<f64> =
            region.lower().iter().zip(region.upper()).map(|(l, u)| l.abs().max(u.abs())).collect();
        let errors = rest
            .switches
            .iter()
            .map(|switch| {
                let size = switch.weights.iter().zip(&reach).map(|(w, x)| (w * x).abs());
                // Centre and radius are two sums of this size each.
                2.0 * rounding_error(inputs, switch.bias.abs() + size.sum::<f64>())
            })
            .collect();
        Self {
            sum,
            inputs,
            weights: rest.switches.iter().flat_map(|switch| switch.weights.clone()).collect(),
            biases: rest.switches.iter().map(|switch| switch.bias).collect(),
            gains: rest.switches.iter().map(|switch| switch.gain.round_up()).collect(),
            errors,
            rest,
        }
    }

    fn root(&self, region: &BoxRegion) -> (Node, Vec<f64>) {
        let all: Vec<Undecided> = (0..self.biases.len() as u32)
            .map(|switch| Undecided { switch, hoped_on: false })
            .collect();
        let settled = self.rest.constant.round_up();
        let (node, _) =
            self.bound(region.lower().into(), region.upper().into(), &all, settled, f64::INFINITY);
        let middle = region.lower().iter().zip(region.upper()).map(|(l, u)| middle(*l, *u));
        (node, middle.collect())
    }

    /// The switches that would be on where a box's bound is attained: those on at its centre,
    /// but for the undecided ones, which are as the bound counts on.
    fn hoped_for(&self, node: &Node) -> Vec<bool> {
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

    fn halve(&self, parent: &Node, known: f64) -> Halves {
        let axis = parent.split?;
        let cut = middle(parent.lower[axis], parent.upper_corner[axis]);
        let half = |upper_half: bool| {
            let (mut lower, mut upper) = (parent.lower.clone(), parent.upper_corner.clone());
            if upper_half {
                lower[axis] = cut
            } else {
                upper[axis] = cut
            }
            let (node, candidate) =
                self.bound(lower, upper, &parent.undecided, parent.settled, known);
            ((node.upper > known).then_some(node), candidate)
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
    ) -> (Node, Option<Vec<f64>>) {
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
            let (mut on, mut off) = (low >= error, high <= -error);
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
                let weight = gain.abs() / radius;
                for ((share, &w), &r) in influence.iter_mut().zip(row).zip(&reach) {
                    *share += weight * w.abs() * r;
                }
            }
        }
        let mut bound = add_up(settled, optimistic);
        if bound > known && (2..=PAIRED).contains(&still.len()) {
            optimistic = self.optimistic_in_pairs(&mut still, &values, &reach);
            bound = bound.min(add_up(settled, optimistic));
        }
        // The sum at the centre is only an estimate: it decides whether to compute the exact one.
        let slack = 1e-12 * (settled.abs() + at_centre.abs());
        let promising = bound > known && settled + at_centre + slack > known;
        if still.is_empty() && bound > known {
            // One linear piece: its slope is known without the rounding of the sum.
            bound = bound.min(self.sum.at(&centre).round_up());
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
        (node, promising.then_some(centre))
    }

    /// Upper bound on what the undecided switches add, where pairs of hopes that exclude each
    /// other are counted together; sets the hopes that attain it. `values` are at the centre.
    fn optimistic_in_pairs(
        &self,
        undecided: &mut [Undecided],
        values: &[f64],
        reach: &[f64],
    ) -> f64 {
        let gain = |u: &Undecided| self.gains[u.switch as usize];
        let mut conflicts = Vec::new();
        for m in 1..undecided.len() {
            for n in 0..m {
                if self.exclude_each_other(undecided, values, reach, m, n) {
                    let loss = gain(&undecided[m]).abs().min(gain(&undecided[n]).abs());
                    conflicts.push((loss, m, n));
                }
            }
        }
        // Pairs must be disjoint for their losses to add up; the costliest first.
        conflicts.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut paired = vec![false; undecided.len()];
        let mut sum = 0.0;
        for (_, m, n) in conflicts {
            if paired[m] || paired[n] {
                continue;
            }
            (paired[m], paired[n]) = (true, true);
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
        sum
    }

    /// Whether no point of the box lies on the hoped-for side of both switches.
    fn exclude_each_other(
        &self,
        undecided: &[Undecided],
        values: &[f64],
        reach: &[f64],
        m: usize,
        n: usize,
    ) -> bool {
        let (j, l) = (undecided[m].switch as usize, undecided[n].switch as usize);
        // Sides as signs: positive where the hope is fulfilled.
        let side = |index: usize| if self.gains[index] > 0.0 { 1.0 } else { -1.0 };
        let (s, t) = (side(j), side(l));
        let (p, q) = (self.row(j), self.row(l));
        // The maximum over the box is convex and piecewise linear in the share of the first
        // switch; it bends where a coefficient of the combination vanishes.
        (0..self.inputs).any(|bend| {
            let (a, b) = (s * p[bend], t * q[bend]);
            if a * b >= 0.0 {
                return false;
            }
            let (x, y) = (b.abs() / (a.abs() + b.abs()), a.abs() / (a.abs() + b.abs()));
            let mut greatest = x * s * values[m] + y * t * values[n];
            for ((&p, &q), &r) in p.iter().zip(q).zip(reach) {
                greatest += (x * s * p + y * t * q).abs() * r;
            }
            greatest <= -(x * self.errors[j] + y * self.errors[l])
        })
    }

    fn row(&self, index: usize) -> &[f64] {
        &self.weights[index * self.inputs..(index + 1) * self.inputs]
    }
}

/// A number between two, the lower where there is none.
fn middle(lower: f64, upper: f64) -> f64 {
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
