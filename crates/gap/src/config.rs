//! The settings of a diagnosis.

use serde::{Deserialize, Serialize};

use crate::error::{GapError, require};
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
        let CalibrationRule { tolerance, bound, .. } = self.calibration;
        require(tolerance > 0.0, "tolerance", tolerance, "positive")?;
        require(bound > 0.0 && bound <= 2.0, "bound", bound, "positive and at most 2")?;
        let FreeRunRule { every, horizons, .. } = &self.free_run;
        require(*every > 0, "every", *every as f64, "at least 1 step")?;
        let first = horizons.first().copied().unwrap_or(0);
        let ascend = first > 0 && horizons.is_sorted_by(|a, b| a < b);
        let requirement = "at least 1 step each, ascending, at least one";
        require(ascend, "horizons", first as f64, requirement)?;
        let horizon = self.localisation.horizon;
        let known = horizons.contains(&horizon);
        let requirement = "one of the free runs' horizons";
        require(known, "horizon of the cells", horizon as f64, requirement)?;
        let share = self.inclusion.least_cgm_share;
        require((0.0..=1.0).contains(&share), "least_cgm_share", share, "between 0 and 1")?;
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
