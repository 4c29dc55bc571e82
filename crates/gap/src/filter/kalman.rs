//! The extended Kalman filter over a person's record, and its replay with frozen gains.

use physiology::{MgPerDl, STEPS_PER_DAY, StepInput};

use crate::error::GapError;
use crate::filter::augmented::AugmentedModel;
use crate::filter::covariance::{Covariance, Gain};
use crate::filter::observations::{Observations, Reading, SENSOR_HIGH, SENSOR_LOW};
use crate::filter::state::AugmentedState;
use crate::filter::transition::Transition;

/// A reading minus what the filter expected just before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Innovation {
    /// Observed minus predicted, mg/dL: positive where glucose is under-predicted.
    pub value: f64,
    /// Its variance by the filter, mg/dL squared.
    pub variance: f64,
}

impl Innovation {
    /// The innovation in its own standard deviations.
    #[must_use]
    pub fn normalised(&self) -> f64 {
        self.value / self.variance.sqrt()
    }
}

/// What the filter made of a record; every field has one entry a step.
#[derive(Debug, Clone)]
pub struct Filtered {
    /// The state after the step's reading, before the step's inputs.
    pub states: Vec<AugmentedState>,
    /// Innovations of readings inside the sensor's range; `None` where a reading is missing,
    /// interpolated or censored.
    pub innovations: Vec<Option<Innovation>>,
    /// The gains that were applied; `None` where the filter only predicted.
    pub gains: Vec<Option<Gain>>,
}

impl Filtered {
    pub(crate) fn with_capacity(steps: usize) -> Self {
        Self {
            states: Vec::with_capacity(steps),
            innovations: Vec::with_capacity(steps),
            gains: Vec::with_capacity(steps),
        }
    }

    /// Appends what was made of a step.
    pub(crate) fn push(&mut self, step: &FilterStep<'_>) {
        self.states.push(*step.state);
        self.innovations.push(step.innovation);
        self.gains.push(step.gain);
    }
}

/// What the filter made of one step.
pub(crate) struct FilterStep<'a> {
    pub(crate) step: usize,
    pub(crate) input: &'a StepInput,
    /// Interstitial glucose expected before the step's reading, mg/dL.
    pub(crate) expected: f64,
    /// The state after the step's reading, before the step's inputs.
    pub(crate) state: &'a AugmentedState,
    pub(crate) innovation: Option<Innovation>,
    pub(crate) gain: Option<Gain>,
    /// The state expected one step later, and its derivative by `state`.
    pub(crate) following: &'a AugmentedState,
    pub(crate) transition: &'a Transition,
}

/// Where a run of the filter begins: what is expected just before the reading of a step.
#[derive(Debug, Clone)]
pub(crate) struct Begin {
    pub(crate) step: usize,
    pub(crate) state: AugmentedState,
    pub(crate) covariance: Covariance,
}

impl Begin {
    /// At the start of a record.
    pub(crate) fn of(model: &AugmentedModel, record: &Observations) -> Self {
        let (state, covariance) = start(model, record);
        Self { step: 0, state, covariance }
    }
}

/// Runs the filter.
///
/// A missing or interpolated reading is predicted through. A reading at an end of the sensor's range corrects the
/// state as if it were exact only where the expectation lies inside the range; beyond it, reading
/// and expectation agree. Neither case gives an innovation.
///
/// # Errors
/// [`GapError::FilterNotFinite`] with the step.
pub fn filter(model: &AugmentedModel, record: &Observations) -> Result<Filtered, GapError> {
    let mut filtered = Filtered::with_capacity(record.len());
    run_from(model, record, Begin::of(model, record), None, record.len(), |step, _| {
        filtered.push(&step);
        Ok(())
    })?;
    Ok(filtered)
}

/// The innovations of [`filter`] at the steps before `end`, and nothing else.
pub(crate) fn innovations(
    model: &AugmentedModel,
    record: &Observations,
    end: usize,
) -> Result<Vec<Option<Innovation>>, GapError> {
    let mut innovations = Vec::with_capacity(end.min(record.len()));
    run_from(model, record, Begin::of(model, record), None, end, |step, _| {
        innovations.push(step.innovation);
        Ok(())
    })?;
    Ok(innovations)
}

/// Runs the filter from some step on, over the steps before `end`; `first` replaces the input of the step at which it
/// begins. `visit` gets each step, and the covariance expected one step later.
pub(crate) fn run_from(
    model: &AugmentedModel,
    record: &Observations,
    begin: Begin,
    first: Option<StepInput>,
    end: usize,
    visit: impl FnMut(FilterStep<'_>, &Covariance) -> Result<(), GapError>,
) -> Result<(), GapError> {
    pulp::Arch::new().dispatch(Running { model, record, begin, first, end, visit })
}

/// A run of the filter, compiled for the instructions of the machine it runs on. Products and sums are rounded
/// one by one on all of them, so that they agree bit for bit.
struct Running<'a, F> {
    model: &'a AugmentedModel,
    record: &'a Observations,
    begin: Begin,
    first: Option<StepInput>,
    end: usize,
    visit: F,
}

impl<F: FnMut(FilterStep<'_>, &Covariance) -> Result<(), GapError>> pulp::NullaryFnOnce
    for Running<'_, F>
{
    type Output = Result<(), GapError>;

    #[inline(always)]
    fn call(self) -> Result<(), GapError> {
        let Self { model, record, begin, first, end, mut visit } = self;
        let Begin { step: begin, mut state, mut covariance } = begin;
        let variance = model.noise().reading_sd.powi(2);
        let mut transition = Transition::default();
        for step in begin..end.min(record.len()) {
            let modulation = record.modulation(step);
            let (mut gain, mut innovation) = (None, None);
            let expected = state.interstitial.0;
            let reading = record.readings[step];
            if let Some(value) = correction(reading, model.reading(&state, modulation)) {
                let update = covariance.update(variance);
                state = model.corrected(&state, &update.gain, value);
                gain = Some(update);
                innovation = matches!(reading, Reading::Within(_))
                    .then_some(Innovation { value, variance: update.innovation_variance });
            }
            let replaced = first.as_ref().filter(|_| step == begin);
            let input = replaced.unwrap_or(&record.inputs[step]);
            model.add_meal_noise(&mut covariance, input);
            let following = model
                .linearised_into(&state, input, modulation, &mut transition)
                .map_err(|_| record.not_finite(step))?;
            covariance.propagate(&transition);
            model.add_process_noise(&mut covariance, input, &following);
            let finite = gain.is_none_or(|g| g.innovation_variance.is_finite());
            if !(finite && following.flux.is_finite() && following.interstitial.0.is_finite()) {
                return Err(record.not_finite(step));
            }
            let made = FilterStep {
                step,
                input,
                expected,
                state: &state,
                innovation,
                gain,
                following: &following,
                transition: &transition,
            };
            visit(made, &covariance)?;
            state = following;
        }
        Ok(())
    }
}

/// Runs the filter with the gains of an earlier run, for another model of the same person.
///
/// States and innovations are those of `model`; gains and variances are those of `frozen`. With the gains held, the
/// innovations are a smooth function of the model's parameters, but for the kinks of the plant.
///
/// # Errors
/// As [`filter`].
pub fn replayed(
    model: &AugmentedModel,
    record: &Observations,
    frozen: &Filtered,
) -> Result<Filtered, GapError> {
    let (mut state, _) = start(model, record);
    let mut filtered = Filtered::with_capacity(record.len());
    for (step, gain) in frozen.gains.iter().enumerate() {
        let modulation = record.modulation(step);
        let reading = record.readings[step].value();
        let difference = reading.map(|value| value - model.reading(&state, modulation));
        if let (Some(gain), Some(difference)) = (gain, difference) {
            state = model.corrected(&state, &gain.gain, difference);
        }
        filtered.states.push(state);
        filtered.gains.push(*gain);
        let innovation = frozen.innovations[step].zip(difference);
        filtered.innovations.push(innovation.map(|(held, value)| Innovation { value, ..held }));
        state = model
            .step(&state, &record.inputs[step], modulation)
            .map_err(|_| record.not_finite(step))?;
    }
    Ok(filtered)
}

/// The difference that corrects the state, `None` where nothing is to be learnt.
fn correction(reading: Reading, expected: f64) -> Option<f64> {
    match reading {
        Reading::Missing | Reading::Interpolated(_) => None,
        Reading::Within(glucose) => Some(glucose.0 - expected),
        Reading::Low => (expected > SENSOR_LOW.0).then_some(SENSOR_LOW.0 - expected),
        Reading::High => (expected < SENSOR_HIGH.0).then_some(SENSOR_HIGH.0 - expected),
    }
}

pub(crate) fn start(model: &AugmentedModel, record: &Observations) -> (AugmentedState, Covariance) {
    debug_assert_eq!(record.readings.len(), record.inputs.len(), "an entry a step");
    let first = record.readings.iter().find_map(|reading| reading.value()).unwrap_or(120.0);
    model.start(record.initial_basal(STEPS_PER_DAY), MgPerDl(first))
}
