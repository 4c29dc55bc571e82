//! A person's whole record through a plant.

use cohort::{MissingDoses, Person};
use nn_statespace::initial_state::InitialStateTable;
use nn_statespace::{PopulationModel, ScaledStates};
use physiology::{MgPerDl, OpenLoop, Plant, States, simulate};

use crate::error::TwinError;
use crate::start::Startable;

/// Where a replay starts; both are looked up at the first sensor reading.
#[derive(Debug, Clone, Copy)]
pub enum ReplayStart<'a> {
    /// The population model's steady state.
    SteadyState,
    /// The row of a table of initial states, as the authors published one.
    Table(&'a InitialStateTable),
}

/// One row of `traces.csv`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReplayRow {
    /// Start of the step, local wall clock.
    pub time: chrono::NaiveDateTime,
    /// The step, counted from the first row.
    pub step: usize,
    /// The states at the start of the step, in reporting units.
    pub states: States,
}

/// Runs a plant freely along a person's record, from the first sensor reading to the last step.
///
/// `plant` is `population` or a twin on it. `missing` says what a dose that is not recorded means.
///
/// # Errors
/// [`TwinError::NoReading`] if the record has no sensor reading, [`TwinError::Cohort`] for a dose
/// that is missing or not finite, [`TwinError::Model`] for a glucose outside the table, and
/// [`TwinError::Simulation`].
pub fn replay<P: Plant<State = ScaledStates>>(
    person: &Person,
    plant: &P,
    population: &PopulationModel,
    start: ReplayStart<'_>,
    missing: MissingDoses,
) -> Result<Vec<ReplayRow>, TwinError> {
    let mut readings = person.record.cgm().iter().enumerate();
    let (first, glucose) = readings
        .find_map(|(step, reading)| Some((step, MgPerDl((*reading)?))))
        .ok_or_else(|| TwinError::NoReading { person: person.id.clone(), step: 0 })?;
    let state = match start {
        ReplayStart::SteadyState => population.at_steady_state(glucose)?.0,
        ReplayStart::Table(table) => table.row(glucose)?,
    };
    let inputs = person.inputs(first..person.record.len(), missing)?;
    let steps = inputs.len() - 1;
    let run = simulate(plant, state, &mut OpenLoop::new(&inputs), steps)?;
    let rows = run.report(plant).into_iter().enumerate();
    let row = |(step, states)| ReplayRow { step, states, time: person.record.time(first + step) };
    Ok(rows.map(row).collect())
}
