//! Certified maximum of a slope over a box, by spatial branch and bound with outward rounding.
//!
//! Over a sub-box each switch is on throughout, off throughout, or undecided. The slope is at most
//! the constant plus the gains that are on plus the positive gains that are undecided; the box is
//! halved along the input with the largest influence on the undecided ones, most promising box
//! first. A box without undecided switches is one linear piece, whose slope is known exactly.
//!
//! # Why the upper bound is sound
//! - The bound of a box is sound (see [`crate::bound`]).
//! - A box is dropped only if its bound does not exceed a slope that is attained; the bounds of
//!   all boxes left, of boxes too small to halve, and the attained slope make up the upper bound.
//!
//! Halving uses numbers that are exactly representable, so the two halves cover their parent.
//!
//! # Whether it ends
//! Where at most as many switches meet at a point as there are inputs, in general position, the
//! search closes. Where more meet (a network whose biases are all 0, say), boxes around the meeting
//! point keep a bound that no piece attains, and the search stops at a limit with a bracket.

use contract::conformance::Stop;
use std::collections::BinaryHeap;
use std::time::Duration;

use rayon::prelude::*;

use crate::bound::{Bounded, Node, Search};
use crate::error::{ConformanceError, require};
use crate::interior::deepest_point;
use crate::milp::MilpLimits;
use crate::region::BoxRegion;
use crate::slope::SlopeSum;

/// Boxes taken from the queue at a time. Their halves are bounded in parallel and put back in
/// order, so the result does not depend on the number of threads.
const BATCH: usize = 64;

/// Rounds between two proposals for a better point, from the pattern that the most promising box
/// hopes for. A proposal takes about as long as ten rounds.
const PROPOSE_EVERY: u64 = 64;

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

/// How long to search, and what to run beside the certified search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Stop once `m_upper - m_lower` is at most this times `|m_lower|`; 0 or more, below 1.
    pub relative_gap: f64,
    /// Stop after bounding this many boxes, at least 1. Boxes still open are kept in memory, some
    /// hundred bytes each.
    pub nodes: u64,
    /// Stop after this time.
    pub time: Duration,
    /// Limits of the gradient MILP, a second engine beside the certified one through good_lp and
    /// HiGHS; `None` if it is not solved. Its answer decides no verdict.
    pub cross_check: Option<MilpLimits>,
}

impl Limits {
    pub(crate) fn check(&self) -> Result<(), ConformanceError> {
        let gap = self.relative_gap;
        require((0.0..1.0).contains(&gap), "relative_gap", gap, "0 or more and below 1")?;
        require(self.nodes > 0, "nodes", 0.0, "at least one box is bounded")
    }
}

/// The largest slope over the box; `inside` is a point of the region where it is not a box, `clock` says how much time has passed since any fixed moment.
pub(crate) fn maximise(
    sum: &SlopeSum,
    region: &BoxRegion,
    limits: &Limits,
    inside: Option<Vec<f64>>,
    clock: &(dyn Fn() -> Duration + Sync),
) -> Bracket {
    let began = clock();
    let search = Search::new(sum, region);
    let (root, middle) = search.root(region);
    let mut best = Best { lower: f64::NEG_INFINITY, upper: f64::NEG_INFINITY, points: Vec::new() };
    best.offer(sum, middle);
    if let Some(point) = inside {
        best.offer(sum, point);
    }
    let mut nodes = 1;
    let mut round = 0;
    let mut stuck = f64::NEG_INFINITY;
    let mut close_enough = f64::NEG_INFINITY;
    let mut queue = BinaryHeap::new();
    queue.extend((root.upper > best.upper).then_some(root));

    let stop = loop {
        // Where the best slope is not a floating-point number, `upper` is its other neighbour.
        let enough = best.upper.max(best.lower + limits.relative_gap * best.lower.abs());
        let Some(top) = queue.peek() else {
            break if stuck <= enough { Stop::Gap } else { Stop::Resolution };
        };
        if top.upper <= enough {
            // The first box need not have the largest bound to the last bit.
            queue.retain(|node| {
                let open = node.upper > enough;
                close_enough = close_enough.max(if open { f64::NEG_INFINITY } else { node.upper });
                open
            });
            continue;
        }
        if nodes >= limits.nodes {
            break Stop::Nodes;
        }
        if clock().saturating_sub(began) >= limits.time {
            break Stop::Time;
        }
        let parents: Vec<Node> = std::iter::from_fn(|| queue.pop()).take(BATCH).collect();
        if round % PROPOSE_EVERY == PROPOSE_EVERY / 4 {
            // Boxes meet a thin best piece late; its pattern can be tried before that.
            let hoped = search.hoped_for(&parents[0]);
            if let Some(point) = deepest_point(&search.rest, region, &hoped) {
                best.offer(sum, point);
            }
        }
        round += 1;
        let known = best.upper;
        let halves: Vec<Option<[Bounded; 2]>> =
            parents.par_iter().map(|parent| search.children(parent, known)).collect();
        for (parent, halves) in parents.into_iter().zip(halves) {
            let Some(halves) = halves else {
                stuck = stuck.max(parent.upper);
                continue;
            };
            for Bounded { node, candidate, .. } in halves {
                nodes += 1;
                if let Some(point) = candidate {
                    best.offer(sum, point);
                }
                queue.extend((node.upper > best.upper).then_some(node));
            }
        }
    };
    let left = queue.iter().map(|node| node.upper).fold(f64::NEG_INFINITY, f64::max);
    let upper = left.max(close_enough).max(stuck).max(best.upper);
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
    fn offer(&mut self, sum: &SlopeSum, point: Vec<f64>) {
        let slope = sum.at(&point);
        if slope.round_down() > self.lower {
            self.lower = slope.round_down();
            self.upper = slope.round_up();
            self.points.push(point);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::network::OneHiddenLayer;
    use crate::region::Region;
    use contract::conformance::Direction;

    /// The largest slope by trying every pattern of states and asking a linear programme whether
    /// a piece has it.
    fn by_brute_force(sum: &SlopeSum, region: &BoxRegion) -> f64 {
        let rest = sum.restricted_to(region);
        let patterns = 0..1_u32 << rest.switches.len();
        let attained = patterns.filter_map(|pattern| {
            let on: Vec<bool> =
                (0..rest.switches.len()).map(|bit| pattern >> bit & 1 == 1).collect();
            deepest_point(&rest, region, &on).map(|point| sum.at(&point).round_down())
        });
        attained.fold(f64::NEG_INFINITY, f64::max)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]

        #[test]
        fn agrees_with_brute_force(
            inputs in 1_usize..=5,
            weights in proptest::collection::vec(-2.0..2.0_f64, 7 * 7),
        ) {
            let hidden = 7;
            let network = OneHiddenLayer::new(
                "y",
                (0..inputs).map(|i| format!("x{i}")).collect(),
                weights[..hidden * inputs].to_vec(),
                weights[5 * hidden..6 * hidden].to_vec(),
                weights[6 * hidden..].to_vec(),
                0.0,
            ).expect("valid network");
            let region = Region::scaled((0..inputs).map(|i| (format!("x{i}"), [-1.0, 1.5])))
                .expect("valid region");
            let boxed = region.box_of(&network).expect("bounded");
            let sum = SlopeSum::new(&network, 0, Direction::Increasing);
            let time = Duration::from_secs(1);
            let limits = Limits { relative_gap: 0.0, nodes: 1_000_000, time, cross_check: None };
            let bracket = maximise(&sum, &boxed, &limits, None, &|| Duration::ZERO);
            prop_assert_eq!(bracket.stop, Stop::Gap);
            prop_assert_eq!(bracket.lower, sum.at(&bracket.points[0]).round_down());
            // Both are exact sums of the same gains, so a piece is either found or missed.
            prop_assert_eq!(by_brute_force(&sum, &boxed), bracket.lower);
        }
    }

    #[test]
    fn reports_what_limits_leave_open() {
        // Without biases every hyperplane passes through the origin, inside the box: the bound
        // of a box around it counts on all of them, which no piece attains.
        let angles: Vec<f64> = (0..6).map(|j| 0.3 + f64::from(j)).collect();
        let network = OneHiddenLayer::new(
            "y",
            vec!["a".to_owned(), "b".to_owned()],
            angles.iter().flat_map(|angle| [angle.cos(), angle.sin()]).collect(),
            vec![0.0; 6],
            angles.iter().map(|angle| angle.cos()).collect(),
            0.0,
        )
        .expect("valid network");
        let region = Region::scaled([("a", [-1.0, 1.5]), ("b", [-1.0, 1.25])]).expect("valid");
        let boxed = region.box_of(&network).expect("bounded");
        let sum = SlopeSum::new(&network, 0, Direction::Decreasing);
        let run = |nodes| {
            let time = Duration::from_secs(1);
            let limits = Limits { relative_gap: 0.0, nodes, time, cross_check: None };
            maximise(&sum, &boxed, &limits, None, &|| Duration::ZERO)
        };
        let stopped = run(10);
        assert_eq!(stopped.stop, Stop::Nodes);
        let truth = by_brute_force(&sum, &boxed);
        assert!(stopped.lower <= truth && truth < stopped.upper, "{stopped:?} {truth}");
        let limits =
            Limits { relative_gap: 0.0, nodes: u64::MAX, time: Duration::ZERO, cross_check: None };
        assert_eq!(maximise(&sum, &boxed, &limits, None, &|| Duration::ZERO).stop, Stop::Time);
        let longer = run(100_000);
        assert!(longer.lower == truth && truth <= longer.upper, "{longer:?} {truth}");
    }
}
