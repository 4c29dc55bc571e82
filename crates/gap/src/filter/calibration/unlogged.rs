//! What a log leaves open: meals that were eaten and are not in it.
//!
//! A day left out takes its evidence along. A meal left out does not: its glucose stays, and is taken for that of other
//! factors. How far factors go is seen where logged meals are struck, a share of them at a time.

use super::equations::NormalEquations;
use super::search::{Held, Point};
use super::{Factors, PersonalFactors, Setting, Square};
use crate::error::GapError;

/// Meals a day that are eaten and not logged: 0.2 to 1 a day, Burdick et al., Pediatrics 2004;113:e221; Samadi et al.,
/// Diabetes Technol Ther 2018;20:235. The value is that of the effect `missed_meals` at its usual size.
const UNLOGGED_PER_DAY: f64 = 0.4;
/// Sets into which logged meals are dealt in turn, each struck once: one meal in ten, about as many as go unlogged.
const SETS: usize = 10;

/// Second moment of what unlogged meals would change in the factors at `point`; 0 where no meal is logged.
///
/// `gains` are the factors whose gains are held. Unlogged meals count as independent and like the logged ones, which move the
/// factors by d when struck. With r unlogged meals for a logged one, the moment is r sum(d d') + r^2 sum(d) sum(d)':
/// what a number of meals that follows Poisson's law scatters about its mean, and the mean, for which nothing
/// corrects the factors. sum(d d') is that of the sets about their mean and of the mean.
pub(super) fn unlogged(
    setting: &Setting<'_>,
    gains: &PersonalFactors,
    point: &Point,
    dependence: f64,
) -> Square {
    let inputs = setting.record.inputs.iter().enumerate();
    let meals: Vec<usize> =
        inputs.filter(|(_, input)| input.carbs.0 > 0.0).map(|(step, _)| step).collect();
    let sets = SETS.min(meals.len());
    // The step that is left without a strike is none of a strike's.
    let left = NormalEquations::of(&point.information, dependence, &point.factors)
        .step(&point.factors, setting);
    let Ok(left) = left else { return Square::default() };
    // A set without which the record cannot be filtered says nothing.
    let moves: Vec<Factors> = (0..sets)
        .filter_map(|set| {
            let struck: Vec<usize> = meals.iter().copied().skip(set).step_by(sets).collect();
            moved(setting, gains, point, &left, &struck).ok()
        })
        .collect();
    let days = setting.record.len() as f64 / physiology::STEPS_PER_DAY as f64;
    second_moment(&moves, meals.len() as f64, UNLOGGED_PER_DAY * days)
}

/// How far the search goes from `point` without the meals at some steps, in two steps: the first under the gains of the
/// struck log, the second under gains that follow the first. That is 0.7 to 1.1 of how far the whole search of real
/// people goes (root mean squares, factors that strikes move).
fn moved(
    setting: &Setting<'_>,
    gains: &PersonalFactors,
    point: &Point,
    left: &Factors,
    struck: &[usize],
) -> Result<Factors, GapError> {
    let mut record = setting.record.clone();
    for step in struck {
        record.inputs[*step].carbs.0 = 0.0;
    }
    let setting = Setting { record: &record, scored: setting.scored.clone(), ..*setting };
    let step = |by: &Factors| {
        let beyond = |factors: &PersonalFactors| PersonalFactors(sum(&factors.0, by));
        let held = Held::of(&setting, &beyond(gains))?;
        let there = Point::at(&setting, &held, beyond(&point.factors))?;
        let dependence = there.information.dependence().ok_or_else(|| setting.singular())?;
        NormalEquations::of(&there.information, dependence, &there.factors)
            .step(&there.factors, &setting)
    };
    let first = sum(&step(&Factors::default())?, &left.map(|left| -left));
    Ok(sum(&first, &step(&first)?))
}

fn sum(a: &Factors, b: &Factors) -> Factors {
    std::array::from_fn(|k| a[k] + b[k])
}

/// Of the sum over `unlogged` meals, given moves by sets that together hold `logged` ones.
fn second_moment(moves: &[Factors], logged: f64, unlogged: f64) -> Square {
    let sets = moves.len() as f64;
    if moves.is_empty() {
        return Square::default();
    }
    let sum = moves.iter().fold(Factors::default(), |all, one| sum(&all, one));
    let ratio = unlogged / logged;
    let entry = |row: usize, column: usize| {
        let apart = |m: &Factors| (m[row] - sum[row] / sets) * (m[column] - sum[column] / sets);
        let about = sets / (sets - 1.0).max(1.0) * moves.iter().map(apart).sum::<f64>();
        let product = sum[row] * sum[column];
        ratio * (about + product / logged) + ratio * ratio * product
    };
    std::array::from_fn(|row| std::array::from_fn(|column| entry(row, column)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn along_the_first(moves: impl IntoIterator<Item = f64>) -> Vec<Factors> {
        let one = |by| std::array::from_fn(|k| if k == 0 { by } else { 0.0 });
        moves.into_iter().map(one).collect()
    }

    /// Forty meals that move a factor by 0.01 each, and as many as cancel.
    #[test]
    fn the_moment_is_that_of_a_number_of_meals_by_poisson() {
        let alike = along_the_first([0.04; 10]);
        // Eight meals: mean 0.08, variance 8 * 0.01^2.
        let found = second_moment(&alike, 40.0, 8.0)[0][0];
        assert!((found - (0.08_f64.powi(2) + 8.0 * 1e-4)).abs() < 1e-12, "{found}"); // rounding
        // Ten meals of 0.1, half of them the other way.
        let mixed = along_the_first((0..10).map(|k| if k % 2 == 0 { 0.1 } else { -0.1 }));
        let found = second_moment(&mixed, 10.0, 2.0)[0][0];
        // n / (n - 1) of ten.
        assert!((found - 2.0 * 0.01 * 10.0 / 9.0).abs() < 1e-12, "{found}"); // rounding
        assert_eq!(second_moment(&[], 0.0, 2.0), Square::default());
    }
}
