//! The verdict on one property of one network over one region, and what is added to its row: a
//! slice, physical units, the bracket of a step.

use contract::conformance::{
    Direction, Grounds, Physical, Row, Slice, StepBracket, Verdict, Witness,
};
use std::time::Duration;

use crate::branch::{Limits, maximise};
use crate::error::{ConformanceError, require};
use crate::interior::{deepest_point, point_inside};
use crate::milp;
use crate::network::OneHiddenLayer;
use crate::property::Property;
use crate::region::{BoxRegion, Region, Scaling};
use crate::replay::{Replay, longest_step, replay};
use crate::slope::SlopeSum;

/// How many halvings of a step are tried about a witness.
const HALVINGS: i32 = 20;

/// Decides `property` of `network` over `region` within `limits`.
///
/// `clock` returns the time since any fixed moment; it bounds the search and fills `seconds`. With
/// limits other than time, the row (but for `seconds`) does not depend on the number of threads.
///
/// # Errors
/// [`ConformanceError::WrongNetwork`], [`ConformanceError::UnknownInput`],
/// [`ConformanceError::RegionMissing`], [`ConformanceError::RegionEmpty`],
/// [`ConformanceError::FixedInput`], [`ConformanceError::Limit`]; [`ConformanceError::Solver`] if the
/// MILP was asked for and failed.
pub fn verify(
    network: &OneHiddenLayer,
    property: &Property,
    region: &Region,
    limits: &Limits,
    clock: &(dyn Fn() -> Duration + Sync),
) -> Result<Row, ConformanceError> {
    limits.check()?;
    let (boxed, tested) = property.box_in(network, region)?;
    let sum = SlopeSum::new(network, tested, property.direction).within(&boxed);

    let began = clock();
    let inside = point_inside(network, &sum, &boxed)?;
    let bracket = maximise(&sum, &boxed, limits, inside, clock);
    let attained = attained(network, property.direction, &sum, &boxed, &bracket.points);
    let m_lower = attained.as_ref().map_or(bracket.lower, |attained| attained.slope);
    let violates = attained.as_ref().is_some_and(|attained| attained.step.violates);
    // A bound waits for its certificate, see `prove`.
    let (verdict, grounds) = if bracket.upper <= 0.0 {
        (Verdict::Proved, Some(Grounds::Bound))
    } else if violates {
        (Verdict::Violated, Some(Grounds::Witness))
    } else {
        (Verdict::Undecided, None)
    };
    let seconds = clock().saturating_sub(began).as_secs_f64();

    let milp = match limits.cross_check {
        None => None,
        Some(limits) => Some(milp::solve(network, property, region, &limits, clock)?),
    };
    Ok(Row {
        person_id: None,
        network: property.network.clone(),
        input: property.input.clone(),
        property: property.direction,
        kind: property.kind,
        m_lower,
        m_upper: bracket.upper,
        verdict,
        grounds,
        witness: attained.map(|Attained { point, step, .. }| Witness {
            point: network.inputs().iter().cloned().zip(point).collect(),
            from: step.from,
            to: step.to,
            rise: step.rise,
        }),
        seconds,
        engine: "branch_and_bound".to_owned(),
        nodes: bracket.nodes,
        stop: bracket.stop,
        share_of_steps: None,
        milp_contradicted: milp
            .as_ref()
            .and_then(|milp| Some(milp.claimed_bound? < m_lower - milp::CLAIM_TOLERANCE)),
        milp,
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

/// A slope and a replayed step over which its mean is at least that.
struct Attained {
    slope: f64,
    point: Vec<f64>,
    step: Replay,
}

/// The best of `points` (best first) that allows a step to the right, each tried as it is and
/// moved deep into its linear piece.
fn attained(
    network: &OneHiddenLayer,
    direction: Direction,
    sum: &SlopeSum,
    region: &BoxRegion,
    points: &[Vec<f64>],
) -> Option<Attained> {
    let rest = sum.restricted_to(region);
    let tested = sum.tested;
    points.iter().find_map(|found| {
        let on: Vec<bool> =
            rest.switches.iter().map(|switch| switch.on_to_the_right(found, tested)).collect();
        [deepest_point(&rest, region, &on), Some(found.clone())]
            .into_iter()
            .flatten()
            .filter_map(|point| {
                let slope = sum.at(&point).round_down();
                if !slope.is_finite() {
                    return None;
                }
                let limit = region.reach(&point, tested);
                let step = longest_step(network, &point, tested, limit, direction, slope)?;
                Some(Attained { slope, point, step })
            })
            .max_by(|a, b| a.slope.total_cmp(&b.slope))
    })
}

/// The inputs of a row's witness in the order of the network; the row may come from a file.
fn scaled_point(
    network: &OneHiddenLayer,
    row: &Row,
    witness: &Witness,
) -> Result<Vec<f64>, ConformanceError> {
    let values = network.inputs().iter().map(|name| witness.point.get(name).copied());
    values.collect::<Option<_>>().ok_or_else(|| ConformanceError::WrongNetwork {
        property: row.network.clone(),
        network: network.output().to_owned(),
    })
}

/// Adds the output along the tested input through the witness, at `points` places across the region and at both ends of
/// the witness' step. Nothing is added where there is no witness.
///
/// # Errors
/// What [`verify()`] refuses; [`ConformanceError::WrongNetwork`] for a witness of another network.
pub fn with_slice(
    mut row: Row,
    network: &OneHiddenLayer,
    region: &Region,
    points: usize,
) -> Result<Row, ConformanceError> {
    let tested = network.input_index(&row.input)?;
    let boxed = region.box_of(network)?;
    let Some(witness) = &row.witness else { return Ok(row) };
    let mut point = scaled_point(network, &row, witness)?;
    let (first, last) = (boxed.lower()[tested], boxed.upper()[tested]);
    let at = |k: usize| first + (last - first) * k as f64 / (points.max(2) - 1) as f64;
    let mut input: Vec<f64> =
        (0..points.max(2)).map(at).chain([witness.from, witness.to]).collect();
    input.sort_by(f64::total_cmp);
    let output = input
        .iter()
        .map(|x| {
            point[tested] = *x;
            network.evaluate(&point)
        })
        .collect::<Result<_, _>>()?;
    row.slice = Some(Slice { input, output });
    Ok(row)
}

/// Adds the brackets in physical units, `m scale_output / scale_input` and `z scale_output`.
///
/// # Errors
/// [`ConformanceError::Scaling`] for a scale that is not finite and positive.
pub fn with_physical(
    mut row: Row,
    output: Scaling,
    input: Scaling,
) -> Result<Row, ConformanceError> {
    output.checked(&row.network)?;
    input.checked(&row.input)?;
    let convert = |m: f64| m * output.scale / input.scale;
    row.physical = Some(Physical { m_lower: convert(row.m_lower), m_upper: convert(row.m_upper) });
    row.physical_step = row.step.map(|step| StepBracket {
        delta: step.delta * input.scale,
        z_lower: step.z_lower * output.scale,
        z_upper: step.z_upper * output.scale,
    });
    Ok(row)
}

/// Bound on the paper's z, the largest movement against the property when the tested input
/// grows by at most `delta` (scaled): `delta max(0, m_upper)`, scaled output per minute.
#[must_use]
pub fn z_bound(row: &Row, delta: f64) -> f64 {
    delta * row.m_upper.max(0.0)
}

/// The bracket of z, the paper's quantity: how far the output moves against a property when the
/// tested input grows by at most `delta` (scaled).
///
/// Tried are steps about the row's witness, of `delta` and shorter, to its right and across it.
///
/// # Errors
/// What [`verify()`] refuses; [`ConformanceError::WrongNetwork`] for a witness of another network;
/// [`ConformanceError::Limit`] for a `delta` that is not above 0.
pub fn step_bracket(
    network: &OneHiddenLayer,
    property: &Property,
    region: &Region,
    row: &Row,
    delta: f64,
) -> Result<StepBracket, ConformanceError> {
    require(delta.is_finite() && delta > 0.0, "delta", delta, "above 0")?;
    let (boxed, tested) = property.box_in(network, region)?;
    let mut z_lower = 0.0_f64;
    if let Some(witness) = &row.witness {
        let mut point = scaled_point(network, row, witness)?;
        let (first, last) = (boxed.lower()[tested], boxed.upper()[tested]);
        for halvings in 0..HALVINGS {
            let length = delta * 0.5_f64.powi(halvings);
            for share in [0.0, 0.5, 1.0] {
                let from = (witness.from - share * length).max(first);
                let mut to = (from + length).min(last);
                while to - from > delta {
                    to = to.next_down();
                }
                let mut is_inside = |x: f64| {
                    point[tested] = x;
                    boxed.contains(&point)
                };
                if to > from && is_inside(to) && is_inside(from) {
                    let rise = replay(network, &point, tested, to, property.direction).rise;
                    z_lower = z_lower.max(rise);
                }
            }
        }
    }
    let bound = z_bound(row, delta);
    let z_upper = if bound > 0.0 { bound.next_up() } else { 0.0 };
    Ok(StepBracket { delta, z_lower, z_upper })
}
