//! `insulin_clock_offset`, `meal_clock_offset`: doses whose clock disagrees with the sensor's.

use cohort::Person;

use super::Finding;
use crate::observations::Observations;

pub(super) fn findings(_person: &Person, _observations: &Observations) -> Vec<Finding> {
    Vec::new()
}
