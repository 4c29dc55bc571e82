//! Robust scaling of a person's heart rate over baseline.

use nn_statespace::CentreAndScale;
use physiology::BeatsPerMinute;

use crate::error::TwinError;

/// Median and interquartile range of a person's heart rate over baseline, on training data only
/// (paper, appendix "Robust scaler").
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct HeartRateScaler {
    /// Median, 1/min.
    pub center: f64,
    /// Interquartile range, 1/min; 1 where the range of the data is 0.
    pub scale: f64,
}

impl HeartRateScaler {
    /// Fits to the recorded values, quartiles by linear interpolation between order statistics.
    /// `None` if there are none.
    ///
    /// # Errors
    /// [`TwinError::NotFinite`] if a value is not a finite number.
    pub fn fit(
        values: impl IntoIterator<Item = BeatsPerMinute>,
    ) -> Result<Option<Self>, TwinError> {
        let values: Vec<f64> = values.into_iter().map(|v| v.0).collect();
        if values.iter().any(|v| !v.is_finite()) {
            return Err(TwinError::NotFinite("heart rate over baseline"));
        }
        let fitted = CentreAndScale::of(values);
        Ok(fitted.map(|CentreAndScale { centre, scale }| Self { center: centre, scale }))
    }

    /// (rate - median) / interquartile range, unitless.
    #[must_use]
    pub fn scale(&self, rate: BeatsPerMinute) -> f64 {
        (rate.0 - self.center) / self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_interpolate_between_neighbours() {
        let rates = [4.0, 1.0, 3.0, 2.0].map(BeatsPerMinute);
        let scaler = HeartRateScaler::fit(rates).expect("finite").expect("not empty");
        assert_eq!(scaler, HeartRateScaler { center: 2.5, scale: 1.5 });
        assert_eq!(scaler.scale(BeatsPerMinute(4.0)), 1.0);
    }

    #[test]
    fn a_constant_heart_rate_scales_to_zero() {
        let scaler = HeartRateScaler::fit([BeatsPerMinute(5.0); 3]).expect("finite");
        assert_eq!(scaler, Some(HeartRateScaler { center: 5.0, scale: 1.0 }));
    }

    #[test]
    fn no_data_gives_no_scaler_and_nan_an_error() {
        assert_eq!(HeartRateScaler::fit([]).expect("finite"), None);
        assert!(HeartRateScaler::fit([BeatsPerMinute(f64::NAN)]).is_err());
    }
}
