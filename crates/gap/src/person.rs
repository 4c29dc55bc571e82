//! The analysis of one person: filter, calibration, free runs, errors by cell.

use cohort::{Cohort, Person};
use ode_sim::OdeParameters;
use physiology::STEPS_PER_DAY;
use rayon::prelude::*;

use crate::calibrated_person::CalibratedPerson;
use crate::config::DiagnosisConfig;
use crate::context::{BANDS, PARTS, Situation, Situations, band, hours_of_part, part_of_day};
use crate::error::GapError;
use crate::filter::augmented::AugmentedModel;
use crate::filter::calibration::{Calibration, Factor, calibrate};
use crate::filter::observations::{MissingDosePolicy, Observations, Reading};
use crate::filter::plants::Plants;
use crate::free_run::{Flux, FreeRunRule, free_run_errors_of, minutes};
use crate::hourly;
use crate::localisation::{DayCells, LocalisationRule};
use crate::misfit;
use crate::quality::UsedPerson;
use contract::diagnosis::{
    CalibrationSummary, CellFactor, DataQualityFinding, FactorEstimate, PersonSummary,
};

/// A cell of `where`, persons aside.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Cell {
    pub(crate) factor: CellFactor,
    pub(crate) level: String,
    /// Index of the horizon whose free runs it averages.
    pub(crate) horizon: usize,
}

/// Index of the first situation among the cells.
const SITUATIONS: usize = PARTS;
/// Index of the first glucose band among the cells.
const GLUCOSE: usize = SITUATIONS + Situation::ALL.len();
/// Index of the first horizon among the cells; those before it exist in both layers.
pub(crate) const HORIZONS: usize = GLUCOSE + BANDS.len();

/// The cells of a diagnosis: hours, situations, bands, horizons.
pub(crate) fn cells(rule: &FreeRunRule, localisation: &LocalisationRule) -> Vec<Cell> {
    let main = main_horizon(rule, localisation);
    let of = |factor, level: &str, horizon| Cell { factor, level: level.to_owned(), horizon };
    let hours = (0..PARTS).map(|part| of(CellFactor::Hour, &hours_of_part(part), main));
    let situations = Situation::ALL.iter().map(|s| of(CellFactor::Context, s.name(), main));
    let bands = BANDS.iter().map(|level| of(CellFactor::GlucoseBand, level, main));
    let horizon = |(index, steps)| of(CellFactor::Horizon, &minutes(steps).to_string(), index);
    let horizons = rule.horizons.iter().copied().enumerate().map(horizon);
    hours.chain(situations).chain(bands).chain(horizons).collect()
}

/// Index of the horizon that the cells use.
pub(crate) fn main_horizon(rule: &FreeRunRule, localisation: &LocalisationRule) -> usize {
    rule.horizons.iter().position(|horizon| *horizon == localisation.horizon).unwrap_or(0)
}

/// Sums of errors of one day at one horizon.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct HorizonSums {
    pub(crate) runs: f64,
    pub(crate) errors: f64,
    pub(crate) sizes: f64,
    pub(crate) squares: f64,
}

impl HorizonSums {
    /// Sums over days.
    pub(crate) fn total<'a>(days: impl Iterator<Item = &'a Self>) -> Self {
        days.fold(Self::default(), |sum, day| Self {
            runs: sum.runs + day.runs,
            errors: sum.errors + day.errors,
            sizes: sum.sizes + day.sizes,
            squares: sum.squares + day.squares,
        })
    }

    /// Root mean squared error; 0 without runs.
    pub(crate) fn rms(&self) -> f64 {
        (self.squares / self.runs.max(1.0)).sqrt()
    }
}

/// Everything that a person contributes to the cohort's diagnosis.
#[derive(Debug, Clone)]
pub(crate) struct PersonAnalysis {
    /// Free-run errors by day and cell.
    pub(crate) free_runs: Vec<DayCells>,
    /// Whitened innovations by day and cell; the horizon cells stay empty.
    pub(crate) innovations: Vec<DayCells>,
    /// Free-run errors by day, row and part of the day.
    pub(crate) hourly: Vec<DayCells>,
    /// Sums by day and horizon.
    pub(crate) horizons: Vec<Vec<HorizonSums>>,
    pub(crate) summary: CalibrationSummary,
    /// The person without channels that are to be ignored; `None` where all are read.
    pub(crate) person: Option<Person>,
    /// What was observed, without channels that are to be ignored.
    pub(crate) observations: Observations,
    /// The person's calibration.
    pub(crate) calibration: Calibration,
}

impl PersonAnalysis {
    /// Sums over all days at one horizon.
    pub(crate) fn total(&self, horizon: usize) -> HorizonSums {
        HorizonSums::total(self.horizons.iter().map(|day| &day[horizon]))
    }
}

/// What becomes of a person: an analysis or an exclusion with its reason.
pub(crate) struct PersonOutcome {
    pub(crate) summary: PersonSummary,
    pub(crate) findings: Vec<DataQualityFinding>,
    pub(crate) analysis: Option<PersonAnalysis>,
}

impl PersonOutcome {
    /// The person as the questions find her; `None` where she is excluded. `person` is the one who was analysed.
    pub(crate) fn calibrated<'a>(&'a self, person: &'a Person) -> Option<CalibratedPerson<'a>> {
        let PersonAnalysis { observations, calibration, person: without, .. } =
            self.analysis.as_ref()?;
        let person = without.as_ref().unwrap_or(person);
        Some(CalibratedPerson { person, observations, calibration })
    }
}

/// Analyses one person, of whom `used` says what is read.
///
/// # Errors
/// [`GapError::Value`] for data that cannot be. A person whose filter, calibration or free runs fail
/// is excluded instead.
pub(crate) fn analyse(
    person: &Person,
    used: &UsedPerson,
    plants: &dyn Plants,
    config: &DiagnosisConfig,
) -> Result<PersonOutcome, GapError> {
    let read = used.read(person);
    let days = read.record.len() / STEPS_PER_DAY;
    let observations = Observations::from_person(read)?;
    let unrecorded = unrecorded_doses(&observations, config.missing_doses);
    let left_out = used.table.left_out.clone().or(unrecorded);
    let body = left_out.map_or_else(|| plants.body_of(read), Err);
    let analysed = body.and_then(|body| {
        let parameters = OdeParameters::nominal();
        let ode = AugmentedModel::new(parameters, observations.weight, config.noise);
        let model = match body {
            Some(body) => ode.with_body(body),
            None => ode,
        };
        calibrate(&model, &observations, &config.calibration)
            .and_then(|calibration| errors_of(read, observations, calibration, config))
            .map_err(|error| error.to_string())
    });
    let (excluded, analysis) = match analysed {
        Ok(analysis) if analysis.summary.runs == 0 => {
            (Some("no free run could be scored".to_owned()), None)
        }
        Ok(analysis) => (None, Some(analysis)),
        Err(reason) => (Some(reason), None),
    };
    let without = (!std::ptr::eq(read, person)).then(|| read.clone());
    let analysis = analysis.map(|analysis| PersonAnalysis { person: without, ..analysis });
    let calibration = analysis.as_ref().map(|a| a.summary.clone());
    let summary = PersonSummary { person_id: person.id.clone(), days, excluded, calibration };
    let mut findings: Vec<_> = used.findings.iter().map(|f| f.reported.clone()).collect();
    if let Some(analysis) = &analysis {
        findings.extend(misfit::findings(&person.id, &analysis.calibration));
    }
    Ok(PersonOutcome { summary, findings, analysis })
}

/// Analyses everybody of a cohort.
///
/// # Errors
/// As [`analyse`].
pub(crate) fn analyse_all(
    cohort: &Cohort,
    plants: &dyn Plants,
    config: &DiagnosisConfig,
) -> Result<Vec<PersonOutcome>, GapError> {
    cohort
        .people
        .par_iter()
        .map(|person| analyse(person, &UsedPerson::of(person, &config.inclusion)?, plants, config))
        .collect()
}

/// Those of a cohort whose analysis has not excluded them, each with the index in the cohort.
pub(crate) fn all_calibrated<'a>(
    cohort: &'a Cohort,
    outcomes: &'a [PersonOutcome],
) -> impl Iterator<Item = (usize, CalibratedPerson<'a>)> {
    let people = cohort.people.iter().zip(outcomes).enumerate();
    people.filter_map(|(index, (person, outcome))| Some((index, outcome.calibrated(person)?)))
}

/// What is wrong where everybody is excluded.
pub(crate) fn nobody_left(outcomes: &[PersonOutcome]) -> GapError {
    let first = outcomes.first().map(|outcome| &outcome.summary);
    first.map_or(GapError::EmptyCohort, |first| GapError::NobodyLeft {
        people: outcomes.len(),
        person: first.person_id.clone(),
        reason: first.excluded.clone().unwrap_or_default(),
    })
}

/// Why a person cannot be diagnosed where every dose must be recorded.
fn unrecorded_doses(observations: &Observations, policy: MissingDosePolicy) -> Option<String> {
    let unrecorded = observations.doses_recorded.iter().filter(|recorded| !**recorded).count();
    (policy == MissingDosePolicy::ExcludePerson && unrecorded > 0)
        .then(|| format!("{unrecorded} steps with a dose that is not on record"))
}

/// Where a calibrated plant misses a person.
fn errors_of(
    person: &Person,
    observations: Observations,
    calibration: Calibration,
    config: &DiagnosisConfig,
) -> Result<PersonAnalysis, GapError> {
    let (free_run, localisation) = (&config.free_run, &config.localisation);
    let (model, states) = (&calibration.model, &calibration.filtered.states);
    let glucose = calibration.glucose();
    let situations = Situations::of(person, &glucose);
    let errors = free_run_errors_of(model, &observations, free_run, states, Flux::Dropped)?;

    let record = &person.record;
    let last_day = record.day_index(record.len().saturating_sub(1));
    let count = cells(free_run, localisation).len();
    let main = main_horizon(free_run, localisation);
    let half = localisation.horizon / 2;
    let mut free_runs = vec![DayCells::empty(count); last_day + 1];
    let mut innovations = free_runs.clone();
    let mut by_hour = vec![hourly::empty_day(); last_day + 1];
    let horizons = free_run.horizons.len();
    let mut sums = vec![vec![HorizonSums::default(); horizons]; last_day + 1];
    for error in &errors {
        let day = record.day_index(error.start);
        free_runs[day].add(HORIZONS + error.horizon, error.error);
        if error.horizon == main {
            let hour = usize::from(record.hour(error.start + half));
            free_runs[day].add(part_of_day(hour), error.error);
            hourly::count(&mut by_hour[day], hour, None, error.error);
            for situation in situations.at(error.start).filter(|s| !s.reads_glucose()) {
                free_runs[day].add(SITUATIONS + situation as usize, error.error);
                hourly::count(&mut by_hour[day], hour, Some(situation), error.error);
            }
        }
        let sum = &mut sums[day][error.horizon];
        sum.runs += 1.0;
        sum.errors += error.error;
        sum.sizes += error.error.abs();
        sum.squares += error.error * error.error;
    }
    // Where glucose is high, the flux that made it so is likely to go on. A run that drops the filter's
    // flux would miss there for that reason alone, so cells that read glucose keep it.
    let rule = FreeRunRule { horizons: vec![localisation.horizon], ..free_run.clone() };
    let kept_flux = free_run_errors_of(model, &observations, &rule, states, Flux::Kept)?;
    for error in &kept_flux {
        let day = record.day_index(error.start);
        free_runs[day].add(GLUCOSE + band(glucose[error.start]), error.error);
        let hour = usize::from(record.hour(error.start + half));
        for situation in situations.at(error.start).filter(|s| s.reads_glucose()) {
            free_runs[day].add(SITUATIONS + situation as usize, error.error);
            hourly::count(&mut by_hour[day], hour, Some(situation), error.error);
        }
    }
    // An innovation belongs to the step before its reading: that is what was known.
    for (step, whitened) in calibration.whitened.iter().enumerate().skip(1) {
        if let Some(value) = whitened {
            let day = record.day_index(step - 1);
            let hour = usize::from(record.hour(step));
            innovations[day].add(part_of_day(hour), *value);
            for situation in situations.at(step - 1) {
                innovations[day].add(SITUATIONS + situation as usize, *value);
            }
            innovations[day].add(GLUCOSE + band(glucose[step - 1]), *value);
        }
    }
    let summary = summary(person, &observations, &calibration, errors.len());
    Ok(PersonAnalysis {
        free_runs,
        innovations,
        hourly: by_hour,
        horizons: sums,
        summary,
        person: None,
        observations,
        calibration,
    })
}

fn summary(
    person: &Person,
    observations: &Observations,
    calibration: &Calibration,
    runs: usize,
) -> CalibrationSummary {
    let factors = Factor::ALL
        .into_iter()
        .zip(calibration.sd)
        .map(|(factor, log_sd)| FactorEstimate {
            factor: factor.name().to_owned(),
            value: calibration.factors.get(factor).exp(),
            log_sd,
            at_bound: calibration.at_bound.contains(&factor),
        })
        .collect();
    let readings = observations.readings.iter();
    CalibrationSummary {
        factors,
        converged: calibration.converged,
        iterations: calibration.iterations,
        log_covariance: calibration.covariance.map(|row| row.to_vec()).to_vec(),
        dependence: calibration.dependence,
        innovation_sd: calibration.scale,
        autoregression: [calibration.autoregression.a1, calibration.autoregression.a2],
        runs,
        censored_readings: readings.filter(|r| matches!(r, Reading::Low | Reading::High)).count(),
        unrecorded_doses: observations.doses_recorded.iter().filter(|r| !**r).count(),
        weight_kg: observations.weight.0,
        weight_assumed: person.weight.is_none(),
    }
}
