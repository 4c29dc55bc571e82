//! The settings of a diagnosis.

use serde::{Deserialize, Serialize};

use crate::error::GapError;
use crate::filter::calibration::CalibrationRule;
use crate::filter::noise::NoiseModel;
use crate::filter::observations::MissingDosePolicy;
use crate::free_run::FreeRunRule;
use crate::localisation::LocalisationRule;

/// Settings of a diagnosis. There is no default: each changes the result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DiagnosisConfig {
    /// Noise settings of the filter.
    pub noise: NoiseModel,
    /// Personal calibration.
    pub calibration: CalibrationRule,
    /// Free runs.
    pub free_run: FreeRunRule,
    /// Cells, resampling and levels.
    pub localisation: LocalisationRule,
    /// Who is diagnosed.
    pub inclusion: InclusionRule,
    /// What is done about unrecorded doses.
    pub missing_doses: MissingDosePolicy,
}

impl DiagnosisConfig {
    /// The settings in use for people's data.
    #[must_use]
    pub fn working() -> Self {
        Self {
            noise: NoiseModel::working(),
            calibration: CalibrationRule::working(),
            free_run: FreeRunRule::working(),
            localisation: LocalisationRule::working(),
            inclusion: InclusionRule::working(),
            missing_doses: MissingDosePolicy::HoldBasal,
        }
    }

    /// Checks that the settings can be.
    ///
    /// # Errors
    /// [`GapError::Setting`] naming the first that cannot.
    pub fn validated(self) -> Result<Self, GapError> {
        self.noise.validated()?;
        self.localisation.validated()?;
        let wrong = |name, value: f64, requirement| GapError::Setting { name, value, requirement };
        if self.calibration.tolerance.is_nan() || self.calibration.tolerance <= 0.0 {
            return Err(wrong("tolerance", self.calibration.tolerance, "positive"));
        }
        if !(self.calibration.bound > 0.0 && self.calibration.bound <= 2.0) {
            return Err(wrong("bound", self.calibration.bound, "positive and at most 2"));
        }
        if self.free_run.every == 0 {
            return Err(wrong("every", 0.0, "at least 1 step"));
        }
        let horizons = &self.free_run.horizons;
        if horizons.is_empty() || horizons[0] == 0 || !horizons.is_sorted_by(|a, b| a < b) {
            let value = horizons.first().map_or(0.0, |h| *h as f64);
            return Err(wrong("horizons", value, "at least 1 step each, ascending, at least one"));
        }
        if !horizons.contains(&self.localisation.horizon) {
            let value = self.localisation.horizon as f64;
            return Err(wrong("horizon of the cells", value, "one of the free runs' horizons"));
        }
        let share = self.inclusion.least_cgm_share;
        if !(0.0..=1.0).contains(&share) {
            return Err(wrong("least_cgm_share", share, "between 0 and 1"));
        }
        Ok(self)
    }
}

/// Who can be diagnosed; others are excluded by name and reason.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct InclusionRule {
    /// Fewest whole days of record.
    pub fewest_days: usize,
    /// Smallest share of steps covered by CGM readings
    /// ([`Observations::coverage`](crate::Observations::coverage)).
    pub least_cgm_share: f64,
}

impl InclusionRule {
    /// The values in use: four days, half of the steps covered.
    #[must_use]
    pub const fn working() -> Self {
        Self { fewest_days: 4, least_cgm_share: 0.5 }
    }
}
