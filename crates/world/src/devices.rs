//! The sensors that a person wears one after another.
//!
//! The error model of a sensor is [`ode_sim::SensorModel`]; this adds that sensors differ, are
//! changed, and lose readings.

use ode_sim::sensor::clamp_to_display;
use ode_sim::{OdeError, Sensor, SensorModel};
use physiology::MgPerDl;
use rand_chacha::ChaCha8Rng;

use crate::behaviour::standard_normal;
use crate::effects::{Lagged, Sensing};
use crate::wear::SensorWear;

/// Spread of the gain between sensors, as a share: with drift and noise this gives absolute
/// differences near the 9 to 10 % that factory-calibrated sensors show (Wadwa et al., Diabetes
/// Technol Ther 2018;20:395).
const GAIN_SPREAD: f64 = 0.05;

/// The sensors of one person, read every step.
///
/// Each step takes the same number of draws whatever glucose is.
#[derive(Debug, Clone)]
pub(crate) struct WornSensors {
    wear: SensorWear,
    sensing: Sensing,
    lagged: Lagged,
    rng: ChaCha8Rng,
    current: Option<Sensor>,
}

impl WornSensors {
    /// Sensors worn as `wear` says, with error drawn from `rng` and what `sensing` adds to it.
    pub(crate) fn new(wear: SensorWear, sensing: Sensing, rng: ChaCha8Rng) -> Self {
        let lagged = Lagged::new(sensing.lag);
        Self { wear, sensing, lagged, rng, current: None }
    }

    /// The reading of `step`, in whole mg/dL; `None` if it is lost. Steps are read in order.
    ///
    /// # Errors
    /// [`OdeError::Argument`] if glucose is not finite.
    pub(crate) fn read(
        &mut self,
        step: usize,
        glucose: MgPerDl,
    ) -> Result<Option<MgPerDl>, OdeError> {
        Ok(self.sense(step, glucose)?.map(|shown| MgPerDl(shown.0.round())))
    }

    /// As [`Self::read`], before it is rounded.
    ///
    /// # Errors
    /// [`OdeError::Argument`] if glucose is not finite.
    pub(crate) fn sense(
        &mut self,
        step: usize,
        glucose: MgPerDl,
    ) -> Result<Option<MgPerDl>, OdeError> {
        let glucose = self.lagged.pass(glucose);
        let reading = match self.current.as_mut().filter(|_| !self.wear.starts_at(step)) {
            Some(sensor) => sensor.next(glucose, &mut self.rng)?,
            None => {
                let sensor = Sensor::inserted(self.model(step), glucose, &mut self.rng)?;
                self.current.insert(sensor).reading()
            }
        };
        let (gain, offset) = self.sensing.at(step);
        let shown =
            clamp_to_display(MgPerDl(reading.raw.0 + gain * reading.interstitial.0 + offset));
        Ok((!self.wear.is_lost(step)).then_some(shown))
    }

    /// A sensor with a gain of its own. One that was put in before the record keeps the drift of
    /// its age.
    fn model(&mut self, step: usize) -> SensorModel {
        let published = SensorModel::dexcom_g6();
        let own = (GAIN_SPREAD * standard_normal(&mut self.rng)).clamp(-0.1, 0.1);
        let age = self.wear.age_days(step);
        SensorModel {
            gain: shifted(published.gain.map(|c| c * (1.0 + own)), age),
            offset: shifted(published.offset, age),
            ..published
        }
    }
}

/// The polynomial c0 + c1 t + c2 t^2 with t counted from `age` on.
fn shifted([c0, c1, c2]: [f64; 3], age: f64) -> [f64; 3] {
    [c0 + age * (c1 + age * c2), c1 + 2.0 * c2 * age, c2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calendar::Calendar;
    use crate::stream::{Concept, stream};
    use chrono::NaiveDate;

    #[test]
    fn a_shifted_polynomial_goes_on_where_the_published_one_is() {
        let published = [1.048, -0.033, 0.002];
        let at = |c: [f64; 3], t: f64| c[0] + t * (c[1] + t * c[2]);
        // Rounding of a few products.
        assert!((at(shifted(published, 3.5), 2.0) - at(published, 5.5)).abs() < 1e-14);
    }

    #[test]
    fn readings_err_by_the_usual_tenth_and_by_chance_alone() {
        let start = NaiveDate::from_ymd_opt(2024, 1, 8).expect("a date");
        let calendar = Calendar::new(start, 200);
        let read = |glucose: &dyn Fn(usize) -> f64| -> Vec<Option<f64>> {
            let mut rng = stream(2, 0, Concept::Sensor);
            let wear = SensorWear::sample(&calendar, &mut rng);
            let mut sensors = WornSensors::new(wear, Sensing::undisturbed(), rng);
            (0..calendar.steps())
                .map(|s| Some(sensors.read(s, MgPerDl(glucose(s))).expect("finite")?.0))
                .collect()
        };
        let flat = read(&|_| 150.0);
        let errors: Vec<f64> = flat.iter().flatten().map(|g| (g / 150.0 - 1.0).abs()).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        assert!((0.04..0.10).contains(&mean), "{mean}");
        // Gain and offset alone tell two courses apart: noise and losses are the same.
        let higher = read(&|_| 160.0);
        for (low, high) in flat.iter().zip(&higher) {
            assert_eq!(low.is_some(), high.is_some());
            if let (Some(low), Some(high)) = (low, high) {
                assert!((7.0..=13.0).contains(&(high - low)), "{low} {high}"); // 10 x gain, rounded
            }
        }
    }
}
