//! Twins and baselines against held-out days.
//!
//! Every method runs freely from a window's first reading; what it is judged on is what a sensor
//! would have read. People, not windows, are the unit of every mean, test and interval.

mod forecast;
mod person;
mod tables;

use std::collections::BTreeMap;
use std::sync::Arc;

use cohort::Cohort;
use nn_statespace::PopulationModel;
use ode_sim::{OdeParameters, OdePlant};
use physiology::Kilograms;
use rayon::prelude::*;
use stats::Bootstrap;

use crate::error::TwinError;
use crate::protocol::{PersonWindows, Protocol};
use crate::start::SteadyStates;
use crate::twin::Twin;

pub use forecast::{FORECAST_MINUTES, ForecastError, Forecaster};
pub use person::{MethodResult, PersonEvaluation};
pub use tables::{
    Comparison, ExclusionRow, ForecastRow, IntervalMethod, MethodRows, OutcomeRow, OutcomesTable,
    Spread, TwinRow, TwinsTable, WithInterval,
};

/// Weight of the simulator's average person, kg, for people whose weight is unknown (Resalat et al.
/// 2019).
pub const AVERAGE_WEIGHT: Kilograms = Kilograms(76.3);

/// A plant that is judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Method {
    /// The person's twin.
    Twin,
    /// The population model without the person's network.
    Population,
    /// The ODE model with population parameters and the person's weight.
    Ode,
}

impl Method {
    /// Every method, the twin first.
    pub const ALL: [Self; 3] = [Self::Twin, Self::Population, Self::Ode];

    /// The key in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Twin => "twin",
            Self::Population => "population",
            Self::Ode => "ode",
        }
    }

    /// The name for people.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Self::Twin => "Digital twin",
            Self::Population => "Population model",
            Self::Ode => "ODE, population parameters",
        }
    }
}

/// How twins are judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EvaluationSettings {
    /// How records are cut; the same as in training.
    pub protocol: Protocol,
    /// Level of each one-sided test.
    pub alpha: f64,
    /// Resampling of people for intervals.
    pub bootstrap: Bootstrap,
}

impl EvaluationSettings {
    /// Level 0.05 as in the paper; intervals of level 0.90, which belong to such tests, from 2,000
    /// bootstrap samples of people.
    #[must_use]
    pub const fn paper(protocol: Protocol, seed: u64) -> Self {
        Self { protocol, alpha: 0.05, bootstrap: Bootstrap { replicates: 2000, level: 0.9, seed } }
    }
}

/// Everything found about a cohort: people with their figures, and who was left out.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// One entry a person judged, in the order of the cohort.
    pub people: Vec<PersonEvaluation>,
    /// People left out, with the reason.
    pub exclusions: Vec<ExclusionRow>,
    /// Length of a test window, min.
    pub window_minutes: u32,
}

/// The ODE baseline for a person: population parameters, the person's weight or
/// [`AVERAGE_WEIGHT`], integrated as the authors do.
#[must_use]
pub fn ode_baseline(weight: Option<Kilograms>) -> OdePlant {
    OdePlant::reproduction(OdeParameters::nominal(), weight.unwrap_or(AVERAGE_WEIGHT))
}

/// Judges the twins of a cohort, found by person, beside the population model and the ODE.
///
/// People are left out for the reasons of [`Exclusion`](crate::Exclusion), or because `twins` has
/// none of theirs. The result does not depend on the number of threads.
///
/// # Errors
/// The first error by order of people.
pub fn evaluate(
    cohort: &Cohort,
    twins: &BTreeMap<String, Twin>,
    population: &Arc<PopulationModel>,
    settings: &EvaluationSettings,
) -> Result<Evaluation, TwinError> {
    let steady = SteadyStates::new(&**population);
    let judged: Vec<Result<Judged, TwinError>> = cohort
        .people
        .par_iter()
        .enumerate()
        .map(|(index, person)| {
            let cut = PersonWindows::new(index, person, &settings.protocol)?;
            if let Some(reason) = cut.excluded {
                return Ok(Judged::Out(reason.to_string()));
            }
            match twins.get(&person.id) {
                None => Ok(Judged::Out("no twin was given".to_owned())),
                Some(twin) => {
                    let found =
                        person::evaluate_person(index, person, &cut, twin, &steady, settings)
                            .map_err(|error| error.of_person(&person.id))?;
                    Ok(Judged::In(Box::new(found)))
                }
            }
        })
        .collect();
    let mut evaluation = Evaluation {
        people: Vec::new(),
        exclusions: Vec::new(),
        window_minutes: (settings.protocol.test.len as f64 * physiology::STEP.0) as u32,
    };
    for (person, judged) in cohort.people.iter().zip(judged) {
        match judged? {
            Judged::In(found) => evaluation.people.push(*found),
            Judged::Out(reason) => {
                evaluation.exclusions.push(ExclusionRow { person_id: person.id.clone(), reason });
            }
        }
    }
    Ok(evaluation)
}

enum Judged {
    In(Box<PersonEvaluation>),
    Out(String),
}
