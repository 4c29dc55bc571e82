//! The score of "where": in context and in the equations.
//!
//! *In context*: are the answer's three largest cells truly hot, more often than cells drawn at
//! random; is their sign right; do the answer's intervals hold the truth? *In the equations*: at
//! which rank of the answer's ports is the true one? Worlds whose truth has no hot cell cannot be
//! compared and are counted.

use contract::blind_check::{
    Answer, ContextScore, CoverageScore, EquationScore, Kind, Label, PortCourse, TrueWhere,
    WhereScore, WorldWhere,
};
use contract::diagnosis::{CellFactor, CellGap, CoursePart, PortEvidence};

use std::collections::BTreeMap;

use crate::error::BlindError;
use crate::scored_world::ScoredWorld;
use crate::share::{among, share};
use crate::true_where::{HORIZONS, has_hot_place, hours_of, is_hot, mean_at};

/// Number of cells of an answer that are checked.
const TOP: usize = 3;
/// Factors whose cells say where.
const FACTORS: [CellFactor; 4] =
    [CellFactor::Hour, CellFactor::Context, CellFactor::GlucoseBand, CellFactor::Person];

/// Scores one world; `None` where its label states no truth of "where".
#[must_use]
pub fn world_where(label: &Label, answer: &Answer) -> Option<WorldWhere> {
    let truth = label.gap.as_ref()?;
    let found = [0, 1, 2].map(|horizon| sign_and_chance(truth, answer, horizon));
    let ports = ranked(answer);
    let rank = |port: &str| ports.iter().position(|p| p.port == port).map(|index| index + 1);
    Some(WorldWhere {
        comparable: [0, 1, 2].map(|horizon| has_hot_place(truth, horizon)),
        hit: found.map(|(sign_right, _)| sign_right.is_some()),
        chance: found.map(|(_, chance)| chance),
        sign_right: found.map(|(sign_right, _)| sign_right),
        port_ranks: truth.ports.iter().map(|c| (c.port.clone(), rank(&c.port))).collect(),
    })
}

/// Of the three largest cells after one horizon: whether the sign of the first hot one is right,
/// `None` where none is hot; and by what chance one is hot, `None` where there is no cell.
fn sign_and_chance(
    truth: &TrueWhere,
    answer: &Answer,
    horizon: usize,
) -> (Option<bool>, Option<f64>) {
    let hot = |cell: &CellGap| is_hot(truth, cell.factor.name(), &cell.level, horizon);
    let cells: Vec<(&CellGap, bool)> =
        places(answer).filter_map(|cell| Some((cell, hot(cell)?))).collect();
    let first = cells.iter().take(TOP).find(|(_, hot)| *hot);
    let sign_right = first.map(|(cell, _)| {
        let mean = mean_at(truth, cell.factor.name(), &cell.level, horizon).unwrap_or(0.0);
        cell.expected_mg_dl.unwrap_or(cell.mean_error_mg_dl) * mean > 0.0
    });
    (sign_right, (!cells.is_empty()).then(|| chance(&cells)))
}

/// Probability that at least one of some cells drawn without replacement is hot. As many cells of
/// each factor are drawn as are among the first [`TOP`].
fn chance(cells: &[(&CellGap, bool)]) -> f64 {
    let mut none = 1.0;
    for factor in FACTORS {
        let of = |cell: &&(&CellGap, bool)| cell.0.factor == factor;
        let drawn = cells.iter().take(TOP).filter(of).count();
        let all = cells.iter().filter(of).count();
        let hot = cells.iter().filter(|cell| of(cell) && cell.1).count();
        for k in 0..drawn {
            none *= (all - hot).saturating_sub(k) as f64 / (all - k) as f64;
        }
    }
    1.0 - none
}

/// Cells of an answer that say where, largest share of the gap first.
fn places(answer: &Answer) -> impl Iterator<Item = &CellGap> {
    let mut cells: Vec<&CellGap> =
        answer.cells.iter().filter(|c| FACTORS.contains(&c.factor)).collect();
    cells.sort_by(|a, b| {
        let size = |cell: &CellGap| cell.mean_error_mg_dl.abs();
        b.share_of_gap.total_cmp(&a.share_of_gap).then(size(b).total_cmp(&size(a)))
    });
    cells.into_iter()
}

/// Ports of an answer, the most likely first.
pub(crate) fn ranked(answer: &Answer) -> Vec<&PortEvidence> {
    let mut ports: Vec<&PortEvidence> = answer.ports.iter().collect();
    ports.sort_by(|a, b| {
        b.probability.total_cmp(&a.probability).then(b.gain_nats.total_cmp(&a.gain_nats))
    });
    ports
}

/// Scores the worlds whose labels state the truth of "where", and null worlds for coverage.
///
/// # Errors
/// If an interval cannot be formed.
pub(crate) fn where_score(worlds: &[ScoredWorld]) -> Result<WhereScore, BlindError> {
    let each: Vec<WorldWhere> =
        worlds.iter().filter_map(|w| world_where(&w.label, &w.answer)).collect();
    let context = (0..HORIZONS.len())
        .map(|horizon| context_score(&each, horizon))
        .collect::<Result<_, BlindError>>()?;
    Ok(WhereScore {
        context,
        coverage: coverage_score(worlds)?,
        equations: equation_score(worlds, &each)?,
    })
}

fn context_score(worlds: &[WorldWhere], horizon: usize) -> Result<ContextScore, BlindError> {
    let comparable = || worlds.iter().filter(|w| w.comparable[horizon]);
    let hits = || comparable().filter(|w| w.hit[horizon]);
    Ok(ContextScore {
        minutes: HORIZONS[horizon],
        comparable: among(worlds, |w| w.comparable[horizon])?,
        hit: among(comparable(), |w| w.hit[horizon])?,
        chance: mean(comparable().filter_map(|w| w.chance[horizon])),
        sign_right: among(hits(), |w| w.sign_right[horizon] == Some(true))?,
    })
}

fn coverage_score(worlds: &[ScoredWorld]) -> Result<CoverageScore, BlindError> {
    let held = |world: &ScoredWorld| -> Vec<bool> {
        let truth = world.label.gap.as_ref();
        places(&world.answer)
            .filter_map(|cell| {
                let horizon = HORIZONS.iter().position(|h| *h == cell.horizon_minutes)?;
                let mean = match (world.label.kind, truth) {
                    (Kind::Null, _) => 0.0,
                    (_, Some(truth)) => mean_at(truth, cell.factor.name(), &cell.level, horizon)?,
                    (_, None) => return None,
                };
                Some(cell.lower <= mean && mean <= cell.upper)
            })
            .collect()
    };
    let of = |null: bool| -> Vec<Vec<bool>> {
        let chosen = worlds.iter().filter(|w| (w.label.kind == Kind::Null) == null);
        chosen.map(held).filter(|cells| !cells.is_empty()).collect()
    };
    let (effects, nulls) = (of(false), of(true));
    let cells = |of: &[Vec<bool>]| among(of.iter().flatten(), |held| **held);
    let all = |of: &[Vec<bool>]| among(of, |cells| cells.iter().all(|held| *held));
    Ok(CoverageScore {
        cells: cells(&effects)?,
        worlds: all(&effects)?,
        null_cells: cells(&nulls)?,
        null_worlds: all(&nulls)?,
    })
}

fn equation_score(
    worlds: &[ScoredWorld],
    each: &[WorldWhere],
) -> Result<EquationScore, BlindError> {
    let ranks: Vec<&(String, Option<usize>)> =
        each.iter().flat_map(|world| &world.port_ranks).collect();
    let with_truth: Vec<(&ScoredWorld, &TrueWhere)> =
        worlds.iter().filter_map(|w| Some((w, w.label.gap.as_ref()?))).collect();
    let by_set = with_truth.iter().flat_map(|(world, truth)| {
        let best = ranked(&world.answer).first().copied();
        truth.ports.iter().map(move |course| {
            best.is_some_and(|best| {
                best.port == course.port || best.confusable_with.contains(&course.port)
            })
        })
    });
    let mut by_port: BTreeMap<String, Vec<bool>> = BTreeMap::new();
    for (port, rank) in &ranks {
        by_port.entry(port.clone()).or_default().push(*rank == Some(1));
    }
    let named = with_truth.iter().filter_map(|(world, truth)| {
        let first = world.answer.found.first()?;
        Some(truth.ports.iter().any(|course| course.port == first.port))
    });
    let rightly = with_truth.iter().flat_map(|(world, _)| {
        world.answer.found.iter().filter(|found| world.label.has(&found.effect))
    });
    let courses: Vec<ComparedCourse> = with_truth
        .iter()
        .flat_map(|(world, truth)| truth.ports.iter().map(move |course| (world, course)))
        .filter_map(|(world, course)| {
            let port = world.answer.ports.iter().find(|port| port.port == course.port)?;
            ComparedCourse::of(port, course)
        })
        .collect();
    Ok(EquationScore {
        first: among(&ranks, |(_, rank)| *rank == Some(1))?,
        first_or_in_set: among(by_set, |held| *held)?,
        among_three: among(&ranks, |(_, rank)| rank.is_some_and(|rank| rank <= TOP))?,
        mean_rank: mean(ranks.iter().filter_map(|(_, rank)| Some((*rank)? as f64))),
        mean_listed: mean(with_truth.iter().map(|(w, _)| w.answer.ports.len() as f64)),
        not_listed: among(&ranks, |(_, rank)| rank.is_none())?,
        first_by_port: by_port
            .into_iter()
            .map(|(port, first)| Ok((port, among(first, |first| *first)?)))
            .collect::<Result<_, BlindError>>()?,
        port_of_first_name: among(named, |right| *right)?,
        sign_of_amplitude: among(rightly, |found| found.amplitude.lower > 0.0)?,
        course_answered: share(courses.len(), ranks.len())?,
        course_sign: among(&courses, |course| course.sign)?,
        course_sign_if_certain: among(courses.iter().filter(|c| c.certain), |c| c.sign)?,
        course_parts_held: among(courses.iter().flat_map(|c| &c.held), |held| **held)?,
        courses_held: among(&courses, |course| course.held.iter().all(|held| *held))?,
    })
}

/// A course over the day with the true one.
struct ComparedCourse {
    /// Whether the sign is right where the truth is farthest from its mean.
    sign: bool,
    /// Whether the interval there excludes 0.
    certain: bool,
    /// Whether the interval holds the truth, by part of the day.
    held: Vec<bool>,
}

impl ComparedCourse {
    /// `None` where the answer states no course, or one in another unit.
    fn of(answer: &PortEvidence, truth: &PortCourse) -> Option<Self> {
        if answer.course.is_empty() || answer.unit != truth.unit {
            return None;
        }
        let of_part = |part: &CoursePart| {
            let (first, width) = hours_of(&part.hours)?;
            mean((first..first + width).filter_map(|hour| *truth.by_hour.get(hour % 24)?))
        };
        let values = answer.course.iter().map(of_part).collect::<Option<Vec<f64>>>()?;
        let usual = mean(values.iter().copied())?;
        let parts = || answer.course.iter().zip(values.iter().map(|value| value - usual));
        let (part, value) = parts().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        Some(Self {
            sign: part.value * value > 0.0,
            certain: part.lower > 0.0 || part.upper < 0.0,
            held: parts().map(|(p, value)| (p.lower..=p.upper).contains(&value)).collect(),
        })
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, n) = values.fold((0.0, 0_usize), |(sum, n), value| (sum + value, n + 1));
    (n > 0).then(|| sum / n as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planted::cell;

    #[test]
    fn chance_draws_as_many_cells_of_each_factor_without_putting_them_back() {
        let (hour, context) = (cell(CellFactor::Hour, "", 1.0), cell(CellFactor::Context, "", 1.0));
        // Two hours and a context come first; one of four hours is hot, and one of two contexts.
        let cells = [
            (&hour, false),
            (&context, false),
            (&hour, true),
            (&hour, false),
            (&context, true),
            (&hour, false),
        ];
        // No hot hour in two of four: 3/4 x 2/3; no hot context in one of two: 1/2.
        assert!((chance(&cells) - 0.75).abs() < 1e-12); // rounding
        assert!((chance(&[(&hour, true)]) - 1.0).abs() < 1e-12);
        assert_eq!(chance(&[(&hour, false)]), 0.0);
    }
}
