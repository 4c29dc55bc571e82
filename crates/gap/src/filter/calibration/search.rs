//! The search: the minimum of the loss under the gains of everybody's parameters.

use super::information::square;
use super::point::{FixedGains, OwnGains, Point};
use super::unlogged::{meals, unlogged};
use super::{Calibration, Factor, Factors, PersonalFactors, Setting, Square};
use crate::error::GapError;
use crate::filter::scored::Whitening;

/// Iterations in which the dependence of days follows the factors; later ones descend one loss.
const FOLLOWED: usize = 4;
/// The step, posterior standard deviations, with which the first descent ends.
const FIRST_TOLERANCE: f64 = 1.0;
/// Shares of a step that are tried.
const SHARES: [f64; 5] = [1.0, 0.5, 0.25, 0.125, 0.0625];

/// Descends twice: under the gains of everybody's parameters, which one minimum follows from, and under the gains of
/// what was found, which are nearer to the person's.
///
/// What a third descent would change by its first step counts as uncertainty.
pub(super) fn solved(setting: &Setting<'_>) -> Result<Calibration, GapError> {
    let everybody = PersonalFactors::default();
    let held = FixedGains::of(setting, &everybody)?;
    let first = descended(setting, &held, everybody, FIRST_TOLERANCE)?;

    let held = FixedGains::of(setting, &first.point.factors)?;
    let Descended { point, dependence, iterations, converged } =
        descended(setting, &held, first.point.factors, setting.rule.tolerance)?;
    let information = &point.information;
    let covariance = |observed: &[Square], unlogged: &Square| {
        information.covariance(observed, dependence, unlogged).ok_or_else(|| setting.singular())
    };
    let by_gauss: Vec<Square> = information.days.iter().map(|day| day.curvature).collect();
    let complete = covariance(&by_gauss, &Square::default())?;
    let sd = std::array::from_fn(|k| complete[k][k].sqrt());
    let own = OwnGains::of(setting, point.factors, &meals(setting.record))?;
    let left = own.point.information.step(dependence, &point.factors, setting)?;
    let unlogged = unlogged(setting, &own, dependence, &left);
    let covariance = covariance(&observed(setting, &held, &point, &sd)?, &unlogged)
        .or_else(|_| covariance(&by_gauss, &unlogged))?;
    let covariance = square(|row, column| covariance[row][column] + left[row] * left[column]);
    let (factors, filtered) = (point.factors, own.held.filtered);
    let at_bound = |factor: &Factor| factors.get(*factor).abs() >= setting.rule.bound;
    let (Whitening { autoregression, scale }, whitened) = setting.whitened(&filtered);
    Ok(Calibration {
        at_bound: Factor::ALL.into_iter().filter(at_bound).collect(),
        factors,
        sd: std::array::from_fn(|k| covariance[k][k].sqrt()),
        covariance,
        dependence,
        model: own.model,
        filtered,
        autoregression,
        whitened,
        scale,
        iterations: first.iterations + iterations,
        converged,
    })
}

/// Where a descent ends.
struct Descended {
    point: Point,
    dependence: f64,
    iterations: usize,
    converged: bool,
}

/// Descends by Gauss and Newton; a step that gains nothing is halved.
fn descended(
    setting: &Setting<'_>,
    held: &FixedGains,
    start: PersonalFactors,
    tolerance: f64,
) -> Result<Descended, GapError> {
    let mut point = Point::at(setting, held, start)?;
    let mut dependence = 1.0;
    let mut iterations = 0;
    let converged = loop {
        if iterations < FOLLOWED {
            dependence = point.information.dependence().ok_or_else(|| setting.singular())?;
        }
        let step = point.information.step(dependence, &point.factors, setting)?;
        if point.information.length(dependence, &step) < tolerance {
            break true;
        }
        if iterations >= setting.rule.max_iterations {
            break false;
        }
        iterations += 1;
        let Some(better) = better(setting, held, &point, &step, dependence)? else { break false };
        point = better;
    };
    Ok(Descended { point, dependence, iterations, converged })
}

/// Curvature of each day's loss by differences of its gradient over `sd`, the standard deviation of each factor: wide
/// enough to average over the kinks of the plant. Production and uptake act almost linearly; their curvature is that of
/// Gauss and Newton.
fn observed(
    setting: &Setting<'_>,
    held: &FixedGains,
    point: &Point,
    sd: &Factors,
) -> Result<Vec<Square>, GapError> {
    let days = &point.information.days;
    let mut slopes: Vec<Square> = days.iter().map(|day| day.curvature).collect();
    for factor in [Factor::Action, Factor::TMaxG, Factor::TMaxI, Factor::AG] {
        let k = factor as usize;
        // Towards the prior's mean, where bodies are.
        let by = if point.factors.0[k] > 0.0 { -sd[k] } else { sd[k] };
        let mut moved = point.factors;
        moved.0[k] += by;
        let moved = Point::at(setting, held, moved)?;
        for (own, day) in slopes.iter_mut().zip(days) {
            let mut there = moved.information.days.iter();
            let Some(there) = there.find(|there| there.index == day.index) else { continue };
            own[k] = std::array::from_fn(|j| (there.gradient[j] - day.gradient[j]) / by);
        }
    }
    let symmetric =
        |own: &Square| square(|row, column| 0.5 * (own[row][column] + own[column][row]));
    Ok(slopes.iter().map(symmetric).collect())
}

/// The largest share of a step that lowers the loss; `None` where the shortest does not.
fn better(
    setting: &Setting<'_>,
    held: &FixedGains,
    point: &Point,
    step: &Factors,
    dependence: f64,
) -> Result<Option<Point>, GapError> {
    let before = point.loss(held, dependence);
    for share in SHARES {
        let factors = std::array::from_fn(|k| point.factors.0[k] + share * step[k]);
        let trial = Point::at(setting, held, PersonalFactors(factors))?;
        if trial.loss(held, dependence) < before {
            return Ok(Some(trial));
        }
    }
    Ok(None)
}
