//! Free runs: a plant let loose from filtered states, against what the sensor then read.
//!
//! Any plant can be judged. The caller says in which state it starts; the plant then sees the
//! recorded insulin and carbohydrate and no further reading. Its glucose goes through the same
//! interstitial lag and sensor range as a reading.

use physiology::{MgPerDl, OpenLoop, Plant, simulate};
use serde::{Deserialize, Serialize};

use crate::error::GapError;
use crate::filter::augmented::{AugmentedModel, Euler};
use crate::filter::observations::{Observations, Reading, within_sensor_range};
use crate::filter::state::AugmentedState;
use crate::modulated_plant::{ModulatedPlant, ModulatedState};

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

/// Minutes of so many steps.
pub(crate) fn minutes(steps: usize) -> u32 {
    u32::try_from(5 * steps).unwrap_or(u32::MAX)
}

/// One error of a free run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeRunError {
    /// The step at which the run started.
    pub start: usize,
    /// Index of the horizon in [`FreeRunRule::horizons`].
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
/// `start_at` makes the plant's state at the start of a step, and interstitial glucose then.
/// `lag_decay` is the share of the distance between interstitial and plasma glucose left after one
/// step. An error is counted where the target has a reading and every dose on the way is on record.
/// Predictions beyond the sensor's range are reported as its end, as a sensor would.
///
/// # Errors
/// [`GapError::FreeRun`] with the start.
pub fn free_run_errors<P: Plant>(
    plant: &P,
    record: &Observations,
    rule: &FreeRunRule,
    lag_decay: f64,
    start_at: impl Fn(usize) -> (P::State, MgPerDl),
) -> Result<Vec<FreeRunError>, GapError> {
    let longest = rule.horizons.iter().copied().max().unwrap_or(0);
    errors_of(record, rule, |start, horizons| {
        let (state, begin) = start_at(start);
        let steps = longest.min(record.len() - 1 - start);
        let run = simulate(plant, state, &mut OpenLoop::new(&record.inputs[start..]), steps)
            .map_err(|source| GapError::FreeRun { person: record.person.clone(), start, source })?;
        let mut interstitial = vec![begin.0];
        for ends in run.glucose(plant).windows(2) {
            let plasma = 0.5 * (ends[0].0 + ends[1].0);
            let before = interstitial[interstitial.len() - 1];
            interstitial.push(plasma + (before - plasma) * lag_decay);
        }
        Ok(horizons.iter().map(|steps| interstitial[*steps]).collect())
    })
}

/// The errors of runs from each start. `run` gives interstitial glucose, mg/dL, of the run from a
/// start at horizons in steps: those of the rule that lie within the record, ascending, each once.
/// The rule may have them in any order.
fn errors_of<E>(
    record: &Observations,
    rule: &FreeRunRule,
    run: impl Fn(usize, &[usize]) -> Result<Vec<f64>, E>,
) -> Result<Vec<FreeRunError>, E> {
    let mut horizons: Vec<(usize, usize)> =
        rule.horizons.iter().enumerate().map(|(index, steps)| (*steps, index)).collect();
    horizons.retain(|(steps, _)| *steps > 0);
    horizons.sort_unstable();
    horizons.dedup_by_key(|(steps, _)| *steps);
    let (ascending, indices): (Vec<usize>, Vec<usize>) = horizons.into_iter().unzip();
    let mut errors = Vec::new();
    for start in starts(record, rule) {
        let within = ascending.partition_point(|steps| start + steps < record.len());
        let interstitial = run(start, &ascending[..within])?;
        for ((steps, horizon), shown) in ascending.iter().zip(&indices).zip(interstitial) {
            let target = start + steps;
            let complete = record.doses_recorded[start..target].iter().all(|recorded| *recorded);
            if let Some(observed) = record.readings[target].value().filter(|_| complete) {
                let error = observed - within_sensor_range(shown);
                errors.push(FreeRunError { start, horizon: *horizon, error });
            }
        }
    }
    Ok(errors)
}

/// What becomes of the filter's unexplained flux in a free run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Flux {
    /// It is dropped: the body alone.
    Dropped,
    /// It decays as the filter expects.
    Kept,
}

impl Flux {
    /// The state in which a free run from a filtered state starts.
    fn begin(self, filtered: &AugmentedState) -> AugmentedState {
        match self {
            Self::Dropped => AugmentedState { flux: 0.0, ..*filtered },
            Self::Kept => *filtered,
        }
    }
}

/// [`free_run_errors`] of a person's model from the filter's `states`, one a step of the record.
///
/// # Errors
/// [`GapError::FreeRun`] with the start.
pub(crate) fn free_run_errors_of(
    model: &AugmentedModel,
    record: &Observations,
    rule: &FreeRunRule,
    states: &[AugmentedState],
    flux: Flux,
) -> Result<Vec<FreeRunError>, GapError> {
    if let Some(errors) = plain_errors(model, record, rule, states, flux) {
        return Ok(errors);
    }
    let plant = ModulatedPlant::new(model, &[]);
    free_run_errors(&plant, record, rule, model.lag_decay(), |step| {
        let state = ModulatedState { step, state: flux.begin(&states[step]) };
        (state, states[step].interstitial)
    })
}

/// The same by the step worked out beforehand: nothing is kept of a run but its readings at the horizons.
/// `None` where that step does not cover all of the record, or where a run breaks.
fn plain_errors(
    model: &AugmentedModel,
    record: &Observations,
    rule: &FreeRunRule,
    states: &[AugmentedState],
    flux: Flux,
) -> Option<Vec<FreeRunError>> {
    let euler = model.euler()?;
    let covered = |(state, input): (&AugmentedState, _)| Euler::covers(&state.body, input);
    if !states.iter().zip(&record.inputs).all(covered) {
        return None;
    }
    let doses: Vec<[f64; 2]> = record.inputs.iter().map(|input| euler.doses(input)).collect();
    let errors = errors_of(record, rule, |start, horizons| {
        let mut run = model.plain_run(euler, &flux.begin(&states[start]));
        let mut at = start;
        let mut interstitial = Vec::with_capacity(horizons.len());
        for steps in horizons {
            run.advance(&doses[at..start + steps]);
            at = start + steps;
            interstitial.push(run.interstitial);
        }
        if run.is_finite() { Ok(interstitial) } else { Err(()) }
    });
    errors.ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use physiology::{Compartment, Kilograms, NonFinite, States, StepInput};

    /// Glucose that rises by 10 mg/dL a step and breaks above 10,000.
    struct Rising;

    impl Plant for Rising {
        type State = f64;

        fn step(&self, x: &f64, _: &StepInput) -> Result<f64, NonFinite> {
            if *x > 10_000.0 {
                return Err(NonFinite { compartment: Compartment::Q1 });
            }
            Ok(x + 10.0)
        }

        fn glucose(&self, x: &f64) -> MgPerDl {
            MgPerDl(*x)
        }

        fn report(&self, _: &f64) -> States {
            States::default()
        }
    }

    fn record(steps: usize) -> Observations {
        Observations {
            person: "p".into(),
            weight: Kilograms(70.0),
            readings: vec![Reading::Within(MgPerDl(150.0)); steps],
            inputs: vec![StepInput::default(); steps],
            doses_recorded: vec![true; steps],
            modulations: Vec::new(),
            interpolated_share: 0.0,
        }
    }

    fn rule() -> FreeRunRule {
        FreeRunRule { every: 4, burn_in: 2, horizons: vec![2, 5], dose_memory: 3 }
    }

    fn from(glucose: f64) -> impl Fn(usize) -> (f64, MgPerDl) {
        move |_| (glucose, MgPerDl(glucose))
    }

    #[test]
    fn errors_are_observed_minus_predicted_at_each_horizon() {
        // Starts at 2, 6, 10; the record ends at 11, so 6 reaches both horizons and 10 neither.
        let found = free_run_errors(&Rising, &record(12), &rule(), 0.0, from(100.0)).expect("runs");
        // Without a lag the sensor shows the mean of the last step's ends: 115 and 145.
        let expected: Vec<FreeRunError> = [2, 6]
            .into_iter()
            .flat_map(|start| {
                [(0, 35.0), (1, 5.0)].map(|(horizon, error)| FreeRunError { start, horizon, error })
            })
            .collect();
        assert_eq!(found, expected);
    }

    #[test]
    fn horizons_may_come_in_any_order_and_more_than_once() {
        let of = |rule: &FreeRunRule| {
            free_run_errors(&Rising, &record(12), rule, 0.0, from(100.0)).expect("runs")
        };
        let mixed = FreeRunRule { horizons: vec![5, 0, 2, 5], ..rule() };
        let places = [2, 0];
        let expected: Vec<FreeRunError> = of(&rule())
            .into_iter()
            .map(|error| FreeRunError { horizon: places[error.horizon], ..error })
            .collect();
        assert_eq!(of(&mixed), expected);
    }

    #[test]
    fn the_lag_holds_the_prediction_back_and_the_sensor_cuts_it_off() {
        let rule = FreeRunRule { horizons: vec![1], ..rule() };
        let found = free_run_errors(&Rising, &record(4), &rule, 0.5, from(100.0)).expect("runs");
        assert_eq!(found[0].error, 150.0 - 102.5);
        let found = free_run_errors(&Rising, &record(4), &rule, 0.0, from(600.0)).expect("runs");
        assert_eq!(found[0].error, 150.0 - 400.0);
    }

    #[test]
    fn missing_readings_and_unrecorded_doses_leave_runs_out() {
        let mut record = record(12);
        record.readings[6] = Reading::Missing;
        assert_eq!(starts(&record, &rule()), [2, 10]);
        record.readings[4] = Reading::Missing;
        record.doses_recorded[8] = false;
        // The run from 2 has no reading at 4 and one at 7; that from 10 follows a dose unknown.
        let found = free_run_errors(&Rising, &record, &rule(), 0.0, from(100.0)).expect("runs");
        assert_eq!(found.iter().map(|e| (e.start, e.horizon)).collect::<Vec<_>>(), [(2, 1)]);
        record.doses_recorded[5] = false;
        let found = free_run_errors(&Rising, &record, &rule(), 0.0, from(100.0)).expect("runs");
        assert_eq!(found, []);
    }

    #[test]
    fn a_run_that_breaks_names_person_and_start() {
        let error = free_run_errors(&Rising, &record(12), &rule(), 0.0, from(20_000.0));
        let message = error.expect_err("breaks").to_string();
        assert!(message.starts_with("person p, free run from step 2: Q1"), "{message}");
    }

    #[test]
    fn runs_by_the_step_worked_out_beforehand_agree_with_those_of_the_plant() {
        use crate::filter::noise::NoiseModel;
        use ode_sim::OdeParameters;
        use physiology::{Exercise, Grams, Units, UnitsPerHour};
        let mut record = record(200);
        for (step, input) in record.inputs.iter_mut().enumerate() {
            input.basal = UnitsPerHour(1.0);
            input.bolus = Units(if step % 60 == 20 { 5.0 } else { 0.0 });
            input.carbs = Grams(if step % 60 == 22 { 55.0 } else { 0.0 });
        }
        record.readings[31] = Reading::Missing;
        record.doses_recorded[150] = false;
        let (noise, nominal) = (NoiseModel::working(), OdeParameters::nominal());
        let model = AugmentedModel::new(nominal, record.weight, noise);
        let states = crate::filter::kalman::filter(&model, &record).expect("finite").states;
        let rule = FreeRunRule { every: 7, horizons: vec![30, 5, 90], ..rule() };
        for flux in [Flux::Dropped, Flux::Kept] {
            let found = plain_errors(&model, &record, &rule, &states, flux).expect("covered");
            let plant = ModulatedPlant::new(&model, &[]);
            let start = |step: usize| {
                let state = ModulatedState { step, state: flux.begin(&states[step]) };
                (state, states[step].interstitial)
            };
            let expected =
                free_run_errors(&plant, &record, &rule, noise.lag_decay(), start).expect("finite");
            assert!(expected.len() > 40 && expected.iter().any(|e| e.error.abs() > 20.0));
            assert_eq!(found.len(), expected.len());
            for (found, expected) in found.iter().zip(&expected) {
                assert_eq!((found.start, found.horizon), (expected.start, expected.horizon));
                // Rounding of 90 steps.
                assert!((found.error - expected.error).abs() < 1e-9, "{found:?} {expected:?}");
            }
        }
        record.inputs[40].exercise =
            Some(Exercise { vo2max_percent: 50.0, active_muscle_share: 0.5 });
        assert_eq!(plain_errors(&model, &record, &rule, &states, Flux::Kept), None);
    }
}
