//! What a log leaves open: meals that were eaten and are not in it.
//!
//! A day left out takes its evidence along. A meal left out does not: its glucose stays, and is taken for that of other
//! factors. How far factors go is seen where logged meals are struck, a share of them at a time.

use super::information::{DayInformation, square};
use super::point::{OwnGains, scaled};
use super::{Factors, Setting, Square, directions};
use crate::filter::observations::Observations;
use crate::filter::scored::normalised;
use crate::filter::tangent::without_meals;

/// Meals a day that are eaten and not logged: 0.2 to 1 a day, Burdick et al., Pediatrics 2004;113:e221; Samadi et al.,
/// Diabetes Technol Ther 2018;20:235. The value is that of the effect `missed_meals` at its usual size.
const UNLOGGED_PER_DAY: f64 = 0.4;
/// Logged meals a day that are struck at most, spread evenly over the log.
const STRUCK_PER_DAY: usize = 6;
/// Steps for which a filter is followed without a meal: 8 h, after which less than 2 % of a meal is left to come even
/// where the gut takes twice as long as everybody's.
const REACH: usize = 96;

/// The steps of the meals that are struck, one at a time.
pub(super) fn meals(record: &Observations) -> Vec<usize> {
    let inputs = record.inputs.iter().enumerate();
    let meals: Vec<usize> =
        inputs.filter(|(_, input)| input.carbs.0 > 0.0).map(|(step, _)| step).collect();
    let count = meals.len().min(STRUCK_PER_DAY * record.len().div_ceil(physiology::STEPS_PER_DAY));
    (0..count).map(|index| meals[index * meals.len() / count]).collect()
}

/// Second moment of what unlogged meals would change in the factors; 0 where no meal is logged.
///
/// `left` is the step that is left with every logged meal. Unlogged meals count as independent and like the logged ones,
/// which move the factors by d when struck. With u unlogged meals the moment is u mean(d d') + u^2 mean(d) mean(d)':
/// what a number of meals that follows Poisson's law scatters about its mean, and the mean, for which nothing
/// corrects the factors.
///
/// A move is one step of the search without the meal, with the gains and the derivatives that the filter has then; the
/// whitening is held. That is 0.5 of how far the whole search goes for the time of insulin, 0.65 to 1.1 for the other factors that
/// strikes move (root mean squares, real and made people). Meals are struck on their own, so that the filter need be
/// followed only where it changes.
pub(super) fn unlogged(
    setting: &Setting<'_>,
    own: &OwnGains,
    dependence: f64,
    left: &Factors,
) -> Square {
    let OwnGains { model, held, point, forks } = own;
    let directions = directions();
    let whitening = &held.whitening;
    let (mut z, mut signatures) = (point.z.clone(), point.signatures.clone());
    let mut moves = Vec::with_capacity(forks.len());
    without_meals(model, setting.record, &directions, forks, REACH, |step, innovations, rows| {
        let window = step..step + innovations.len();
        // What is whitened after the window still uses entries of it.
        let tail = window.end + 2 * whitening.autoregression.spacing;
        let all = window.start..tail.min(z.len());
        let mut change = DayInformation::default();
        change.add(whitening, &z, &signatures, all.clone(), -1.0);
        let scored = &setting.scored[window.clone()];
        z[window.clone()].copy_from_slice(&normalised(innovations, scored));
        for (k, row) in window.clone().zip(scaled(innovations, rows)) {
            signatures[k] = row;
        }
        change.add(whitening, &z, &signatures, all, 1.0);
        z[window.clone()].copy_from_slice(&point.z[window.clone()]);
        signatures[window.clone()].copy_from_slice(&point.signatures[window]);
        let information = point.information.changed(&change);
        // A meal without which the equations have no solution says nothing.
        if let Ok(step) = information.step(dependence, &point.factors, setting) {
            moves.push(std::array::from_fn(|k| step[k] - left[k]));
        }
    });
    let days = setting.record.len() as f64 / physiology::STEPS_PER_DAY as f64;
    second_moment(&moves, UNLOGGED_PER_DAY * days)
}

/// Of the sum over `unlogged` meals that move the factors like those struck.
fn second_moment(moves: &[Factors], unlogged: f64) -> Square {
    if moves.is_empty() {
        return Square::default();
    }
    let count = moves.len() as f64;
    let mean: Factors =
        std::array::from_fn(|k| moves.iter().map(|one| one[k]).sum::<f64>() / count);
    square(|row, column| {
        let each = moves.iter().map(|one| one[row] * one[column]).sum::<f64>() / count;
        unlogged * each + unlogged * unlogged * mean[row] * mean[column]
    })
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
        let alike = along_the_first([0.01; 40]);
        // Eight meals: mean 0.08, variance 8 * 0.01^2.
        let found = second_moment(&alike, 8.0)[0][0];
        assert!((found - (0.08_f64.powi(2) + 8.0 * 1e-4)).abs() < 1e-12, "{found}"); // rounding
        // Ten meals of 0.1, half of them the other way.
        let mixed = along_the_first((0..10).map(|k| if k % 2 == 0 { 0.1 } else { -0.1 }));
        let found = second_moment(&mixed, 2.0)[0][0];
        assert!((found - 2.0 * 0.01).abs() < 1e-12, "{found}"); // rounding
        assert_eq!(second_moment(&[], 2.0), Square::default());
    }
}
