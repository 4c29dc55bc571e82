//! The error that a perfect model would still have: noise that nobody can predict.
//!
//! The filter's own covariance is carried from a start to each horizon without readings. It is a bound
//! under the noise model and not a measurement: real noise may be smaller or larger.

use effects::{Field, Modulation};
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

    /// From after the reading of a step to before that of the next.
    #[inline(always)]
    fn onward(
        &self,
        covariance: &mut Covariance,
        state: &AugmentedState,
        modulation: &Modulation,
        step: usize,
    ) -> Result<(), GapError> {
        let input = &self.record.inputs[step];
        self.model.add_meal_noise(covariance, input);
        let mut transition = Transition::default();
        let following = self
            .model
            .linearised_into(state, input, modulation, &mut transition)
            .map_err(|_| self.record.not_finite(step))?;
        covariance.propagate(&transition);
        self.model.add_process_noise(covariance, input, &following);
        Ok(())
    }
}

/// Expected absolute errors of a free run that is right but for noise, mg/dL, an entry a horizon:
/// `None` beyond the run's end.
///
/// The run leaves out the filter's flux and sensor error, so that their size counts as error. Dispatched by
/// [`pulp::Arch`], it is compiled for the instructions of the machine it runs on, with the same rounding on all of them.
/// Fails with [`GapError::FilterNotFinite`].
pub(super) struct ExpectedErrors<'a, 'b> {
    pub(super) rollouts: &'a mut Rollouts<'b>,
    /// The run's start in the filtered record, not before that of the last run.
    pub(super) offset: usize,
    pub(super) states: &'a [ModulatedState],
    /// What acts in each step of the whole record.
    pub(super) modulations: &'a [Modulation],
    /// Steps.
    pub(super) horizons: &'a [usize],
}

impl pulp::NullaryFnOnce for ExpectedErrors<'_, '_> {
    type Output = Result<Vec<Option<f64>>, GapError>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        let Self { rollouts, offset, states, modulations, horizons } = self;
        while rollouts.at < offset {
            let mut covariance = rollouts.after_reading(rollouts.at);
            let state = &rollouts.filtered.states[rollouts.at];
            let modulation = rollouts.record.modulation(rollouts.at);
            rollouts.onward(&mut covariance, state, modulation, rollouts.at)?;
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
            let modulation = &modulations[state.step];
            if horizons.contains(&index) {
                let gain = modulation[Field::SensorGain];
                let variance = gain * gain * covariance.get(INTERSTITIAL, INTERSTITIAL)
                    + 2.0 * gain * covariance.get(INTERSTITIAL, SENSOR)
                    + covariance.get(SENSOR, SENSOR)
                    + rollouts.model.noise().reading_sd.powi(2);
                let reading = rollouts.model.reading(&state.state, modulation);
                let error = rollouts.absolute(reading, variance.max(0.0).sqrt());
                let here = expected.iter_mut().zip(horizons).filter(|(_, steps)| **steps == index);
                here.for_each(|(expected, _)| *expected = Some(error));
            }
            if Some(index) < last {
                rollouts.onward(&mut covariance, &state.state, modulation, offset + index)?;
            }
        }
        Ok(expected)
    }
}
