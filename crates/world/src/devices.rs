//! The sensors that a person wears one after another.
//!
//! The error model of a sensor is [`ode_sim::SensorModel`]. This module adds that sensors differ,
//! are changed, and lose readings.

use ode_sim::sensor::clamp_to_display;
use ode_sim::{OdeError, Sensor, SensorModel};
use physiology::{MgPerDl, STEPS_PER_DAY};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::effects::{Lagged, Sensing};
use crate::everyday::SensorKind;
use crate::stream::standard_normal;
use crate::wear::SensorWear;

/// The sensors of one person, read every step.
///
/// Each step takes the same number of draws for any glucose.
#[derive(Debug, Clone)]
pub(crate) struct WornSensors {
    wear: SensorWear,
    sensing: Sensing,
    lagged: Lagged,
    rng: ChaCha8Rng,
    /// For the errors that the published kind does not have.
    own: ChaCha8Rng,
    kind: SensorKind,
    current: Option<Sensor>,
}

impl WornSensors {
    /// Sensors of a kind, worn as `wear` says. `rng` gives the error (`own` gives the errors that
    /// the published kind does not have), and `sensing` adds to it.
    pub(crate) fn new(
        kind: SensorKind,
        wear: SensorWear,
        sensing: Sensing,
        rng: ChaCha8Rng,
        own: ChaCha8Rng,
    ) -> Self {
        let lagged = Lagged::new(sensing.lag_form, sensing.lag);
        Self { wear, sensing, lagged, rng, own, kind, current: None }
    }

    /// The reading of `step`, not rounded; `None` if it is lost. Steps are read in order.
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
        let (gain, offset) = self.sensing.added.get(step).copied().unwrap_or_default();
        let raw = reading.raw.0 + gain * reading.interstitial.0 + offset + self.spike();
        let shown = clamp_to_display(MgPerDl(raw));
        Ok((!self.wear.is_lost(step)).then_some(shown))
    }

    /// A sensor with its own gain. One that was inserted before the record keeps the drift of its
    /// age.
    fn model(&mut self, step: usize) -> SensorModel {
        let made = self.kind.model();
        let spread = self.kind.gain_spread;
        let own = (spread * standard_normal(&mut self.rng)).clamp(-2.0 * spread, 2.0 * spread);
        let age = self.wear.age_days(step);
        let mut offset = shifted(made.offset, age);
        if self.kind.offset_spread > 0.0 {
            let drawn = standard_normal(&mut self.own).clamp(-2.0, 2.0);
            offset[0] += self.kind.offset_spread * drawn;
        }
        SensorModel { gain: shifted(made.gain.map(|c| c * (1.0 + own)), age), offset, ..made }
    }

    /// What a spike adds to one reading, mg/dL; mostly 0.
    fn spike(&mut self) -> f64 {
        if self.kind.spikes_a_day <= 0.0 {
            return 0.0;
        }
        let (draw, size) = (self.own.random::<f64>(), self.own.random_range(12.0..45.0));
        let chance = self.kind.spikes_a_day / STEPS_PER_DAY as f64;
        match draw {
            draw if draw < 0.5 * chance => -size,
            draw if draw < chance => size,
            _ => 0.0,
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
            let kind = SensorKind::PUBLISHED;
            let wear = SensorWear::sample(&calendar, &kind, &mut rng);
            let own = stream(2, 0, Concept::SensorKind);
            let (lag, lag_form) = (physiology::Minutes(0.0), crate::LagForm::FirstOrder);
            let undisturbed = Sensing { lag, lag_form, added: Vec::new() };
            let mut sensors = WornSensors::new(kind, wear, undisturbed, rng, own);
            (0..calendar.steps())
                .map(|s| Some(sensors.sense(s, MgPerDl(glucose(s))).expect("finite")?.0.round()))
                .collect()
        };
        let flat = read(&|_| 150.0);
        let errors: Vec<f64> = flat.iter().flatten().map(|g| (g / 150.0 - 1.0).abs()).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        assert!((0.04..0.10).contains(&mean), "{mean}");
        // The two courses differ by gain and offset alone: noise and losses are the same.
        let higher = read(&|_| 160.0);
        for (low, high) in flat.iter().zip(&higher) {
            assert_eq!(low.is_some(), high.is_some());
            if let (Some(low), Some(high)) = (low, high) {
                assert!((7.0..=13.0).contains(&(high - low)), "{low} {high}"); // 10 x gain, rounded
            }
        }
    }
}
