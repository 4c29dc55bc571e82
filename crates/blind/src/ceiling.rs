//! The ceiling: what the exact course of an effect would name.

use std::collections::BTreeMap;

use contract::blind_check::{BlindCheck, Ceiling, CeilingAtBar, ExactCourse, Kind, Outcome};

use crate::error::BlindError;
use crate::share::{among, interval_over_worlds};

/// Share of the courses of effects that do not act that may be above the bar: the names that are allowed where nothing
/// is missing.
const ALLOWED: f64 = 0.02;

/// What the courses of effects that do not act gain, nats, world by world.
fn idle(courses: &[ExactCourse]) -> Vec<Vec<f64>> {
    let mut by_world: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for course in courses.iter().filter(|course| !course.acts) {
        by_world.entry(&course.id).or_default().extend(course.gain_nats);
    }
    by_world.into_values().collect()
}

/// The evidence that no larger share of the courses of these worlds exceeds, nats; 0 where there is none.
fn bar(worlds: &[&Vec<f64>]) -> f64 {
    let mut gains: Vec<f64> = worlds.iter().copied().flatten().copied().collect();
    gains.sort_by(|a, b| b.total_cmp(a));
    gains.get((ALLOWED * gains.len() as f64) as usize).copied().unwrap_or(0.0).max(0.0)
}

/// The same check, with what exact courses would name added to the power.
///
/// # Errors
/// If an interval cannot be formed.
pub fn with_ceiling(
    mut check: BlindCheck,
    courses: Vec<ExactCourse>,
) -> Result<BlindCheck, BlindError> {
    let idle = idle(&courses);
    let interval = interval_over_worlds(&idle, check.master_seed, bar)?;
    let bar = bar(&idle.iter().collect::<Vec<_>>());
    let of_kind = |kind: Kind| -> Vec<Single<'_>> {
        let rows = check.worlds.iter().filter(|row| row.kind == kind);
        rows.filter_map(|row| {
            let truth = row.truth.first()?;
            Some(Single {
                effect: &truth.effect,
                shift: truth.achieved_mg_dl,
                course: courses.iter().find(|c| c.acts && c.id == row.id)?,
                right: row.outcome == Outcome::Correct,
            })
        })
        .collect()
    };
    let (singles, outside) = (of_kind(Kind::Single), of_kind(Kind::Outside));
    let moved = |from: f64| singles.iter().filter(move |single| single.shift >= from);
    let above = |from: f64| among(moved(from), |single| is_above(single.course, bar));
    let right = |from: f64| among(moved(from), |single| single.right);
    let at = |bar: f64| CeilingAtBar {
        bar_nats: bar,
        named_at_5: moved(5.0).filter(|single| is_above(single.course, bar)).count(),
        named_at_10: moved(10.0).filter(|single| is_above(single.course, bar)).count(),
        unknown: outside.iter().filter(|single| is_above(single.course, bar)).count(),
    };
    let ceiling = Ceiling {
        bar_nats: bar,
        at_lower_bar: interval.map(|(lower, _)| at(lower)),
        at_upper_bar: interval.map(|(_, upper)| at(upper)),
        named: above(0.0)?,
        named_at_5: above(5.0)?,
        answered_at_5: right(5.0)?,
        named_at_10: above(10.0)?,
        answered_at_10: right(10.0)?,
        unknown: among(&outside, |single| is_above(single.course, bar))?,
        answered_unknown: among(&outside, |single| single.right)?,
        false_alarms: among(courses.iter().filter(|c| !c.acts), |c| is_above(c, bar))?,
        courses: Vec::new(),
    };
    for row in &mut check.power {
        let within = singles.iter().filter(|single| {
            row.effect.as_deref().is_none_or(|effect| effect == single.effect)
                && row.from_mg_dl <= single.shift
                && row.to_mg_dl.is_none_or(|to| single.shift < to)
        });
        row.ceiling = Some(among(within, |single| is_above(single.course, bar))?);
    }
    check.ceiling = Some(Ceiling { courses, ..ceiling });
    Ok(check)
}

/// A world with one effect.
struct Single<'a> {
    effect: &'a str,
    shift: f64,
    /// The exact course of the effect.
    course: &'a ExactCourse,
    /// Whether the answer is right.
    right: bool,
}

fn is_above(course: &ExactCourse, bar: f64) -> bool {
    course.gain_nats.is_some_and(|gain| gain > bar)
}
