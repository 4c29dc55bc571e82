//! Free runs: a plant let loose from filtered states, against what the sensor then read.
//!
//! Any plant can be judged. The caller says in which state it starts; the plant then sees the
//! recorded insulin and carbohydrate and no further reading. Its glucose goes through the same
//! interstitial lag and sensor range as a reading.

use physiology::{MgPerDl, OpenLoop, Plant, simulate};
use serde::{Deserialize, Serialize};

use crate::error::GapError;
use crate::observations::{Observations, Reading, within_sensor_range};

/// When free runs start and how far they are judged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FreeRunRule {
    /// Steps from one start to the next.
    pub every: usize,
    /// Steps at the start of the record before the first run.
    pub burn_in: usize,
    /// Horizons, steps, in ascending order.
    pub horizons: Vec<usize>,
    /// Steps after an unrecorded dose in which no run starts.
    pub dose_memory: usize,
}

impl FreeRunRule {
    /// The values in use: a start every half hour from 12 h on, judged at 60, 300 and 1440 min.
    #[must_use]
    pub fn working() -> Self {
        Self { every: 6, burn_in: 144, horizons: vec![12, 60, 288], dose_memory: 48 }
    }
}

/// Where a free run begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start<S> {
    /// The plant's state at the start of the step.
    pub state: S,
    /// Interstitial glucose then.
    pub interstitial: MgPerDl,
}

/// One error of a free run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeRunError {
    /// The step at which the run started.
    pub start: usize,
    /// Place of the horizon in [`FreeRunRule::horizons`].
    pub horizon: usize,
    /// Observed minus predicted, mg/dL: positive where glucose is under-predicted.
    pub error: f64,
}

/// Steps at which free runs of this record start: on the rule's grid, with a reading, and with no
/// unrecorded dose that could still act.
#[must_use]
pub fn starts(record: &Observations, rule: &FreeRunRule) -> Vec<usize> {
    let trusted = record.trusted(rule.dose_memory);
    (rule.burn_in..record.len())
        .step_by(rule.every.max(1))
        .filter(|step| trusted[*step] && record.readings[*step] != Reading::Missing)
        .collect()
}

/// Runs `plant` from each start and compares it with the readings at the rule's horizons.
///
/// `start_at` makes the plant's state at a step. `lag_decay` is the share of the distance between
/// interstitial and plasma glucose left after one step. An error is counted where the target has a
/// reading and every dose on the way is on record. Predictions beyond the sensor's range are
/// reported as its end, as a sensor would.
///
/// # Errors
/// [`GapError::FreeRun`] with the start.
pub fn free_run_errors<P: Plant>(
    plant: &P,
    record: &Observations,
    rule: &FreeRunRule,
    lag_decay: f64,
    start_at: impl Fn(usize) -> Start<P::State>,
) -> Result<Vec<FreeRunError>, GapError> {
    let longest = rule.horizons.iter().copied().max().unwrap_or(0);
    // unrecorded[k]: steps before k whose doses are not on record.
    let mut unrecorded = vec![0usize];
    for recorded in &record.doses_recorded {
        unrecorded.push(unrecorded.last().copied().unwrap_or(0) + usize::from(!recorded));
    }
    let mut errors = Vec::new();
    for start in starts(record, rule) {
        let begin = start_at(start);
        let steps = longest.min(record.len() - 1 - start);
        let run = simulate(plant, begin.state, &mut OpenLoop::new(&record.inputs[start..]), steps)
            .map_err(|source| GapError::FreeRun { person: record.person.clone(), start, source })?;
        let glucose = run.glucose(plant);
        let mut interstitial = begin.interstitial.0;
        for step in 1..glucose.len() {
            let plasma = 0.5 * (glucose[step - 1].0 + glucose[step].0);
            interstitial = plasma + (interstitial - plasma) * lag_decay;
            let Some(horizon) = rule.horizons.iter().position(|h| *h == step) else { continue };
            let target = start + step;
            let complete = unrecorded[target] == unrecorded[start];
            if let Some(observed) = record.readings[target].value().filter(|_| complete) {
                let error = observed - within_sensor_range(interstitial);
                errors.push(FreeRunError { start, horizon, error });
            }
        }
    }
    Ok(errors)
}
