//! The values that each column can hold. This is wider than what is plausible: values outside mean
//! a wrong column, unit or sign.

use crate::error::{CohortError, Place};
use crate::record::Channel;

/// Below this median, in its own numbers, a glucose column can only be mmol/L: nobody survives 35
/// mg/dL, and 35 mmol/L is beyond every sensor.
pub(crate) const MMOL_MEDIAN: f64 = 35.0;

/// Checks the value of a cell; `differences` says that heart rates are differences from a baseline.
pub(crate) fn check_value(
    channel: Channel,
    value: f64,
    differences: bool,
    place: impl FnOnce() -> Place,
) -> Result<(), CohortError> {
    let (low, high) = match channel {
        Channel::Cgm => (f64::MIN_POSITIVE, 2000.0),
        // A bolus of 100 U inside one step, as a rate.
        Channel::Basal => (0.0, 1200.0),
        Channel::Bolus => (0.0, 100.0),
        Channel::Carbs => (0.0, 5000.0),
        Channel::HeartRate if differences => (-250.0, 300.0),
        Channel::HeartRate => (0.0, 300.0),
        Channel::Steps => (0.0, 5000.0),
        Channel::SleepEfficiency | Channel::SetChange => (0.0, 1.0),
    };
    let flag = channel != Channel::SetChange || value == 0.0 || value == 1.0;
    if (low..=high).contains(&value) && flag {
        return Ok(());
    }
    let low = if channel == Channel::Cgm { 0.0 } else { low };
    let remedy = if value < low && low == 0.0 {
        "a negative value is not a dose, count or share; correct it or leave the cell empty"
    } else {
        "check the column's unit, or leave the cell empty"
    };
    let (place, unit) = (place(), channel.unit());
    Err(CohortError::OutOfRange { place, value, low, high, unit, remedy })
}

/// Refuses a glucose column that can only be mmol/L.
pub(crate) fn check_unit(
    cgm: &[Option<f64>],
    person: &str,
    place: impl FnOnce() -> Place,
) -> Result<(), CohortError> {
    let Some(median) = looks_like_mmol(cgm) else { return Ok(()) };
    Err(CohortError::LooksLikeMmol { place: place(), person: person.into(), median })
}

/// The middle one of some values; of two the higher one.
pub(crate) fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// The median of a glucose column if it can only be mmol/L.
pub(crate) fn looks_like_mmol(cgm: &[Option<f64>]) -> Option<f64> {
    median(cgm.iter().copied().flatten().collect()).filter(|median| *median < MMOL_MEDIAN)
}
