//! z, the largest movement against a property over a step of the tested input: the paper's quantity.

use contract::conformance::{Form, StepReport};
use std::time::Duration;

use good_lp::{Expression, ProblemVariables, SolverModel, variable};

use super::{Failure, MilpLimits, Solved, failed, run};
use crate::error::{ConformanceError, require};
use crate::interior::{linear, over_unit_box, point_at, unit_inputs};
use crate::network::OneHiddenLayer;
use crate::property::Property;
use crate::region::{BoxRegion, Region};
use crate::replay::{Replay, replay};

/// Solves for the largest movement against `property` when the tested input grows by at most `delta` (scaled) within the
/// box.
///
/// # Errors
/// Those of [`super::solve`]; [`ConformanceError::Limit`] for a `delta` that is not above 0.
pub fn solve_step(
    network: &OneHiddenLayer,
    property: &Property,
    region: &Region,
    delta: f64,
    form: Form,
    limits: &MilpLimits,
    clock: &(dyn Fn() -> Duration + Sync),
) -> Result<StepReport, ConformanceError> {
    require(delta.is_finite() && delta > 0.0, "delta", delta, "above 0")?;
    limits.check()?;
    let (boxed, tested) = property.box_in(network, region)?;
    let began = clock();
    // Longest step, scaled; not longer than the box.
    let longest = delta.min(boxed.upper()[tested] - boxed.lower()[tested]);
    let neurons = neurons_seeing(network, &boxed, tested, property.direction.against(), longest);
    let (solved, binaries) = solve_form(&neurons, &boxed, tested, longest, form, limits)
        .map_err(|failure| failed(property, failure))?;
    let width = boxed.lower().len();
    let found = solved.columns.as_ref();
    let found = found.map(|columns| (point_at(&columns[..width], &boxed, tested), columns[width]));
    let attained: Option<Replay> = found.as_ref().and_then(|(point, share)| {
        let share = share.clamp(0.0, 1.0);
        let from = point[tested];
        let mut to = (from + share * longest).min(boxed.upper()[tested]);
        while to - from > delta {
            to = to.next_down();
        }
        let mut end = point.clone();
        end[tested] = to;
        // The solver keeps half-spaces to a tolerance.
        let inside = boxed.contains(point) && boxed.contains(&end);
        inside.then(|| replay(network, point, tested, to, property.direction))
    });
    Ok(StepReport {
        form,
        status: solved.status,
        delta,
        z_lower: attained.as_ref().map(|step| step.rise),
        point: found.map(|(point, _)| point),
        step: attained.as_ref().map(|step| step.to - step.from),
        claimed_objective: solved.columns.as_ref().map(|_| solved.objective),
        claimed_bound: solved.bound,
        binaries,
        seconds: clock().saturating_sub(began).as_secs_f64(),
    })
}

/// The lower end b of what a neuron sees during the step: before it if the neuron's weight is positive, else after it. The
/// other end is `b + reach` times the share.
struct Neuron {
    /// Movement against the property for each unit by which the neuron's output grows from b to the other end.
    gain: f64,
    /// `b = offset + slopes (t, share)`: the slope by the share is the last one.
    offset: f64,
    slopes: Vec<f64>,
    /// Largest distance of the two ends.
    reach: f64,
    /// Range of b.
    low: f64,
    high: f64,
}

/// The neurons that see the tested input, over inputs that run from 0 to 1 across the box; the step
/// is a share from 0 to 1 of the `longest` one (scaled).
fn neurons_seeing(
    network: &OneHiddenLayer,
    region: &BoxRegion,
    tested: usize,
    against: f64,
    longest: f64,
) -> Vec<Neuron> {
    let of = |neuron: usize| {
        let weights = network.input_weights(neuron);
        let weight = weights[tested];
        let gain = against * network.output_weights()[neuron] * weight.signum();
        if gain == 0.0 || weight == 0.0 {
            return None;
        }
        let (offset, mut slopes) = over_unit_box(weights, network.hidden_biases()[neuron], region);
        let by_share = (weight * longest).min(0.0);
        let low = offset + slopes.iter().map(|s| s.min(0.0)).sum::<f64>() + by_share;
        let high = offset + slopes.iter().map(|s| s.max(0.0)).sum::<f64>();
        let reach = weight.abs() * longest;
        slopes.push(by_share);
        Some(Neuron { gain, offset, slopes, reach, low, high })
    };
    (0..network.hidden()).filter_map(of).collect()
}

/// The solver's answer, its columns led by inputs and share, and the number of binaries.
fn solve_form(
    neurons: &[Neuron],
    region: &BoxRegion,
    tested: usize,
    longest: f64,
    form: Form,
    limits: &MilpLimits,
) -> Result<(Solved, usize), Failure> {
    let mut variables = ProblemVariables::new();
    let mut columns = unit_inputs(&mut variables, region);
    let share = variables.add(variable().min(0.0).max(1.0));
    columns.push(share);
    let mut objective = Expression::default();
    let mut constraints = Vec::new();
    let mut binaries = 0;
    let mut binary = |variables: &mut ProblemVariables| {
        binaries += 1;
        variables.add(variable().binary())
    };
    for neuron in neurons {
        let (low, high, reach) = (neuron.low, neuron.high, neuron.reach);
        if high + reach <= 0.0 {
            continue;
        }
        // All lengths as shares of the neuron's reach, so that rows have coefficients of order 1.
        let factor = 1.0 / reach;
        let bottom = linear(neuron.offset, &neuron.slopes, &columns, |value| value * factor);
        if low >= 0.0 {
            objective.add_mul(neuron.gain * reach, share);
            continue;
        }
        match form {
            Form::Difference => {
                let change = variables.add(variable().min(0.0).max(1.0));
                objective.add_mul(neuron.gain * reach, change);
                let pick = binary(&mut variables);
                let top = bottom + share;
                if neuron.gain > 0.0 {
                    // At most the whole step, at most what lies above the kink, nothing if that is nothing.
                    constraints.push((Expression::from(change) - share).leq(0.0));
                    constraints.push((Expression::from(change) - pick).leq(0.0));
                    constraints.push(
                        (Expression::from(change) - top - (low / reach) * pick).leq(-low / reach),
                    );
                } else {
                    // At least the whole step or what lies above the kink, whichever is less.
                    constraints.push((Expression::from(change) - share + pick).geq(0.0));
                    let above = (high / reach).max(0.0) + 1.0;
                    constraints.push((Expression::from(change) - top - above * pick).geq(-above));
                }
            }
            Form::TwoCopies => {
                let top = bottom.clone() + share;
                for (end, ends, sign) in
                    [(bottom, (low, high), -1.0), (top, (low, high + reach), 1.0)]
                {
                    let (low, high) = (ends.0 / reach, ends.1 / reach);
                    let output = variables.add(variable().min(0.0).max(high.max(0.0)));
                    objective.add_mul(sign * neuron.gain * reach, output);
                    let on = binary(&mut variables);
                    let output = Expression::from(output);
                    constraints.push((output.clone() - end.clone()).geq(0.0));
                    constraints.push((output.clone() - end - low * on).leq(-low));
                    constraints.push((output - high.max(0.0) * on).leq(0.0));
                }
            }
        }
    }
    let mut problem = variables.maximise(objective).using(good_lp::highs);
    let width = region.upper()[tested] - region.lower()[tested];
    constraints.push((columns[tested] + (longest / width) * share).leq(1.0));
    // Both ends of the step lie in the region's half-spaces.
    for (weights, at_most) in region.half_spaces() {
        let mut sum = Expression::from(-at_most);
        for ((weight, (lower, upper)), t) in weights.iter().zip(region.ends()).zip(&columns) {
            sum += Expression::from(weight * lower) + weight * (upper - lower) * *t;
        }
        constraints.push(sum.clone().leq(0.0));
        constraints.push((sum + weights[tested] * longest * share).leq(0.0));
    }
    for constraint in constraints {
        problem.add_constraint(constraint);
    }
    Ok((run(problem, limits)?, binaries))
}
