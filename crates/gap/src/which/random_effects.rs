//! Random effects: a factor that is drawn for every unit (a day), scored on days held out.
//!
//! What a unit's factor does to the innovations does not end with the unit: insulin of the evening acts in
//! the small hours of the next day. Each unit therefore has a signature of its own, and neighbours share
//! steps. Constant directions and the random factors of the background are integrated out; what is left of the units, information G
//! and scores h, gives the likelihood of a spread s over none,
//!
//! ```text
//! log L(s) = s^2 h'(I + s^2 G)^-1 h / 2 - log|I + s^2 G| / 2
//! ```
//!
//! The spread is the same for everybody. It is chosen without the days of a fold, which then tell by how much it raises
//! their likelihood given the days around them.

use std::ops::Range;

use effects::{EffectId, Field};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use physiology::STEPS_PER_DAY;
use rayon::prelude::*;

use super::folds::{FOLDS, fold};
use super::statistics::{BLOCK, Sums, TestStatistics};
use super::variance::{Spreads, active, crossed, factored};
use super::{Score, Test, index_of_largest};
use crate::background::Allowed;
use crate::design::{Design, UnitBank};
use crate::log_sum::{moments, raised};

/// Spreads that are tried, of the logarithm of the factor.
const GRID: [f64; 16] =
    [0.0, 0.03, 0.05, 0.07, 0.09, 0.11, 0.13, 0.15, 0.18, 0.21, 0.25, 0.3, 0.35, 0.4, 0.5, 0.6];

/// Sums over the steps of a day that involve the units which reach into it.
#[derive(Debug, Clone)]
struct UnitDay {
    /// Those units.
    units: Range<usize>,
    /// Products with the signatures of the background's random factors, by block: (random, units).
    za: Vec<Mat<f64>>,
    /// Products with the columns of the design: (columns, units).
    cross: Mat<f64>,
    /// Products with each other.
    gram: Mat<f64>,
    /// Scores.
    score: Vec<f64>,
}

/// What one random effect needs of a person.
#[derive(Debug, Clone)]
pub(super) struct UnitSums {
    /// The effect.
    pub(super) effect: EffectId,
    /// What varies.
    pub(super) field: Field,
    /// Standard deviation of its logarithm at amplitude 1.
    pub(super) log_sd: f64,
    count: usize,
    days: Vec<UnitDay>,
}

/// A person for the test of a random effect; `units` is `None` where the record cannot show it.
pub(super) struct UnitTrial<'a> {
    pub(super) person: &'a TestStatistics,
    pub(super) units: Option<&'a UnitSums>,
    /// Constant directions that are allowed for.
    pub(super) allowed: Vec<Allowed>,
}

impl UnitSums {
    /// Sums up the answers of a bank over the days of a design.
    pub(super) fn of(design: &Design, person: &TestStatistics, bank: &UnitBank) -> Self {
        let steps = design.residuals.len();
        let days = (0..steps.div_ceil(STEPS_PER_DAY))
            .map(|day| {
                let first = day * STEPS_PER_DAY;
                UnitDay::of(design, person, bank, first..(first + STEPS_PER_DAY).min(steps))
            })
            .collect();
        Self {
            effect: bank.effect,
            field: bank.field,
            log_sd: bank.log_sd,
            count: bank.starts.len(),
            days,
        }
    }
}

impl UnitDay {
    fn of(design: &Design, person: &TestStatistics, bank: &UnitBank, steps: Range<usize>) -> Self {
        // Starts ascend, so that the units that reach into a day are neighbours.
        let begin = bank
            .starts
            .iter()
            .zip(&bank.answers)
            .position(|(start, answer)| start + answer.len() > steps.start)
            .unwrap_or(bank.starts.len());
        let end = bank.starts.iter().position(|s| *s >= steps.end).unwrap_or(bank.starts.len());
        let units = begin..end.max(begin);
        let count = units.len();
        let scored: Vec<usize> = steps.clone().filter(|k| design.weights[*k] > 0.0).collect();
        let answers = Mat::from_fn(scored.len(), count, |row, unit| {
            let (step, unit) = (scored[row], units.start + unit);
            let value = step.checked_sub(bank.starts[unit]).and_then(|k| bank.answers[unit].get(k));
            f64::from(value.copied().unwrap_or(0.0))
        });
        let weighted = Mat::from_fn(scored.len(), count, |row, unit| {
            design.weights[scored[row]] * answers[(row, unit)]
        });
        // Signatures of the scored steps, one column after the other.
        let mut signatures = Mat::<f64>::zeros(scored.len(), design.columns.len());
        for (to, from) in signatures.col_iter_mut().zip(&design.signatures) {
            for (to, step) in to.iter_mut().zip(&scored) {
                *to = f64::from(from[*step]);
            }
        }
        let cross = signatures.transpose() * &weighted;
        let za = (steps.start..steps.end)
            .step_by(BLOCK)
            .map(|from| {
                let row = |step: usize| scored.partition_point(|scored| *scored < step);
                let (first, end) = (row(from), row((from + BLOCK).min(steps.end)));
                let random = Mat::from_fn(end - first, person.random.len(), |row, k| {
                    signatures[(first + row, person.random[k])]
                });
                random.transpose() * weighted.as_ref().subrows(first, end - first)
            })
            .collect();
        let score = (0..count)
            .map(|unit| {
                let rows = scored.iter().enumerate();
                -rows.map(|(row, k)| design.residuals[*k] * weighted[(row, unit)]).sum::<f64>()
            })
            .collect();
        Self { units, za, cross, gram: answers.transpose() * &weighted, score }
    }
}

impl UnitTrial<'_> {
    /// Joint sums of each fold, of constant directions and then of units; random factors of the background integrated
    /// out.
    fn folds(&self, sums: &UnitSums, spreads: &Spreads) -> Vec<Sums> {
        let (person, allowed) = (self.person, &self.allowed);
        let n = allowed.len();
        (0..FOLDS)
            .map(|index| {
                let mut joint = Sums::none(n + sums.count);
                let whole = &person.folds[index];
                for (i, row) in allowed.iter().enumerate() {
                    joint.b[i] = whole.b[row.column];
                    for (j, column) in allowed.iter().enumerate() {
                        joint.a[(i, j)] = whole.a[(row.column, column.column)];
                    }
                }
                for day in fold(person.days.len(), index) {
                    self.add_day(&mut joint, day, &sums.days[day], spreads);
                }
                joint
            })
            .collect()
    }

    fn add_day(&self, joint: &mut Sums, index: usize, units: &UnitDay, spreads: &Spreads) {
        let n = self.allowed.len();
        let first = n + units.units.start;
        let count = units.units.len();
        for unit in 0..count {
            joint.b[first + unit] += units.score[unit];
            for (i, allowed) in self.allowed.iter().enumerate() {
                joint.a[(i, first + unit)] += units.cross[(allowed.column, unit)];
                joint.a[(first + unit, i)] += units.cross[(allowed.column, unit)];
            }
            for other in 0..count {
                joint.a[(first + unit, first + other)] += units.gram[(unit, other)];
            }
        }
        let day = &self.person.days[index];
        let active = active(spreads, day.za.len());
        if active.is_empty() {
            return;
        }
        let factor = factored(day, &self.person.random, &active);
        let (constant, z) = crossed(day, &active);
        // What random factors share with directions and units: (active, directions and units).
        let shared = Mat::from_fn(active.len(), n + count, |row, column| {
            if column < n {
                return constant[(row, self.allowed[column].column)];
            }
            let (block, factor, spread) = active[row];
            let of = |k: usize| units.za[k][(factor, column - n)];
            spread * block.map_or_else(|| (0..units.za.len()).map(of).sum(), of)
        });
        let solved = factor.solve(&shared);
        let taken = shared.transpose() * &solved;
        let scores = solved.transpose() * &z;
        let at = |k: usize| if k < n { k } else { first + k - n };
        for row in 0..n + count {
            joint.b[at(row)] -= scores[(row, 0)];
            for column in 0..n + count {
                joint.a[(at(row), at(column))] -= taken[(row, column)];
            }
        }
    }

    /// Likelihoods of every spread of [`GRID`] over none, constant directions integrated out.
    fn likelihoods(&self, joint: &Sums) -> Vec<f64> {
        let n = self.allowed.len();
        let units = joint.b.len() - n;
        let mut system = joint.a.get(..n, ..n).to_owned();
        let shared = |i: usize, k: usize| if k < units { joint.a[(i, n + k)] } else { joint.b[i] };
        let mut right = Mat::from_fn(n, units + 1, shared);
        for (i, allowed) in self.allowed.iter().enumerate() {
            system[(i, i)] += allowed.sd.powi(-2);
            right[(i, units)] += allowed.mean * allowed.sd.powi(-2);
        }
        let solved = system
            .llt(Side::Lower)
            .expect("a Gram matrix plus the precision of a proper prior")
            .solve(&right);
        let taken = joint.a.get(n.., ..n) * &solved;
        let gram = Mat::from_fn(units, units, |i, j| joint.a[(n + i, n + j)] - taken[(i, j)]);
        let score = Mat::from_fn(units, 1, |i, _| joint.b[n + i] - taken[(i, units)]);
        GRID.iter().map(|spread| likelihood(&gram, &score, *spread)).collect()
    }
}

/// Likelihood of a spread over none, nats.
fn likelihood(gram: &Mat<f64>, score: &Mat<f64>, spread: f64) -> f64 {
    let variance = spread * spread;
    let n = gram.nrows();
    let m = Mat::from_fn(n, n, |i, j| variance * gram[(i, j)] + f64::from(u8::from(i == j)));
    let factor = m.llt(Side::Lower).expect("the identity plus a Gram matrix");
    let explained = (score.transpose() * factor.solve(score))[(0, 0)];
    let logs: f64 = (0..n).map(|i| factor.L()[(i, i)].ln()).sum();
    0.5 * variance * explained - logs
}

/// Log likelihoods of the spreads of [`GRID`] on all days of a person, and without each fold.
type GridLikelihoods = (Vec<f64>, Vec<Vec<f64>>);

/// Tests a random effect. `shown` is what somebody's record holds of it; `spreads` are those of the background, without the
/// factor that is tested.
pub(super) fn score(shown: &UnitSums, trials: &[UnitTrial<'_>], spreads: &Spreads) -> Score {
    let found: Vec<Option<GridLikelihoods>> = trials
        .par_iter()
        .map(|trial| {
            let folds = trial.folds(trial.units?, spreads);
            let all = Sums::over(&folds, None);
            let without = folds.iter().map(|fold| {
                let mut rest = all.clone();
                rest.add(fold, -1.0);
                trial.likelihoods(&rest)
            });
            Some((trial.likelihoods(&all), without.collect()))
        })
        .collect();
    let mut gains = vec![0.0; trials.len()];
    for index in 0..FOLDS {
        let training: Vec<f64> = (0..GRID.len())
            .map(|k| found.iter().flatten().map(|(_, without)| without[index][k]).sum())
            .collect();
        let best = index_of_largest(&training);
        for ((gain, trial), found) in gains.iter_mut().zip(trials).zip(&found) {
            let days = trial.person.days.len();
            let test = fold(days, index);
            let Some((all, without)) = found else { continue };
            if !test.is_empty() && test.len() < days {
                *gain += all[best] - without[index][best];
            }
        }
    }
    let total: Vec<f64> =
        (0..GRID.len()).map(|k| found.iter().flatten().map(|(all, _)| all[k]).sum()).collect();
    let (spread, error) = posterior(&total);
    let amplitude = (spread / shown.log_sd, error / shown.log_sd);
    let personal = vec![amplitude; trials.len()];
    Score { amplitude, personal, ..Score::of(shown.effect, Test::Random, gains) }
}

/// Mean and standard deviation of the spread under an even prior.
fn posterior(likelihoods: &[f64]) -> (f64, f64) {
    let last = GRID.len() - 1;
    let width = |k: usize| GRID[(k + 1).min(last)] - GRID[k.saturating_sub(1)];
    let raised = raised(likelihoods);
    let weights: Vec<f64> = raised.iter().enumerate().map(|(k, r)| width(k) * r).collect();
    moments(&weights, GRID)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::design::Column;
    use crate::which::statistics::{RANDOM, RandomFactor};

    const DAYS: usize = 14;

    /// A person of a fortnight in whom a factor of every day acts into the next with a spread of `sd`.
    fn design(sd: f64, stream: u64) -> Design {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        rng.set_stream(stream);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let steps = DAYS * STEPS_PER_DAY;
        let answer: Vec<f64> = (0..2 * STEPS_PER_DAY)
            .map(|k| (0.05 * k as f64).sin() * (-(k as f64) / 200.0).exp())
            .collect();
        let starts: Vec<usize> = (0..DAYS).map(|day| day * STEPS_PER_DAY).collect();
        let mut residuals: Vec<f64> = (0..steps).map(|_| normal()).collect();
        for start in &starts {
            let log = sd * normal();
            for (residual, a) in residuals[*start..].iter_mut().zip(&answer) {
                *residual -= log * a;
            }
        }
        let background = |(index, random): (usize, &RandomFactor)| {
            let wave = |k| (0.01 * (index + 3) as f64 * k as f64).cos() as f32;
            let column = Column::Background { which: random.background, prior_sd: 0.1 };
            (column, (0..steps).map(wave).collect())
        };
        let (columns, signatures) = RANDOM.iter().enumerate().map(background).unzip();
        let bank = UnitBank {
            effect: EffectId::INSULIN_ABSORPTION,
            field: Field::InsulinTime,
            log_sd: 0.18,
            answers: starts
                .iter()
                .map(|s| answer.iter().take(steps - s).map(|v| *v as f32).collect())
                .collect(),
            starts,
        };
        Design {
            residuals,
            weights: vec![1.0; steps],
            columns,
            signatures,
            events: crate::design::HiddenEvents::default(),
            random: vec![bank],
            untried: Vec::new(),
        }
    }

    fn summed(design: &Design) -> (TestStatistics, UnitSums, Vec<Allowed>) {
        let person = TestStatistics::of(design);
        let sums = UnitSums::of(design, &person, &design.random[0]);
        let allowed =
            (0..RANDOM.len()).map(|column| Allowed { column, mean: 0.0, sd: 0.1 }).collect();
        (person, sums, allowed)
    }

    fn planted(sd: f64, stream: u64) -> (TestStatistics, UnitSums, Vec<Allowed>) {
        summed(&design(sd, stream))
    }

    fn usual() -> Spreads {
        let mut spreads = Spreads { day: [0.0; RANDOM.len()], block: [0.0; RANDOM.len()] };
        (spreads.day[0], spreads.block[4]) = (0.1, 0.05);
        spreads
    }

    fn scored(people: &[(TestStatistics, UnitSums, Vec<Allowed>)]) -> Score {
        let trials: Vec<UnitTrial<'_>> = people
            .iter()
            .map(|(person, units, allowed)| UnitTrial {
                person,
                units: Some(units),
                allowed: allowed.clone(),
            })
            .collect();
        score(&people[0].1, &trials, &usual())
    }

    #[test]
    fn a_planted_spread_is_found_and_none_gains_nothing() {
        let people = |sd| (0..4).map(|stream| planted(sd, stream)).collect::<Vec<_>>();
        let found = scored(&people(0.25));
        // Over the published 0.18.
        let (spread, error) = (0.18 * found.amplitude.0, 0.18 * found.amplitude.1);
        assert!((spread - 0.25).abs() < 3.0 * error && error < 0.05, "{spread} {error}");
        assert!(found.gain() > 10.0, "{:?}", found.gains);
        let none = scored(&people(0.0));
        // What a spread that is not there may gain by chance: well below a floor of 4 nats.
        assert!(none.gain() < 2.0 && 0.18 * none.amplitude.0 < 0.1, "{none:?}");
    }

    #[test]
    fn integrated_sums_are_those_of_random_factors_written_out() {
        let design = design(0.2, 7);
        let (person, units, allowed) = summed(&design);
        let n = RANDOM.len() + DAYS;
        let trial = UnitTrial { person: &person, units: Some(&units), allowed };
        let all = Sums::over(&trial.folds(&units, &usual()), None);
        // Constant directions, units, then a column for every random factor of every day and block.
        let bank = &design.random[0];
        let column = |signature: &[f32], steps: Range<usize>| -> Vec<f64> {
            (0..design.residuals.len())
                .map(|k| if steps.contains(&k) { f64::from(signature[k]) } else { 0.0 })
                .collect()
        };
        let whole = 0..design.residuals.len();
        let mut columns: Vec<Vec<f64>> =
            design.signatures.iter().map(|s| column(s, whole.clone())).collect();
        for (start, answer) in bank.starts.iter().zip(&bank.answers) {
            let mut own = vec![0.0; design.residuals.len()];
            for (value, a) in own[*start..].iter_mut().zip(answer) {
                *value = f64::from(*a);
            }
            columns.push(own);
        }
        let mut precision = Vec::new();
        for (random, length, spread) in
            [(0, STEPS_PER_DAY, usual().day[0]), (4, BLOCK, usual().block[4])]
        {
            for first in whole.clone().step_by(length) {
                columns.push(column(&design.signatures[random], first..first + length));
                precision.push(spread.powi(-2));
            }
        }
        let x = Mat::from_fn(whole.len(), columns.len(), |k, c| columns[c][k]);
        let y = Mat::from_fn(whole.len(), 1, |k, _| -design.residuals[k]);
        let (a, b) = (x.transpose() * &x, x.transpose() * &y);
        let m = Mat::from_fn(precision.len(), precision.len(), |i, j| {
            a[(n + i, n + j)] + if i == j { precision[i] } else { 0.0 }
        });
        let right =
            Mat::from_fn(
                precision.len(),
                n + 1,
                |i, j| {
                    if j < n { a[(n + i, j)] } else { b[(n + i, 0)] }
                },
            );
        let solved = m.llt(Side::Lower).expect("positive").solve(&right);
        let taken = a.get(..n, n..) * &solved;
        for i in 0..n {
            // Answers are kept in single precision; sums are of 4032 steps.
            assert!((all.b[i] - (b[(i, 0)] - taken[(i, n)])).abs() < 1e-6);
            for j in 0..n {
                let expected = a[(i, j)] - taken[(i, j)];
                assert!((all.a[(i, j)] - expected).abs() < 1e-6, "{i} {j}");
            }
        }
    }

    #[test]
    fn days_held_out_do_not_choose_the_spread() {
        let quiet: Vec<_> = (0..3).map(|stream| planted(0.0, stream)).collect();
        let mut loud = quiet.clone();
        // The scores of the first fold's days are blown up: its own gain is then decided by a spread
        // that the quiet days chose, which is none.
        for day in fold(DAYS, 0) {
            for (_, units, _) in &mut loud {
                for value in &mut units.days[day].score {
                    *value *= 30.0;
                }
            }
        }
        assert!(scored(&loud).gain() < scored(&quiet).gain() + 1.0);
    }
}
