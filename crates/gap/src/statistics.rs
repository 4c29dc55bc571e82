//! Every statistic that the diagnosis reads: of a cohort, for a posterior, and of one person, for holding made people
//! against real ones.
//!
//! Posterior, priors and noise are chosen on made people. That says something of real people only where these
//! numbers of theirs are no rarity among made ones (a posterior predictive check: Gelman, Meng and Stern, Stat Sin
//! 1996;6:733).

use std::collections::BTreeMap;

use cohort::{Cohort, Person};
use effects::Effect;

use crate::calibrated_person::CalibratedPerson;
use crate::config::DiagnosisConfig;
use crate::error::GapError;
use crate::filter::observations::Observations;
use crate::filter::plants::Ode;
use crate::free_run_statistics::free_run_statistics;
use crate::person::{all_calibrated, analyse, analyse_all};
use crate::person_statistics::{of_person, of_record};
use crate::quality::UsedPerson;
use crate::which::first_round;

/// Evidence is rounded to a tenth of a nat: smaller differences say nothing.
const RESOLUTION: f64 = 0.1;

/// Reads the statistics of a cohort on the ODE plant: natural units, evidence by name, spreads, and what its people are
/// like. `None` where everybody has to be excluded.
///
/// # Errors
/// As [`Diagnoser::run`](crate::Diagnoser::run), exclusion aside.
pub fn cohort_statistics(
    cohort: &Cohort,
    library: &[Box<dyn Effect>],
    config: &DiagnosisConfig,
) -> Result<Option<BTreeMap<String, f64>>, GapError> {
    let outcomes = analyse_all(cohort, &Ode, config)?;
    let included: Vec<CalibratedPerson<'_>> =
        all_calibrated(cohort, &outcomes).map(|(_, person)| person).collect();
    if included.is_empty() {
        return Ok(None);
    }
    let analyses = outcomes.iter().filter_map(|outcome| outcome.analysis.as_ref());
    let free_runs = free_run_statistics(analyses, config);
    let found = first_round(&included, library, &config.calibration, free_runs)?;
    Ok(Some(found.statistics))
}

/// What the diagnosis reads of one person.
#[derive(Debug, Clone, PartialEq)]
pub struct PersonStatistics {
    /// Why the person is not diagnosed, if that is so; there are statistics of the record alone then.
    pub excluded: Option<String>,
    /// Statistics by name: `record/...`, `innovations/...`, `calibration/...`, `spread/...` and `evidence/...`.
    /// What the record does not tell is absent.
    pub values: BTreeMap<String, f64>,
}

/// Reads the statistics of one person on the ODE plant, as if she were a cohort of her own.
///
/// # Errors
/// As [`Diagnoser::run`](crate::Diagnoser::run), exclusion aside.
pub fn person_statistics(
    person: &Person,
    library: &[Box<dyn Effect>],
    config: &DiagnosisConfig,
) -> Result<PersonStatistics, GapError> {
    let outcome = analyse(person, &UsedPerson::of(person, &config.inclusion)?, &Ode, config)?;
    let Some(calibrated) = outcome.calibrated(person) else {
        let values = of_record(person, &Observations::from_person(person)?);
        return Ok(PersonStatistics { excluded: outcome.summary.excluded, values });
    };
    let mut values = of_person(&calibrated);
    let answer = first_round(&[calibrated], library, &config.calibration, BTreeMap::new())?;
    values.extend(answer.spreads.iter().map(|(name, spread)| (format!("spread/{name}"), *spread)));
    let rounded = |gain: &f64| (gain / RESOLUTION).round() * RESOLUTION;
    let gains = answer.evidence.gains.iter();
    values.extend(gains.map(|(name, gain)| (format!("evidence/{name}"), rounded(gain))));
    Ok(PersonStatistics { excluded: None, values })
}
