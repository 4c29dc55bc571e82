//! Where the gap lies: cell means with simultaneous intervals and family-wise p-values.
//!
//! Every person and day gives, for every cell, a number of errors and their sum. A cell's gap is the
//! mean over people of each person's mean error. Its standard error has two levels: blocks of days
//! within a person give the variance of the person's mean, and the spread of the means between
//! people gives its inflation, which is moderated over the cells of the family (empirical Bayes,
//! Smyth 2004). The statistic is referred to Student's t with the degrees of freedom that this
//! leaves. The family is adjusted by the step-down maximum of Westfall and Young (1993) over a
//! multiplier bootstrap (Chernozhukov, Chetverikov and Kato 2013): every person's blocks of days
//! carry Gaussian weights, the same in all cells, so that the dependence between cells is kept.
//!
//! Resampled people alone would answer the same question; with three to ten people that has little
//! power, because each cell must show its spread between people by itself.
//! With a single person, days alone count and the intervals speak of that person.

pub(crate) mod day_cells;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

pub use self::day_cells::{DayCells, LocalisationRule};
use crate::cell_sample::{Residual, Sample, Tested};
use crate::moderation::VariancePrior;

/// The gap of a cell within its family.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellEstimate {
    /// Mean over people of each person's mean error.
    pub mean: f64,
    /// Lower end of the simultaneous interval.
    pub lower: f64,
    /// Upper end of the simultaneous interval.
    pub upper: f64,
    /// p-value, adjusted for the family.
    pub p_adjusted: f64,
    /// People who contribute.
    pub people: usize,
    /// Errors that contribute.
    pub errors: usize,
}

/// Tests a family of cells over people; `people[p][d]` is day `d` of person `p`.
///
/// `error_rate` is that of this family. A cell is `None` where fewer than two of several people (or
/// not the only one) have enough errors in it, or where they do not vary.
#[must_use]
pub fn over_people(
    people: &[Vec<DayCells>],
    rule: &LocalisationRule,
    error_rate: f64,
    seed: u64,
) -> Vec<Option<CellEstimate>> {
    let needed = people.len().min(2);
    let cells = people.iter().flatten().map(|day| day.counts.len()).max().unwrap_or(0);
    let samples: Vec<Option<Sample>> = (0..cells)
        .map(|cell| Sample::of(people, cell, rule).filter(|sample| sample.people >= needed))
        .collect();
    let ratios: Vec<(f64, f64)> =
        samples.iter().flatten().map(|s| (s.ratio(), s.between_degrees())).collect();
    let prior = VariancePrior::fitted(&ratios);
    let mut tested: Vec<Option<Tested>> = samples
        .into_iter()
        .map(|sample| sample.map(|sample| sample.tested(prior, ratios.len())))
        .collect();
    if people.len() == 1 {
        // The few blocks of one person cannot tell how the cells depend on each other; independent
        // cells are the careful assumption.
        for (cell, tested) in tested.iter_mut().enumerate() {
            tested.iter_mut().for_each(|tested| tested.owned_by(cell));
        }
    }
    step_down(&tested, rule.replicates, error_rate, seed)
}

/// Tests the people themselves, a cell each: is this person's mean error in cell `cell` zero?
///
/// Only days vary; the family is all people.
#[must_use]
pub fn of_each_person(
    people: &[Vec<DayCells>],
    cell: usize,
    rule: &LocalisationRule,
    error_rate: f64,
    seed: u64,
) -> Vec<Option<CellEstimate>> {
    let tested: Vec<Option<Tested>> = people
        .iter()
        .enumerate()
        .map(|(index, days)| {
            let sample = Sample::of(std::slice::from_ref(days), cell, rule)?;
            let mut tested = sample.tested(None, 0);
            tested.owned_by(index);
            Some(tested)
        })
        .collect();
    step_down(&tested, rule.replicates, error_rate, seed)
}

/// Absolute standard normal deviates of every cell, joint over cells, in one replicate.
fn replicate(tested: &[Option<Tested>], blocks: &[usize], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let weights: Vec<Vec<f64>> = blocks
        .iter()
        .map(|count| (0..*count).map(|_| StandardNormal.sample(rng)).collect())
        .collect();
    tested
        .iter()
        .map(|cell| {
            let Some(cell) = cell else { return 0.0 };
            let (mut sum, mut squares) = (0.0, 0.0);
            for Residual { block: (person, block), value } in &cell.sample.residuals {
                sum += weights[*person][*block] * value;
                squares += value * value;
            }
            sum.abs() / squares.sqrt()
        })
        .collect()
}

fn step_down(
    tested: &[Option<Tested>],
    replicates: usize,
    error_rate: f64,
    seed: u64,
) -> Vec<Option<CellEstimate>> {
    let sizes: Vec<f64> =
        tested.iter().map(|c| c.as_ref().map_or(0.0, Tested::normal_size)).collect();
    let mut falling: Vec<usize> = (0..tested.len()).filter(|c| tested[*c].is_some()).collect();
    falling.sort_by(|a, b| sizes[*b].total_cmp(&sizes[*a]));
    let mut blocks: Vec<usize> = Vec::new();
    for residual in tested.iter().flatten().flat_map(|cell| &cell.sample.residuals) {
        let (person, block) = residual.block;
        blocks.resize(blocks.len().max(person + 1), 0);
        blocks[person] = blocks[person].max(block + 1);
    }
    // Running maxima from the weakest cell up, one row a replicate.
    let rows: Vec<Vec<f64>> = (0..replicates)
        .into_par_iter()
        .map(|index| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(index as u64);
            let mut row = replicate(tested, &blocks, &mut rng);
            let mut maximum: f64 = 0.0;
            for cell in falling.iter().rev() {
                maximum = maximum.max(row[*cell]);
                row[*cell] = maximum;
            }
            row
        })
        .collect();
    let Some(strongest) = falling.first() else { return vec![None; tested.len()] };
    let mut maxima: Vec<f64> = rows.iter().map(|row| row[*strongest]).collect();
    maxima.sort_by(f64::total_cmp);
    let rank = ((1.0 - error_rate) * (maxima.len() + 1) as f64).ceil() as usize;
    let critical = maxima[rank.clamp(1, maxima.len()) - 1];

    let mut estimates = vec![None; tested.len()];
    let mut so_far: f64 = 0.0;
    for cell_index in falling {
        let Some(cell) = &tested[cell_index] else { continue };
        let reached = rows.iter().filter(|row| row[cell_index] >= sizes[cell_index]).count();
        so_far = so_far.max((reached + 1) as f64 / (rows.len() + 1) as f64);
        let half = cell.own_size(critical) * cell.error;
        estimates[cell_index] = Some(CellEstimate {
            mean: cell.sample.mean,
            lower: cell.sample.mean - half,
            upper: cell.sample.mean + half,
            p_adjusted: so_far,
            people: cell.sample.people,
            errors: cell.sample.errors as usize,
        });
    }
    estimates
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::GapError;

    /// People with `cells` cells of four errors a day; `between` and `within` are standard
    /// deviations of a person's and of a day's mean; cell 0 is shifted by `shift`.
    fn cohort(
        seed: u64,
        people: usize,
        days: usize,
        cells: usize,
        (between, within): (f64, f64),
        shift: f64,
    ) -> Vec<Vec<DayCells>> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        (0..people)
            .map(|_| {
                let person: Vec<f64> = (0..cells)
                    .map(|c| between * normal() + if c == 0 { shift } else { 0.0 })
                    .collect();
                (0..days)
                    .map(|_| {
                        let mut day = DayCells::empty(cells);
                        for (cell, mean) in person.iter().enumerate() {
                            for _ in 0..4 {
                                let error = mean + within * normal();
                                day.add(cell, error);
                            }
                        }
                        day
                    })
                    .collect()
            })
            .collect()
    }

    fn false_alarms(worlds: u64, people: usize, spread: (f64, f64), cells: usize) -> f64 {
        let rule = LocalisationRule { replicates: 200, ..LocalisationRule::working() };
        let alarms = (0..worlds)
            .filter(|world| {
                over_people(&cohort(*world, people, 10, cells, spread, 0.0), &rule, 0.05, *world)
                    .iter()
                    .flatten()
                    .any(|cell| cell.p_adjusted <= 0.05)
            })
            .count();
        alarms as f64 / worlds as f64
    }

    #[test]
    fn false_alarms_are_at_their_nominal_rate() {
        // People alike, people who differ, and people who differ more than their days; 20 cells.
        let cases = [
            (1, (0.0, 1.0)),
            (3, (0.0, 1.0)),
            (3, (1.0, 0.1)),
            (5, (0.3, 1.0)),
            (8, (0.0, 1.0)),
            (8, (1.0, 0.1)),
        ];
        for (people, spread) in cases {
            let rate = false_alarms(300, people, spread, 20);
            // Binomial: 5 % and 3.3 standard errors of 1.26 %, once in 2,000.
            assert!(rate < 0.0915, "{people} people, spread {spread:?}: {rate}");
        }
    }

    #[test]
    fn a_shift_is_found_in_its_cell_alone_and_covered() {
        let rule = LocalisationRule { replicates: 500, ..LocalisationRule::working() };
        let (mut found, mut covered) = (0, 0);
        for world in 0..40 {
            let people = cohort(world, 3, 14, 20, (0.1, 1.0), 1.0);
            let cells = over_people(&people, &rule, 0.05, world);
            let shifted = cells[0].expect("everyone has errors in it");
            found += usize::from(shifted.p_adjusted <= 0.05 && shifted.lower > 0.0);
            let holds = |(index, cell): (usize, &Option<CellEstimate>)| {
                let truth = if index == 0 { 1.0 } else { 0.0 };
                cell.is_some_and(|c| c.lower <= truth && truth <= c.upper)
            };
            covered += usize::from(cells.iter().enumerate().all(holds));
        }
        // The mean's standard error is 0.1, so a shift of 1 is ten of them.
        assert_eq!(found, 40);
        // Joint coverage of 95 %: fewer than 33 of 40 happen in 0.04 % of such tests.
        assert!(covered >= 33, "{covered} of 40 worlds covered jointly");
    }

    #[test]
    fn a_cell_with_too_little_is_left_out() {
        let rule = LocalisationRule::working();
        let mut people = cohort(1, 3, 6, 2, (0.1, 1.0), 0.0);
        for person in &mut people[..2] {
            for day in person.iter_mut() {
                (day.counts[1], day.sums[1]) = (0.0, 0.0);
            }
        }
        let cells = over_people(&people, &rule, 0.05, 1);
        assert_eq!(cells[0].map(|c| (c.people, c.errors)), Some((3, 72)));
        assert_eq!(cells[1], None, "one of three people is not a cohort");
        let alone = of_each_person(&people, 1, &rule, 0.05, 1);
        assert!(alone[0].is_none() && alone[1].is_none() && alone[2].is_some());
        assert_eq!(over_people(&[], &rule, 0.05, 1), Vec::new());
    }

    #[test]
    fn settings_that_cannot_be_are_named() {
        let working = LocalisationRule::working();
        assert!(working.validated().is_ok());
        for (rule, name) in [
            (LocalisationRule { replicates: 10, ..working }, "replicates"),
            (LocalisationRule { block_days: 0, ..working }, "block_days"),
            (LocalisationRule { error_rate: 1.0, ..working }, "error_rate"),
        ] {
            let error = rule.validated().expect_err(name);
            assert!(matches!(error, GapError::Setting { name: found, .. } if found == name));
        }
    }
}
