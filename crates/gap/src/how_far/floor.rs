//! The error that a perfect model would still have: noise that nobody can predict.
//!
//! The filter's own covariance is carried from a start to each horizon without readings. It is a bound
//! under the noise model and not a measurement: real noise may be smaller or larger.

use effects::{Field, Modulation};
use physiology::StepInput;
use statrs::distribution::{ContinuousCDF, Normal};

use crate::error::GapError;
use crate::filter::augmented::AugmentedModel;
use crate::filter::covariance::Covariance;
use crate::filter::kalman::Filtered;
use crate::filter::observations::{Observations, within_sensor_range};
use crate::filter::state::{AugmentedState, FLUX, INTERSTITIAL, SENSOR, SENSOR_BEFORE};
use crate::filter::transition::Transition;
use crate::modulated_plant::ModulatedState;

/// Points of the normal distribution over which an absolute error is averaged.
const POINTS: usize = 32;

/// Covariances of a filter's run, and of free runs that leave it.
pub(super) struct Rollouts<'a> {
    model: &'a AugmentedModel,
    record: &'a Observations,
    filtered: &'a Filtered,
    /// The step before whose reading `covariance` holds.
    at: usize,
    covariance: Covariance,
    /// Quantiles of the standard normal.
    points: Vec<f64>,
}

impl<'a> Rollouts<'a> {
    /// At the start of the record that was filtered.
    pub(super) fn new(
        model: &'a AugmentedModel,
        record: &'a Observations,
        filtered: &'a Filtered,
    ) -> Self {
        let normal = Normal::standard();
        let points =
            (0..POINTS).map(|k| normal.inverse_cdf((k as f64 + 0.5) / POINTS as f64)).collect();
        let covariance = crate::filter::kalman::start(model, record).1;
        Self { model, record, filtered, at: 0, covariance, points }
    }

    /// Expected absolute errors of a free run that is right but for noise, mg/dL, at some horizons: `None`
    /// beyond the run's end.
    ///
    /// `offset` is the run's start in the filtered record, not before that of the last call; `inputs` begin
    /// there, `modulations` belong to the steps of `states`. The run leaves out the filter's flux and
    /// sensor error, so that their size counts as error.
    ///
    /// # Errors
    /// [`GapError::FilterNotFinite`].
    pub(super) fn expected_errors(
        &mut self,
        offset: usize,
        states: &[ModulatedState],
        inputs: &[StepInput],
        modulations: &[Modulation],
        horizons: &[usize],
    ) -> Result<Vec<Option<f64>>, GapError> {
        let free = Expecting { rollouts: self, offset, states, inputs, modulations, horizons };
        pulp::Arch::new().dispatch(free)
    }

    /// Expected distance of a reading from its prediction, both within the sensor's range.
    fn absolute(&self, prediction: f64, sd: f64) -> f64 {
        let shown = within_sensor_range(prediction);
        let distance = |z: &f64| (within_sensor_range(prediction + sd * z) - shown).abs();
        self.points.iter().map(distance).sum::<f64>() / self.points.len() as f64
    }

    #[inline(always)]
    fn after_reading(&self, offset: usize) -> Covariance {
        let mut covariance = self.covariance;
        if self.filtered.gains[offset].is_some() {
            covariance.update(self.model.noise().reading_sd.powi(2));
        }
        covariance
    }

    #[inline(always)]
    fn onward(
        &self,
        covariance: &mut Covariance,
        state: &AugmentedState,
        input: &StepInput,
        modulation: &Modulation,
        step: usize,
    ) -> Result<(), GapError> {
        self.model.add_meal_noise(covariance, input);
        let mut transition = Transition::default();
        let following = self
            .model
            .linearised_into(state, input, modulation, &mut transition)
            .map_err(|_| GapError::FilterNotFinite { person: self.record.person.clone(), step })?;
        covariance.propagate(&transition);
        self.model.add_process_noise(covariance, input, &following);
        Ok(())
    }
}

/// A free run whose errors are expected ([`Rollouts::expected_errors`]), compiled for the instructions of the machine it
/// runs on, with the same rounding on all of them.
struct Expecting<'a, 'b> {
    rollouts: &'a mut Rollouts<'b>,
    offset: usize,
    states: &'a [ModulatedState],
    inputs: &'a [StepInput],
    modulations: &'a [Modulation],
    horizons: &'a [usize],
}

impl pulp::NullaryFnOnce for Expecting<'_, '_> {
    type Output = Result<Vec<Option<f64>>, GapError>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        let Self { rollouts, offset, states, inputs, modulations, horizons } = self;
        while rollouts.at < offset {
            let mut covariance = rollouts.after_reading(rollouts.at);
            let state = &rollouts.filtered.states[rollouts.at];
            let input = &rollouts.record.inputs[rollouts.at];
            let modulation = rollouts.record.modulation(rollouts.at);
            rollouts.onward(&mut covariance, state, input, modulation, rollouts.at)?;
            rollouts.covariance = covariance;
            rollouts.at += 1;
        }
        let mut covariance = rollouts.after_reading(offset);
        let start = &rollouts.filtered.states[offset];
        covariance.add(FLUX, start.flux.powi(2));
        let (sensor, before) = (start.sensor.0, start.sensor_before.0);
        covariance.add(SENSOR, sensor.powi(2));
        covariance.add(SENSOR_BEFORE, before.powi(2));
        covariance.link(SENSOR, SENSOR_BEFORE, sensor * before);
        let mut expected = vec![None; horizons.len()];
        let last = horizons.iter().copied().filter(|steps| *steps < states.len()).max();
        for (index, state) in states.iter().enumerate().take(last.map_or(0, |last| last + 1)) {
            let modulation = modulations.get(state.step).unwrap_or(&Modulation::NEUTRAL);
            if horizons.contains(&index) {
                let gain = modulation[Field::SensorGain];
                let variance = gain * gain * covariance.get(INTERSTITIAL, INTERSTITIAL)
                    + 2.0 * gain * covariance.get(INTERSTITIAL, SENSOR)
                    + covariance.get(SENSOR, SENSOR)
                    + rollouts.model.noise().reading_sd.powi(2);
                let reading = rollouts.model.reading(&state.state, modulation);
                let error = rollouts.absolute(reading, variance.max(0.0).sqrt());
                for (expected, _) in
                    expected.iter_mut().zip(horizons).filter(|(_, steps)| **steps == index)
                {
                    *expected = Some(error);
                }
            }
            if let Some(input) = inputs.get(index).filter(|_| Some(index) < last) {
                let step = offset + index;
                rollouts.onward(&mut covariance, &state.state, input, modulation, step)?;
            }
        }
        Ok(expected)
    }
}
