//! What the filter assumes about noise: sensor, disturbances, and dosing errors.

use physiology::STEP;
use serde::{Deserialize, Serialize};

use crate::error::{GapError, require};

/// Noise settings of the extended Kalman filter.
///
/// [`NoiseModel::working`] holds the values of highest likelihood over made and recorded people: their
/// innovations have about the standard deviation that the filter expects. A fitted autoregression takes
/// care of the rest ([`whitening`](crate::filter::whitening)).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct NoiseModel {
    /// Stationary standard deviation of the Ornstein-Uhlenbeck flux into Q1, mmol/kg/min.
    pub flux_sd: f64,
    /// Correlation time of that flux, min.
    pub flux_time: f64,
    /// Coefficient of variation of a carbohydrate count.
    pub carb_count_cv: f64,
    /// Coefficient of variation of the insulin that arrives in S1 within a step.
    pub insulin_cv: f64,
    /// Relative standard deviation of the noise on X1, X2, X3 per step.
    pub effect_cv: f64,
    /// Standard deviation of the noise on Q1 per step, mmol/kg.
    pub glucose_sd: f64,
    /// Time constant between plasma and interstitial glucose, min.
    pub interstitial_lag: f64,
    /// Stationary standard deviation of the sensor error, an autoregression of order two, mg/dL.
    pub sensor_sd: f64,
    /// Correlation of the sensor error from one step to the next.
    pub sensor_correlation: f64,
    /// Its partial correlation with the error two steps before, given that one step before: its second coefficient.
    /// Below 0 for an error that is smoother than one of order one.
    pub sensor_partial_correlation: f64,
    /// Standard deviation of the white part of a reading, mg/dL.
    pub reading_sd: f64,
}

impl NoiseModel {
    /// The values in use.
    #[must_use]
    pub const fn working() -> Self {
        Self {
            flux_sd: 0.0065,       // mmol/kg/min: 0.4 of nominal EGP0
            flux_time: 40.0,       // min
            carb_count_cv: 0.38,   // adults miscount by 20 to 30 %, and meals differ from sugar
            insulin_cv: 0.18,      // pump and absorption together
            effect_cv: 0.025,      // per step
            glucose_sd: 0.01,      // mmol/kg: 1.1 mg/dL
            interstitial_lag: 8.0, // min: 6 to 12 in published sensor models
            // mg/dL and per step; 8.1, 0.90 and -0.40: Vettoretti et al., Sensors 2019;19:5320
            sensor_sd: 8.0,
            sensor_correlation: 0.93,
            sensor_partial_correlation: -0.36,
            reading_sd: 0.3, // mg/dL: rounding to whole mg/dL gives 0.29
        }
    }

    /// Checks that the settings can be.
    ///
    /// # Errors
    /// [`GapError::Setting`] naming the first that cannot.
    pub fn validated(self) -> Result<Self, GapError> {
        let named = [
            ("flux_sd", self.flux_sd),
            ("flux_time", self.flux_time),
            ("carb_count_cv", self.carb_count_cv),
            ("insulin_cv", self.insulin_cv),
            ("effect_cv", self.effect_cv),
            ("glucose_sd", self.glucose_sd),
            ("interstitial_lag", self.interstitial_lag),
            ("sensor_sd", self.sensor_sd),
            ("sensor_correlation", self.sensor_correlation),
            ("sensor_partial_correlation", self.sensor_partial_correlation),
            ("reading_sd", self.reading_sd),
        ];
        for (name, value) in named {
            let (accepted, requirement) = match name {
                "flux_time" | "interstitial_lag" | "reading_sd" => {
                    (value > 0.0, "positive and finite")
                }
                "sensor_partial_correlation" => (value.abs() < 1.0, "between -1 and 1"),
                _ => (value >= 0.0, "finite and not negative"),
            };
            require(value.is_finite() && accepted, name, value, requirement)?;
        }
        let correlation = self.sensor_correlation;
        require(correlation < 1.0, "sensor_correlation", correlation, "below 1")?;
        Ok(self)
    }

    /// Coefficients of the sensor error on the errors one and two steps before.
    ///
    /// By Levinson's recursion from the two partial correlations, both between -1 and 1: always stationary.
    #[must_use]
    pub fn sensor_coefficients(&self) -> [f64; 2] {
        let second = self.sensor_partial_correlation;
        [self.sensor_correlation * (1.0 - second), second]
    }

    /// Variance of what is new in the sensor error in each step, mg/dL squared.
    #[must_use]
    pub fn sensor_noise(&self) -> f64 {
        let (first, second) = (self.sensor_correlation, self.sensor_partial_correlation);
        self.sensor_sd.powi(2) * (1.0 - first * first) * (1.0 - second * second)
    }

    /// Share of the flux that is left after one step.
    #[must_use]
    pub fn flux_decay(&self) -> f64 {
        (-STEP.0 / self.flux_time).exp()
    }

    /// Share of the distance between interstitial and plasma glucose that is left after one step.
    #[must_use]
    pub fn lag_decay(&self) -> f64 {
        (-STEP.0 / self.interstitial_lag).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_that_cannot_be_are_named() {
        assert!(NoiseModel::working().validated().is_ok());
        let cases = [
            (NoiseModel { reading_sd: 0.0, ..NoiseModel::working() }, "reading_sd"),
            (NoiseModel { flux_sd: -1.0, ..NoiseModel::working() }, "flux_sd"),
            (NoiseModel { flux_time: f64::NAN, ..NoiseModel::working() }, "flux_time"),
            (NoiseModel { sensor_correlation: 1.0, ..NoiseModel::working() }, "sensor_correlation"),
            (
                NoiseModel { sensor_partial_correlation: -1.0, ..NoiseModel::working() },
                "sensor_partial_correlation",
            ),
        ];
        for (noise, expected) in cases {
            let error = noise.validated().expect_err(expected);
            assert!(matches!(error, GapError::Setting { name, .. } if name == expected));
        }
    }

    #[test]
    fn the_sensor_error_has_the_spread_and_the_correlation_that_are_set() {
        let noise = NoiseModel {
            sensor_sd: 5.0,
            sensor_correlation: 0.9,
            sensor_partial_correlation: -0.4,
            ..NoiseModel::working()
        };
        let [a1, a2] = noise.sensor_coefficients();
        // Second moments of the errors of two successive steps, carried on until they rest.
        let (mut variance, mut covariance) = (0.0, 0.0);
        for _ in 0..10_000 {
            let next = a1 * a1 * variance + 2.0 * a1 * a2 * covariance + a2 * a2 * variance;
            covariance = a1 * variance + a2 * covariance;
            variance = next + noise.sensor_noise();
        }
        assert!((variance - 25.0).abs() < 1e-9, "{variance}"); // rounding of the recursion
        assert!((covariance / variance - 0.9).abs() < 1e-9, "{covariance}");
    }
}
