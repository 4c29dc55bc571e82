//! What the held-out comparison needs to know.

use crate::filter::calibration::CalibrationRule;
use crate::free_run::FreeRunRule;
use crate::localisation::LocalisationRule;

/// The rules of the stages that the held-out comparison repeats on training days and on days held out.
#[derive(Debug, Clone, Copy)]
pub struct Settings<'a> {
    /// How fits before and after are made.
    pub calibration: &'a CalibrationRule,
    /// How free runs are started and scored.
    pub free_run: &'a FreeRunRule,
    /// How people and days are resampled.
    pub resampling: &'a LocalisationRule,
}
