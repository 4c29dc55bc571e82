//! The ceiling: what the exact course of an effect would name.

use crate::share::among;
use contract::blind_check::{BlindCheck, Ceiling, ExactCourse, Kind, Outcome, PowerRow};

use crate::error::BlindError;

/// Share of the courses of effects that do not act that may be above the bar: the names that are allowed where nothing
/// is missing.
const ALLOWED: f64 = 0.02;

/// The evidence that no larger share of these courses exceeds, nats; 0 where there is none.
fn bar(courses: &[ExactCourse]) -> f64 {
    let idle = courses.iter().filter(|course| !course.acts);
    let mut gains: Vec<f64> = idle.filter_map(|course| course.gain_nats).collect();
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
    let bar = bar(&courses);
    let is_above = |course: &ExactCourse| course.gain_nats.is_some_and(|gain| gain > bar);
    let of_kind = |kind: Kind| -> Vec<(Single<'_>, bool)> {
        let rows = check.worlds.iter().filter(|row| row.kind == kind);
        rows.filter_map(|row| {
            let truth = row.truth.first()?;
            let course = courses.iter().find(|c| c.acts && c.id == row.id)?;
            let shift = truth.achieved_mg_dl;
            let single = Single { effect: &truth.effect, shift, above: is_above(course) };
            Some((single, row.outcome == Outcome::Correct))
        })
        .collect()
    };
    let (singles, outside) = (of_kind(Kind::Single), of_kind(Kind::Outside));
    let moved = |from: f64| singles.iter().filter(move |(single, _)| single.shift >= from);
    let above = |from: f64| among(moved(from), |(single, _)| single.above);
    let right = |from: f64| among(moved(from), |(_, right)| *right);
    let ceiling = Ceiling {
        bar_nats: bar,
        named: above(0.0)?,
        named_at_5: above(5.0)?,
        answered_at_5: right(5.0)?,
        named_at_10: above(10.0)?,
        answered_at_10: right(10.0)?,
        unknown: among(&outside, |(single, _)| single.above)?,
        answered_unknown: among(&outside, |(_, right)| *right)?,
        false_alarms: among(courses.iter().filter(|c| !c.acts), |c| is_above(c))?,
        courses: Vec::new(),
    };
    for row in &mut check.power {
        let within = singles.iter().filter(|(single, _)| single.is_of(row));
        row.ceiling = Some(among(within, |(single, _)| single.above)?);
    }
    check.ceiling = Some(Ceiling { courses, ..ceiling });
    Ok(check)
}

/// A world with one effect.
struct Single<'a> {
    effect: &'a str,
    shift: f64,
    above: bool,
}

impl Single<'_> {
    fn is_of(&self, row: &PowerRow) -> bool {
        row.effect.as_deref().is_none_or(|effect| effect == self.effect)
            && row.from_mg_dl <= self.shift
            && row.to_mg_dl.is_none_or(|to| self.shift < to)
    }
}
