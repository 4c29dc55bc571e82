//! The rows of the development set as they are stored, hashed and trained on: in single precision.

use std::collections::HashMap;

use nn_statespace::training::{Run, WindowGroup};
use nn_statespace::training_set::CompactRun;
use ode_sim::DevelopmentSet;
use ode_sim::development_set::{DAYS_PER_WEEK, Origin, STEPS_PER_WEEK, Subset, TimeShares, Week};
use physiology::{Compartment, MgPerDl, States, StepInput};
use sha2::{Digest as _, Sha256};

use crate::error::DevelopmentError;

/// Steps of a window: five hours (paper).
pub const WINDOW: usize = 60;
/// Steps between the starts of training windows: 75 % overlap (paper).
pub const TRAINING_STRIDE: usize = 15;

/// What is kept of a week whose rows are gone.
#[derive(Debug, Clone, PartialEq)]
pub struct WeekFacts {
    /// Index in the set.
    pub index: usize,
    /// To which subset it belongs.
    pub subset: Subset,
    /// Whether it is one of the combinations or an additional week.
    pub origin: Origin,
    /// Indices of its days in the pool of meal days.
    pub meal_days: [usize; DAYS_PER_WEEK],
    /// Glucose at its start.
    pub initial_glucose: MgPerDl,
    /// Steps by which boluses follow meals.
    pub delay: usize,
    /// Factor on the boluses.
    pub dose_factor: f64,
    /// Mean over the days.
    pub basal_factor: f64,
    /// Boluses without a meal, all together, U.
    pub extra_boluses: f64,
    /// Shares of the time in ranges of glucose.
    pub shares: TimeShares,
    /// SHA-256 of place, subset, meal days and rows.
    digest: [u8; 32],
}

/// Windows of a week whose starts are `stride` steps apart.
#[must_use]
pub const fn windows_per_week(stride: usize) -> usize {
    (STEPS_PER_WEEK - WINDOW) / stride + 1
}

/// Mean shares of the time in ranges of glucose; 0 where there is no week.
#[must_use]
pub fn mean_shares(weeks: &[&WeekFacts]) -> TimeShares {
    let mean = |share: fn(&TimeShares) -> f64| {
        weeks.iter().map(|week| share(&week.shares)).sum::<f64>() / weeks.len().max(1) as f64
    };
    TimeShares { below_70: mean(|s| s.below_70), above_250: mean(|s| s.above_250) }
}

/// Simulates week `index` of the set.
///
/// # Errors
/// [`DevelopmentError::Week`].
pub fn simulated(
    set: &DevelopmentSet,
    index: usize,
) -> Result<(WeekFacts, CompactRun), DevelopmentError> {
    let make = || -> Result<_, DevelopmentError> {
        let week = set.week(index)?;
        let run = set.run(&week)?;
        let states = run.report(set.plant());
        let rows = CompactRun::new(Run { states: &states, inputs: &week.inputs })?;
        let facts = WeekFacts {
            index,
            subset: week.subset,
            origin: week.origin,
            meal_days: week.meal_days,
            initial_glucose: week.initial_glucose,
            delay: week.delay,
            dose_factor: week.dose_factor,
            basal_factor: week.basal_factors.iter().sum::<f64>() / DAYS_PER_WEEK as f64,
            extra_boluses: week.extra_boluses.iter().map(|(_, bolus)| bolus.0).sum(),
            shares: set.time_shares(&run),
            digest: digest(&week, &rows),
        };
        Ok((facts, rows))
    };
    make().map_err(|source| DevelopmentError::Week { week: index, source: Box::new(source) })
}

/// A window of a week under the ODE.
pub(crate) struct Window {
    pub(crate) start: States,
    pub(crate) inputs: Vec<StepInput>,
    /// After each step, mg/dL.
    pub(crate) glucose: Vec<f64>,
    pub(crate) group: WindowGroup,
}

/// The windows of a week, side by side.
pub(crate) fn windows_of(
    set: &DevelopmentSet,
    week: &Week,
) -> Result<Vec<Window>, DevelopmentError> {
    let states = set.run(week)?.report(set.plant());
    let windows = week.inputs.chunks_exact(WINDOW).enumerate().map(|(place, inputs)| {
        let states = &states[place * WINDOW..=(place + 1) * WINDOW];
        let glucose: Vec<f64> = states[1..].iter().map(|x| x[Compartment::Q1]).collect();
        let group = WindowGroup::of(&glucose);
        Window { start: states[0], inputs: inputs.to_vec(), glucose, group }
    });
    Ok(windows.collect())
}

fn digest(week: &Week, rows: &CompactRun) -> [u8; 32] {
    let mut hasher = Sha256::new();
    hasher.update((week.index as u64).to_le_bytes());
    hasher.update(week.subset.name());
    for day in week.meal_days {
        hasher.update((day as u64).to_le_bytes());
    }
    let mut bytes = Vec::new();
    rows.write_canonical(&mut bytes).expect("memory takes every byte");
    hasher.update(&bytes);
    hasher.finalize().into()
}

/// The hash of the data: of the weeks' hashes in the order of the weeks.
pub fn data_hash(weeks: &[WeekFacts]) -> String {
    let mut hasher = Sha256::new();
    for week in weeks {
        hasher.update(week.digest);
    }
    hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Refuses weeks of which two subsets share a daily meal scenario, by its place in the pool or by its
/// meals.
///
/// # Errors
/// [`DevelopmentError::Leak`].
pub fn check_split(set: &DevelopmentSet, weeks: &[WeekFacts]) -> Result<(), DevelopmentError> {
    let mut owners: HashMap<Vec<(usize, u64)>, (Subset, usize)> = HashMap::new();
    for week in weeks {
        for place in week.meal_days {
            let meals = set.pool()[place].meals();
            let meals = meals.iter().map(|meal| (meal.step, meal.carbs.0.to_bits())).collect();
            let (owner, first) = *owners.entry(meals).or_insert((week.subset, week.index));
            if owner != week.subset {
                return Err(DevelopmentError::Leak {
                    day: place,
                    one: owner.name(),
                    first,
                    other: week.subset.name(),
                    second: week.index,
                });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ode_sim::DevelopmentPlan;
    use rayon::prelude::*;

    fn weeks(set: &DevelopmentSet, threads: usize) -> Vec<WeekFacts> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let make = |index| simulated(set, index).expect("a week").0;
        pool.install(|| (0..set.len()).into_par_iter().map(make).collect())
    }

    #[test]
    fn the_hash_follows_the_seed_and_not_the_threads() {
        let set = |seed| DevelopmentSet::new(DevelopmentPlan::quick(seed)).expect("a plan");
        let one = weeks(&set(1), 1);
        assert_eq!(one, weeks(&set(1), 3));
        assert_eq!(data_hash(&one), data_hash(&weeks(&set(1), 3)));
        assert_ne!(data_hash(&one), data_hash(&weeks(&set(2), 1)));
        let mut swapped = one.clone();
        swapped.swap(0, 1);
        assert_ne!(data_hash(&one), data_hash(&swapped), "order is part of the data");
    }

    #[test]
    fn a_meal_day_in_two_subsets_is_found() {
        let set = DevelopmentSet::new(DevelopmentPlan::quick(1)).expect("a plan");
        let mut weeks = weeks(&set, 2);
        check_split(&set, &weeks).expect("as it was made, enrichment included");
        // An additional week that takes a day of the test subset into training.
        let of_test = weeks.iter().find(|week| week.subset == Subset::Test).expect("one");
        let (day, combinations) = (of_test.meal_days[0], set.plan().combinations());
        let added = weeks.iter_mut().skip(combinations).find(|w| w.subset == Subset::Train);
        added.expect("most are for training").meal_days[3] = day;
        let error = check_split(&set, &weeks).expect_err("a leak").to_string();
        assert!(error.contains("train") && error.contains("test"), "{error}");
    }

    #[test]
    fn meals_that_are_equal_leak_from_different_places() {
        let set = DevelopmentSet::new(DevelopmentPlan::quick(1)).expect("a plan");
        let contents: std::collections::HashSet<_> =
            set.pool().iter().map(|day| format!("{:?}", day.meals())).collect();
        assert_eq!(contents.len(), set.pool().len(), "no two days of the pool are equal");
    }
}
