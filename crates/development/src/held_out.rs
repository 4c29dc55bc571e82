//! Population networks on held-out days of the development set, window by window beside the ODE.

use std::collections::BTreeMap;

use contract::Summary;
use contract::held_out::{GroupErrors, Told};
use nn_statespace::PopulationModel;
use ode_sim::DevelopmentSet;
use ode_sim::development_set::{DAYS_PER_WEEK, Origin, Subset, Week};
use physiology::{Compartment, MgPerDl, OpenLoop, simulate};
use rayon::prelude::*;
use stats::{Outcome, Outcomes, compare_outcomes};

use crate::error::DevelopmentError;
use crate::trajectory_cost::{WEEKS, drawn_weeks};
use crate::weeks::{WINDOW, Window, windows_of};

/// Weeks that are scored before their sums are added up: sums do not depend on threads, memory not on the weeks.
const AT_ONCE: usize = 256;
/// Level of the one-sided tests.
const ALPHA: f64 = 0.05;
/// The risk indices need a logarithm: glucose is counted as at least this, mg/dL.
const LEAST_GLUCOSE: f64 = 1.0;
/// C1 below which a window starts without carbohydrate on its way, mmol/kg.
const FASTING_C1: f64 = 0.01;

/// Windows of one model, summed up. Sums of weeks are added in the order of the weeks.
#[derive(Debug, Clone, Default)]
pub struct Scored {
    /// Squared errors of glucose and windows by group: of all windows and of those that start fasting.
    all: Errors,
    fasting: Errors,
    /// Outcomes of every window.
    windows: Moments,
    /// Outcomes of the windows of each meal week.
    meal_weeks: BTreeMap<[usize; DAYS_PER_WEEK], Moments>,
    /// Windows in which glucose left the finite numbers.
    pub broken: usize,
    /// Samples below what the risk indices need.
    pub below_least: usize,
}

#[derive(Debug, Clone, Copy, Default)]
struct Errors {
    squares: [f64; 3],
    windows: [usize; 3],
}

/// Count, sum and sum of squares of the six outcomes.
#[derive(Debug, Clone, Copy, Default)]
struct Moments {
    n: usize,
    sum: [f64; 6],
    square: [f64; 6],
}

/// The ODE and each model on all weeks of the test subset, and on those of them that are combinations; `scored` is told
/// of each week.
///
/// # Errors
/// Those of [`score`].
pub fn score_all(
    set: &DevelopmentSet,
    models: &[PopulationModel],
    scored: &(dyn Fn() + Sync),
) -> Result<[Vec<Scored>; 2], DevelopmentError> {
    let none = || vec![Scored::default(); models.len() + 1];
    let [mut all, mut combinations] = [none(), none()];
    for first in (0..set.len()).step_by(AT_ONCE) {
        let weeks: Vec<_> = (first..set.len().min(first + AT_ONCE))
            .into_par_iter()
            .map(|index| {
                let week = set.week(index)?;
                scored();
                let mine = week.subset == Subset::Test;
                let is_combination = week.origin == Origin::Combination;
                mine.then(|| Ok((is_combination, score(set, &week, models)?))).transpose()
            })
            .collect::<Result<_, DevelopmentError>>()?;
        for (combination, scored) in weeks.into_iter().flatten() {
            add(&mut all, &scored);
            if combination {
                add(&mut combinations, &scored);
            }
        }
    }
    Ok([all, combinations])
}

/// Balanced errors of models on drawn weeks of the test subset, mg/dL.
///
/// # Errors
/// Those of [`score`].
pub fn balanced_errors(
    set: &DevelopmentSet,
    models: &[PopulationModel],
    seed: u64,
) -> Result<Vec<f64>, DevelopmentError> {
    let mut sums = vec![Scored::default(); models.len() + 1];
    for week in drawn_weeks(set, Subset::Test, WEEKS, seed)? {
        add(&mut sums, &score(set, &week, models)?);
    }
    Ok(sums[1..].iter().map(Scored::balanced_error).collect())
}

fn add(sums: &mut [Scored], more: &[Scored]) {
    for (sum, more) in sums.iter_mut().zip(more) {
        sum.take_in(more);
    }
}

/// A week's windows under the ODE and under each model.
///
/// # Errors
/// A run of the ODE that fails, and outcomes that cannot be computed.
pub fn score(
    set: &DevelopmentSet,
    week: &Week,
    models: &[PopulationModel],
) -> Result<Vec<Scored>, DevelopmentError> {
    let mut scored = vec![Scored::default(); models.len() + 1];
    for window in windows_of(set, week)? {
        scored[0].add(week, &window, &window.glucose)?;
        for (scored, model) in scored[1..].iter_mut().zip(models) {
            match simulated(model, &window) {
                Some(glucose) => scored.add(week, &window, &glucose)?,
                None => scored.broken += 1,
            }
        }
    }
    Ok(scored)
}

/// Glucose after each step, mg/dL; `None` if the model leaves the finite numbers.
fn simulated(model: &PopulationModel, window: &Window) -> Option<Vec<f64>> {
    let start = model.scaler().scale(&window.start);
    let mut inputs = OpenLoop::new(&window.inputs);
    let run = simulate(model, start, &mut inputs, window.inputs.len()).ok()?;
    Some(run.glucose(model).into_iter().skip(1).map(|glucose| glucose.0).collect())
}

impl Scored {
    fn add(
        &mut self,
        week: &Week,
        window: &Window,
        glucose: &[f64],
    ) -> Result<(), DevelopmentError> {
        let square: f64 = glucose.iter().zip(&window.glucose).map(|(g, t)| (g - t).powi(2)).sum();
        let group = window.group as usize;
        let fasting = (window.start[Compartment::C1] < FASTING_C1).then_some(&mut self.fasting);
        for errors in std::iter::once(&mut self.all).chain(fasting) {
            errors.squares[group] += square;
            errors.windows[group] += 1;
        }
        self.below_least += glucose.iter().filter(|g| **g < LEAST_GLUCOSE).count();
        let outcomes = Outcomes::of(glucose.iter().map(|g| MgPerDl(g.max(LEAST_GLUCOSE))))
            .map_err(|source| DevelopmentError::Outcomes { week: Some(week.index), source })?;
        let values = Outcome::ALL.map(|outcome| outcomes.get(outcome));
        let one = Moments { n: 1, sum: values, square: values.map(|value| value * value) };
        self.windows.plus(&one);
        self.meal_weeks.entry(week.meal_days).or_default().plus(&one);
        Ok(())
    }

    /// Takes in what another part of the weeks came to.
    fn take_in(&mut self, other: &Self) {
        for (own, more) in [(&mut self.all, &other.all), (&mut self.fasting, &other.fasting)] {
            for group in 0..3 {
                own.squares[group] += more.squares[group];
                own.windows[group] += more.windows[group];
            }
        }
        self.windows.plus(&other.windows);
        for (meals, more) in &other.meal_weeks {
            self.meal_weeks.entry(*meals).or_default().plus(more);
        }
        self.broken += other.broken;
        self.below_least += other.below_least;
    }

    /// The mean over the paper's groups of the error of glucose, mg/dL.
    pub fn balanced_error(&self) -> f64 {
        balanced(&self.all.rmse())
    }

    /// What is told of a model beside the ODE.
    pub fn told(&self, ode: &Self) -> Result<Told, DevelopmentError> {
        let (real, model) = (ode.by_meal_week(), self.by_meal_week());
        // A meal week without a single window that stays finite has no pair.
        let (real, model): (Vec<Outcomes>, Vec<Outcomes>) = real
            .into_iter()
            .filter_map(|(meals, outcomes)| Some((outcomes, *model.get(&meals)?)))
            .unzip();
        Ok(Told {
            errors: self.all.rmse(),
            errors_fasting: self.fasting.rmse(),
            windows: std::array::from_fn(|k| (ode.windows.summary(k), self.windows.summary(k))),
            equivalence: compare_outcomes(&real, &model, ALPHA)
                .map_err(|source| DevelopmentError::Outcomes { week: None, source })?,
            windows_broken: self.broken,
            samples_below_1_mg_dl: self.below_least,
        })
    }

    /// Mean outcomes of each meal week; only the six are filled.
    fn by_meal_week(&self) -> BTreeMap<[usize; DAYS_PER_WEEK], Outcomes> {
        let mean = |Moments { n, sum, .. }: &Moments| {
            let [tir, tar, tbr, lbgi, hbgi, mg] = sum.map(|sum| sum / *n as f64);
            let none = f64::NAN;
            let (sd, cv, gmi, tbr54, tar250) = (none, none, none, none, none);
            Outcomes { tir, tar, tbr, lbgi, hbgi, mg, sd, cv, gmi, tbr54, tar250 }
        };
        self.meal_weeks.iter().map(|(meals, found)| (*meals, mean(found))).collect()
    }
}

impl Errors {
    fn rmse(&self) -> GroupErrors {
        GroupErrors {
            rmse_mg_dl: std::array::from_fn(|group| {
                let samples = self.windows[group] * WINDOW;
                (samples > 0).then(|| (self.squares[group] / samples as f64).sqrt())
            }),
            windows: self.windows,
        }
    }
}

impl Moments {
    fn plus(&mut self, other: &Self) {
        self.n += other.n;
        for k in 0..6 {
            self.sum[k] += other.sum[k];
            self.square[k] += other.square[k];
        }
    }

    fn summary(&self, outcome: usize) -> Summary {
        let n = self.n as f64;
        let mean = self.sum[outcome] / n;
        let variance = (self.square[outcome] - n * mean * mean).max(0.0) / (n - 1.0);
        Summary { n: self.n, mean, sd: (self.n > 1).then(|| variance.sqrt()) }
    }
}

/// The mean over the paper's groups of an error of glucose, mg/dL.
#[must_use]
pub fn balanced(errors: &GroupErrors) -> f64 {
    let GroupErrors { rmse_mg_dl, windows } = *errors;
    nn_statespace::training::GroupErrors { rmse_mg_dl, windows }.balanced()
}
