//! A point well inside a linear piece, or inside a region, by a linear programme.
//!
//! Searches meet a best piece first where it is thin, at a corner, where a step along the tested
//! input is too short to be seen. The point whose distance to the nearest hyperplane that matters
//! is largest makes the better witness. It is a proposal: whoever uses it evaluates the slope there
//! exactly.

use std::cmp::Ordering;

use good_lp::{Expression, ProblemVariables, Solution, SolverModel, Variable, variable};

use crate::error::ConformanceError;
use crate::network::OneHiddenLayer;
use crate::region::BoxRegion;
use crate::slope::{SlopeSum, Switch};

/// A switch over a box whose inputs run from 0 to 1: `a(t) = offset + slopes t`, and its range.
pub(crate) struct UnitRow {
    offset: f64,
    slopes: Vec<f64>,
    /// Least value, below 0.
    pub(crate) low: f64,
    /// Greatest value, above 0.
    pub(crate) high: f64,
    pub(crate) gain: f64,
}

impl UnitRow {
    pub(crate) fn new(switch: &Switch, region: &BoxRegion) -> Self {
        let (offset, slopes) = over_unit_box(&switch.weights, switch.bias, region);
        let low = offset + slopes.iter().map(|s| s.min(0.0)).sum::<f64>();
        let high = offset + slopes.iter().map(|s| s.max(0.0)).sum::<f64>();
        // Both are non-zero exactly; rounding must not make a divisor vanish or change its sign.
        let low = low.min(-f64::MIN_POSITIVE);
        let high = high.max(f64::MIN_POSITIVE);
        Self { offset, slopes, low, high, gain: switch.gain.round_up() }
    }

    /// `a(t) / scale`.
    pub(crate) fn expression(&self, inputs: &[Variable], scale: f64) -> Expression {
        linear(self.offset, &self.slopes, inputs, |value| value / scale)
    }
}

/// Offset and slope of `w x + bias` over a box whose inputs run from 0 to 1.
pub(crate) fn over_unit_box(weights: &[f64], bias: f64, region: &BoxRegion) -> (f64, Vec<f64>) {
    let terms = weights.iter().zip(region.ends());
    let slopes = terms.clone().map(|(w, (lo, hi))| w * (hi - lo)).collect();
    (terms.fold(bias, |sum, (w, (lo, _))| sum + w * lo), slopes)
}

/// `offset + slopes t`, each number scaled.
pub(crate) fn linear(
    offset: f64,
    slopes: &[f64],
    inputs: &[Variable],
    scaled: impl Fn(f64) -> f64,
) -> Expression {
    let mut expression = Expression::from(scaled(offset));
    for (&slope, &t) in slopes.iter().zip(inputs) {
        if slope != 0.0 {
            expression.add_mul(scaled(slope), t);
        }
    }
    expression
}

/// Variables from 0 to 1, one per input.
pub(crate) fn unit_inputs(variables: &mut ProblemVariables, region: &BoxRegion) -> Vec<Variable> {
    region.lower().iter().map(|_| variables.add(variable().min(0.0).max(1.0))).collect()
}

/// The point of the box at `t`, with room to the right along the tested input.
pub(crate) fn point_at(t: &[f64], region: &BoxRegion, tested: usize) -> Vec<f64> {
    let mut point: Vec<f64> =
        region.ends().zip(t).map(|((lo, hi), t)| (lo + (hi - lo) * t).clamp(lo, hi)).collect();
    if point[tested] >= region.upper()[tested] {
        point[tested] = region.upper()[tested].next_down();
    }
    point
}

/// A point of the box deep inside the set where the switches with positive gain in `on` are on and
/// those with negative gain outside `on` are off, so that the slope is at least that of the
/// pattern. `None` where the solver finds no such set with an interior.
///
/// `rest` holds the switches undecided over the box, `on` one entry for each.
pub(crate) fn deepest_point(rest: &SlopeSum, region: &BoxRegion, on: &[bool]) -> Option<Vec<f64>> {
    let mut variables = ProblemVariables::new();
    let inputs = unit_inputs(&mut variables, region);
    let margin = variables.add(variable().min(0.0).max(1.0));
    let mut problem = variables.maximise(Expression::from(margin)).using(good_lp::highs);
    for (switch, &on) in rest.switches.iter().zip(on) {
        let row = UnitRow::new(switch, region);
        let length = row.slopes.iter().map(|s| s * s).sum::<f64>().sqrt();
        if on && row.gain > 0.0 {
            problem.add_constraint((row.expression(&inputs, length) - margin).geq(0.0));
        } else if !on && row.gain < 0.0 {
            problem.add_constraint((row.expression(&inputs, length) + margin).leq(0.0));
        }
    }
    problem.add_constraint((inputs[rest.tested] + margin).leq(1.0));
    // The default tolerance, 1e-7, is wider than some pieces; 1e-10 is the least that is accepted.
    let solution = problem
        .set_threads(1)
        .set_option("output_flag", false)
        .set_option("primal_feasibility_tolerance", 1e-10)
        .solve()
        .ok()?;
    (solution.value(margin) > 0.0).then(|| {
        let t: Vec<f64> = inputs.iter().map(|&t| solution.value(t)).collect();
        point_at(&t, region, rest.tested)
    })
}

/// A point of a region that lies strictly inside each of its half-spaces, decided exactly; `None`
/// of a box. `sum` holds the region's half-spaces as its last switches.
///
/// The bounds of the search, and the checker's, hold strictly inside the half-spaces: a box on which
/// a sum is nowhere below `at_most` counts as outside. One such point p is enough for them to hold
/// on the faces too. Of a step from x to y within the region, the step from `x + t (p - x)` to
/// `y + t (p - y)` goes in the same direction. It lies in the region, which is convex, and strictly
/// inside for every t above 0. As t falls to 0 it tends to the step from x to y, and the network is
/// continuous. Over a region without such a point any claim could be proved.
///
/// # Errors
/// [`ConformanceError::RegionEmpty`] where no such point is found.
pub(crate) fn point_inside(
    network: &OneHiddenLayer,
    sum: &SlopeSum,
    region: &BoxRegion,
) -> Result<Option<Vec<f64>>, ConformanceError> {
    if region.half_spaces().is_empty() {
        return Ok(None);
    }
    let first = sum.switches.len() - region.half_spaces().len();
    let range = |switch: &Switch| switch.extremes(region.lower(), region.upper());
    // A half-space that holds strictly on the whole box does not limit the choice.
    let limiting = sum.switches[first..].iter().filter(|switch| range(switch).1 != Ordering::Less);
    let alone = SlopeSum { switches: limiting.cloned().collect(), ..sum.clone() };
    let is_strict = |point: &[f64]| {
        region.contains(point)
            && alone.switches.iter().all(|switch| switch.value(point).sign() == Ordering::Less)
    };
    let off = vec![false; alone.switches.len()];
    let each_can_hold = alone.switches.iter().all(|switch| range(switch).0 == Ordering::Less);
    let deepest = each_can_hold.then(|| deepest_point(&alone, region, &off)).flatten();
    let middle: Vec<f64> = region.ends().map(|(l, u)| l / 2.0 + u / 2.0).collect();
    deepest
        .into_iter()
        .chain([middle])
        .find(|point| is_strict(point))
        .map(Some)
        .ok_or_else(|| ConformanceError::RegionEmpty(network.output().to_owned()))
}
