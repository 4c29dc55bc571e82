//! From everyone's held-out days to what is reported.

use std::num::NonZeroUsize;

use stats::{Bootstrap, Outcomes, compare_outcomes};

use super::judge::HeldOutDay;
use super::shrinkage::shrinkage;
use super::small_sample::over_people;
use crate::config::DiagnosisConfig;
use crate::error::GapError;
use crate::free_run::minutes;
use contract::WithInterval;
use contract::diagnosis::{HorizonChange, InnovationChange, OutcomeChange, PersonChange};

/// People below whose number days are resampled as well as people.
const FEW_PEOPLE: usize = 5;
/// Error above the floor below which no share of it is given, mg/dL.
const LEAST_GAP: f64 = 0.5;
/// Level of each one-sided test of equivalence.
const ALPHA: f64 = 0.05;

/// A held-out day, judged before and after.
#[derive(Debug, Clone)]
pub(super) struct Pair {
    pub(super) before: HeldOutDay,
    pub(super) after: HeldOutDay,
}

/// Everyone's held-out days, and how they are resampled.
pub(super) struct Summary<'a> {
    /// Name and days of each person.
    pub(super) people: &'a [(String, Vec<Pair>)],
    pub(super) config: &'a DiagnosisConfig,
    pub(super) plan: Bootstrap,
}

/// Sums over one person's days: count, before, after.
type DaySums = [f64; 3];

impl Summary<'_> {
    /// The rows of the horizons.
    ///
    /// # Errors
    /// [`GapError::Statistics`].
    pub(super) fn horizons(&self, reconstructed: bool) -> Result<Vec<HorizonChange>, GapError> {
        let mut rows = Vec::new();
        for (index, steps) in self.config.free_run.horizons.iter().enumerate() {
            // Both have the same starts.
            let of = |Pair { before, after }: &Pair| {
                let (before, after) = (&before.horizons[index], &after.horizons[index]);
                [before.runs, before.sizes, after.sizes]
            };
            let people = self.sums(of);
            let Some((means, difference)) = self.change(&people)? else { continue };
            let (floor, share_above_floor) =
                if reconstructed { (None, None) } else { self.floor(index)? };
            rows.push(HorizonChange {
                minutes: minutes(*steps),
                mae_before: means[0],
                mae_after: means[1],
                difference,
                reconstructed,
                floor,
                share_above_floor,
                people: people.len(),
                runs: people.iter().flatten().map(|sums| sums[0]).sum::<f64>() as usize,
            });
        }
        Ok(rows)
    }

    /// Change of the one-step log-likelihood.
    ///
    /// # Errors
    /// [`GapError::Statistics`].
    pub(super) fn innovations(&self) -> Result<Option<InnovationChange>, GapError> {
        let of = |pair: &Pair| {
            let scored = f64::from(u8::from(pair.before.innovations > 0.0));
            [scored, pair.before.log_likelihood, pair.after.log_likelihood]
        };
        Ok(self.change(&self.sums(of))?.map(|(means, difference)| InnovationChange {
            before: means[0],
            after: means[1],
            difference,
        }))
    }

    /// The rows of the outcomes; none below two people.
    ///
    /// # Errors
    /// [`GapError::Statistics`].
    pub(super) fn outcomes(&self) -> Result<Vec<OutcomeChange>, GapError> {
        let mut columns: [Vec<Outcomes>; 3] = Default::default();
        for (_, days) in self.people {
            let both = days.iter().filter_map(|pair| {
                let (real, before) = pair.before.outcomes?;
                let (_, after) = pair.after.outcomes?;
                Some([real, before, after])
            });
            let windows: Vec<[Outcomes; 3]> = both.collect();
            if windows.is_empty() {
                continue;
            }
            for (index, column) in columns.iter_mut().enumerate() {
                let of_person: Vec<Outcomes> = windows.iter().map(|w| w[index]).collect();
                column.push(Outcomes::average(&of_person)?);
            }
        }
        let [real, before, after] = columns;
        if real.len() < 2 {
            return Ok(Vec::new());
        }
        let before = compare_outcomes(&real, &before, ALPHA)?;
        let after = compare_outcomes(&real, &after, ALPHA)?;
        let rows = before.iter().zip(&after).map(|(before, after)| OutcomeChange {
            metric: before.metric.clone(),
            margin: before.margin,
            p_before: before.p,
            p_after: after.p,
            difference_before: before.difference.value,
            difference_after: after.difference.value,
            people: real.len(),
        });
        Ok(rows.collect())
    }

    /// Everyone's errors; `reconstructed` holds days of the same people with hidden changes reconstructed, or
    /// is empty.
    pub(super) fn people(&self, reconstructed: &[(String, Vec<Pair>)]) -> Vec<PersonChange> {
        let errors = |days: &[Pair], of: fn(&Pair) -> &HeldOutDay| -> Vec<Option<f64>> {
            let horizons = 0..self.config.free_run.horizons.len();
            horizons.map(|horizon| mean_error(days, horizon, of)).collect()
        };
        let judged = |pair: &&Pair| pair.before.horizons.iter().any(|horizon| horizon.runs > 0.0);
        let change = |(index, (person, days)): (usize, &(String, Vec<Pair>))| PersonChange {
            person_id: person.clone(),
            days: days.iter().filter(judged).count(),
            mae_before: errors(days, |pair| &pair.before),
            mae_after: errors(days, |pair| &pair.after),
            mae_reconstructed: reconstructed
                .get(index)
                .map_or_else(Vec::new, |(_, days)| errors(days, |pair| &pair.after)),
        };
        self.people.iter().enumerate().map(change).collect()
    }

    /// The floor at a horizon and the share of the error above it that was removed.
    fn floor(&self, index: usize) -> Result<(Option<f64>, Option<WithInterval>), GapError> {
        let errors = self.people.iter().filter_map(|(_, days)| {
            let runs: f64 = days.iter().map(|pair| pair.after.horizons[index].floor_runs).sum();
            let sum: f64 = days.iter().map(|pair| pair.after.horizons[index].floors).sum();
            let before = mean_error(days, index, |pair| &pair.before)?;
            let after = mean_error(days, index, |pair| &pair.after)?;
            (runs > 0.0).then(|| (before, after, sum / runs))
        });
        let (before, after, floors): (Vec<f64>, Vec<f64>, Vec<f64>) = errors.collect();
        let n = floors.len();
        let floor = (n > 0).then(|| floors.iter().sum::<f64>() / n as f64);
        let share = match n {
            0 | 1 => None,
            _ => shrinkage(&before, &after, &floors, LEAST_GAP, &self.plan)?,
        };
        Ok((floor, share))
    }

    /// Days that count, by person; people without one are left out.
    fn sums(&self, of: impl Fn(&Pair) -> DaySums) -> Vec<Vec<DaySums>> {
        self.people
            .iter()
            .map(|(_, days)| days.iter().map(&of).filter(|sums| sums[0] > 0.0).collect())
            .filter(|days: &Vec<DaySums>| !days.is_empty())
            .collect()
    }

    /// Means before and after, and their difference with an interval: over people, and over days within
    /// people where there are few; over days alone for one person. `None` where nothing can be
    /// resampled.
    fn change(
        &self,
        people: &[Vec<DaySums>],
    ) -> Result<Option<([f64; 2], WithInterval)>, GapError> {
        let plan = &self.plan;
        let block =
            NonZeroUsize::new(self.config.localisation.block_days).unwrap_or(NonZeroUsize::MIN);
        let matrix = match people {
            [] => return Ok(None),
            [days] if days.len() < 2 => return Ok(None),
            [days] => plan.people_matrix(days, |drawn| statistics(&[drawn.to_vec()]))?,
            few if few.len() < FEW_PEOPLE => plan.people_and_days_matrix(few, block, statistics)?,
            many => plan.people_matrix(many, |drawn| {
                statistics(&drawn.iter().map(|days| days.iter().collect()).collect::<Vec<_>>())
            })?,
        };
        let means = [matrix.estimates()[0], matrix.estimates()[1]];
        let estimate = matrix.estimate(2, plan.level)?;
        let interval = estimate.percentile;
        // Where days are resampled as well, they widen the interval by themselves.
        let difference = if people.len() < FEW_PEOPLE {
            WithInterval { value: estimate.value, lower: interval.lower, upper: interval.upper }
        } else {
            over_people(&estimate, people.len())
        };
        Ok(Some((means, difference)))
    }
}

fn mean_error(days: &[Pair], horizon: usize, of: fn(&Pair) -> &HeldOutDay) -> Option<f64> {
    let runs: f64 = days.iter().map(|pair| of(pair).horizons[horizon].runs).sum();
    let sizes: f64 = days.iter().map(|pair| of(pair).horizons[horizon].sizes).sum();
    (runs > 0.0).then(|| sizes / runs)
}

/// Mean over people of each person's mean before, after, and their difference.
fn statistics(people: &[Vec<&DaySums>]) -> Vec<f64> {
    let (mut before, mut after) = (0.0, 0.0);
    for days in people {
        let sum = days.iter().fold([0.0; 3], |sum, day| std::array::from_fn(|k| sum[k] + day[k]));
        before += sum[1] / sum[0];
        after += sum[2] / sum[0];
    }
    let n = people.len() as f64;
    vec![before / n, after / n, (after - before) / n]
}
