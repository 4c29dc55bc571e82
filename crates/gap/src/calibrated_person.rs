//! A person as every question of the diagnosis finds her.

use cohort::Person;
use effects::Course;

use crate::course::course;
use crate::filter::calibration::Calibration;
use crate::filter::observations::Observations;

/// A person with what was observed and the calibrated filter that follows it.
#[derive(Debug, Clone, Copy)]
pub struct CalibratedPerson<'a> {
    /// Her record.
    pub person: &'a Person,
    /// Her readings and inputs.
    pub observations: &'a Observations,
    /// Her calibration on the whole record.
    pub calibration: &'a Calibration,
}

impl CalibratedPerson<'_> {
    /// What effects look at: the record, and glucose as the filter follows it.
    #[must_use]
    pub fn course(&self) -> Course {
        course(self.person, self.calibration.glucose())
    }
}
