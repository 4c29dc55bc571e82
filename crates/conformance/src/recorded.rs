//! A sum of networks over the steps of a record: a bound, and the largest slope that the steps show.
//!
//! A twin is such a sum: a person's residual network and the population's. The networks see other inputs; the tested one
//! is common to both.

use contract::conformance::{Direction, Grounds, PropertyKind, Row, Stop, Verdict, Witness};
use rayon::prelude::*;

use crate::deep::DeepNetwork;
use crate::error::ConformanceError;
use crate::exact::Dyadic;

/// First length of a step that is replayed in exact arithmetic, scaled, and how often it is halved.
const STEP: f64 = 1e-2;
const HALVINGS: i32 = 12;

/// One network of the sum, with what it sees at each step of the record, in the order of its inputs.
#[derive(Debug, Clone, Copy)]
pub struct Summand<'a> {
    /// The network.
    pub network: &'a DeepNetwork,
    /// One point a step, scaled.
    pub points: &'a [Vec<f64>],
}

/// What is known of the slope of a sum without its steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlopeBound {
    /// Outward-rounded bound on the largest slope against the property, scaled output per minute per scaled input.
    pub m_upper: f64,
    /// On what the bound rests if it is more than boxes: the signs of weights, or proofs of each summand by itself.
    pub grounds: Option<Grounds>,
    /// Boxes bounded.
    pub nodes: u64,
    /// Why the search for the bound ended.
    pub stop: Stop,
    /// Time taken, s.
    pub seconds: f64,
}

/// Least and greatest value of each input over points of a record: the box that they span.
#[must_use]
pub fn extremes<'a>(points: impl Iterator<Item = &'a [f64]>) -> (Vec<f64>, Vec<f64>) {
    let (mut lower, mut upper) = (Vec::new(), Vec::new());
    for point in points {
        if lower.is_empty() {
            (lower, upper) = (point.to_vec(), point.to_vec());
        }
        for ((lower, upper), x) in lower.iter_mut().zip(&mut upper).zip(point) {
            *lower = f64::min(*lower, *x);
            *upper = f64::max(*upper, *x);
        }
    }
    (lower, upper)
}

/// Bounds on the slope of a residual network and of its sum with a network of which a bound is known. Weights that keep
/// their signs prove what boxes leave open by their rounding.
#[must_use]
pub fn bounds_of_sum(residual: f64, other: f64, keeps_signs: bool) -> (f64, f64) {
    let residual = if keeps_signs { residual.min(0.0) } else { residual };
    let sum = (residual + other).next_up();
    // No sum of two numbers that are not positive is positive.
    (residual, if residual <= 0.0 && other <= 0.0 { sum.min(0.0) } else { sum })
}

/// Decides whether a sum of networks falls with `input`, by a bound and by steps from the record's.
///
/// Proved is what each summand's proof proves; violated what a step shows in exact arithmetic. A bound that is not above 0
/// and comes from boxes alone proves nothing: no certificate can be written for networks of several layers.
/// `upper` is the upper end of the tested input. The first summand names the inputs of the witness.
///
/// # Errors
/// Those of [`DeepNetwork::exact_rise`], [`ConformanceError::UnknownInput`], and [`ConformanceError::NoStep`] where no
/// step of the record lies inside.
pub fn verify_recorded(
    name: &str,
    input: &str,
    summands: &[Summand<'_>],
    upper: f64,
    bound: SlopeBound,
) -> Result<Row, ConformanceError> {
    let (m_lower, witness, failing) = attained(name, input, summands, upper)?;
    let violated = m_lower > 0.0;
    let proved = bound.grounds.filter(|_| bound.m_upper <= 0.0);
    let (verdict, grounds) = match proved {
        Some(grounds) => (Verdict::Proved, Some(grounds)),
        None if violated => (Verdict::Violated, Some(Grounds::Witness)),
        None => (Verdict::Undecided, None),
    };
    Ok(Row {
        person_id: None,
        network: name.to_owned(),
        input: input.to_owned(),
        property: Direction::Decreasing,
        kind: PropertyKind::Physical,
        m_lower,
        m_upper: bound.m_upper,
        verdict,
        grounds,
        witness: Some(witness),
        seconds: bound.seconds,
        engine: "boxes_and_steps".to_owned(),
        nodes: bound.nodes,
        stop: bound.stop,
        share_of_steps: Some(failing),
        milp: None,
        milp_contradicted: None,
        share_of_region: None,
        share_of_points: None,
        step: None,
        physical_step: None,
        milp_step: None,
        smallest_change: None,
        slice: None,
        physical: None,
    })
}

/// The largest slope against a decreasing property over a step from one of the record's, with its witness, in exact
/// arithmetic, and the share of steps at which the slope rises.
fn attained(
    name: &str,
    input: &str,
    summands: &[Summand<'_>],
    upper: f64,
) -> Result<(f64, Witness, f64), ConformanceError> {
    let tested = summands
        .iter()
        .map(|summand| summand.network.input_index(input))
        .collect::<Result<Vec<usize>, _>>()?;
    let nothing = || ConformanceError::NoStep { network: name.to_owned(), input: input.to_owned() };
    let (first, tested_first) = summands.first().zip(tested.first()).ok_or_else(nothing)?;
    let rise_over = |step: usize, length: f64| -> Result<f64, ConformanceError> {
        let mut rise = 0.0;
        for (index, (summand, tested)) in summands.iter().zip(&tested).enumerate() {
            let from = &summand.points[step];
            let mut to = from.clone();
            to[*tested] += length;
            let own = summand.network.exact_rise(from, &to)?;
            rise = if index == 0 { own } else { (rise + own).next_down() };
        }
        Ok(rise)
    };
    // A look at all with a short step, then the best with several lengths.
    let short = STEP * 0.5_f64.powi(HALVINGS / 2);
    let inside: Vec<usize> = (0..first.points.len())
        .filter(|step| first.points[*step][*tested_first] + STEP <= upper)
        .collect();
    let slopes: Vec<f64> = inside
        .par_iter()
        .map(|step| {
            let from = first.points[*step][*tested_first];
            Ok(slope_at_least(rise_over(*step, short)?, from, from + short))
        })
        .collect::<Result<_, ConformanceError>>()?;
    let failing =
        slopes.iter().filter(|slope| **slope > 0.0).count() as f64 / slopes.len().max(1) as f64;
    let best = (0..inside.len()).max_by(|a, b| slopes[*a].total_cmp(&slopes[*b]));
    let best = inside[best.ok_or_else(nothing)?];
    let point = &first.points[best];
    let mut found: Option<(f64, Witness)> = None;
    for halvings in 0..=HALVINGS {
        let length = STEP * 0.5_f64.powi(halvings);
        let rise = rise_over(best, length)?;
        let from = point[*tested_first];
        let slope = slope_at_least(rise, from, from + length);
        let is_better = found.as_ref().is_none_or(|(known, _)| slope > *known);
        if slope.is_finite() && is_better {
            let witness = Witness {
                point: first.network.inputs().iter().cloned().zip(point.iter().copied()).collect(),
                from,
                to: from + length,
                rise,
            };
            found = Some((slope, witness));
        }
    }
    let (slope, witness) = found.ok_or_else(nothing)?;
    Ok((slope, witness, failing))
}

/// Lower bound on the mean slope over a step, from a lower bound on its rise; minus infinity for a step too short to be
/// there. The step is as long as its ends say, whatever length was asked for.
fn slope_at_least(rise: f64, from: f64, to: f64) -> f64 {
    let length = Dyadic::new(to).minus(&Dyadic::new(from));
    let divisor = if rise < 0.0 { length.round_down() } else { length.round_up() };
    if divisor > 0.0 { (rise / divisor).next_down() } else { f64::NEG_INFINITY }
}
