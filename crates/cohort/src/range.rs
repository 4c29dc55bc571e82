//! The values that each column can hold. This is wider than what is plausible: values outside mean
//! a wrong column, unit or sign.

use crate::error::{CohortError, Place};
use crate::record::Channel;

/// Below this median, in its own numbers, a glucose column can only be mmol/L: nobody survives 35
/// mg/dL, and 35 mmol/L is beyond every sensor.
pub(crate) const MMOL_MEDIAN: f64 = 35.0;

/// A value outside its column's range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Outside {
    value: f64,
    low: f64,
    high: f64,
    unit: &'static str,
}

impl Outside {
    /// The error, given the cell.
    pub(crate) fn at(self, place: Place) -> CohortError {
        let Self { value, low, high, unit } = self;
        let remedy = if value < low && low == 0.0 {
            "a negative value is not a dose, count or share; correct it or leave the cell empty"
        } else {
            "check the column's unit, or leave the cell empty"
        };
        CohortError::OutOfRange { place, value, low, high, unit, remedy }
    }
}

/// Checks a value; `differences` says that heart rates are differences from a baseline.
pub(crate) fn check_value(channel: Channel, value: f64, differences: bool) -> Result<(), Outside> {
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
        Ok(())
    } else {
        let low = if channel == Channel::Cgm { 0.0 } else { low };
        Err(Outside { value, low, high, unit: channel.unit() })
    }
}

/// The median of a glucose column if it can only be mmol/L.
pub(crate) fn looks_like_mmol(cgm: &[Option<f64>]) -> Option<f64> {
    let mut values: Vec<f64> = cgm.iter().copied().flatten().collect();
    if values.is_empty() {
        return None;
    }
    let middle = values.len() / 2;
    let (_, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    (*median < MMOL_MEDIAN).then_some(*median)
}
