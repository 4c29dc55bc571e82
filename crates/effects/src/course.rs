//! What a driver may look at: a person's record and filtered glucose, step by step.

/// Length of a step, min.
pub const STEP_MINUTES: f64 = 5.0;

/// One person's time courses; every list has one entry per five-minute step.
///
/// A channel that was never recorded is `None` as a whole; gaps inside a channel are `None` entries.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Course {
    /// Local hour of the day at the start of the step, 0 to below 24.
    pub hour: Vec<f64>,
    /// Calendar day, counted from that of the first step.
    pub day: Vec<usize>,
    /// Saturday or Sunday.
    pub weekend: Vec<bool>,
    /// Carbohydrate logged, g; 0 where none or not recorded.
    pub carbs: Vec<f64>,
    /// Bolus insulin logged, U; 0 where none or not recorded.
    pub bolus: Vec<f64>,
    /// Heart rate over rest, 1/min.
    pub heart_rate_over_rest: Option<Vec<Option<f64>>>,
    /// Steps walked.
    pub walked: Option<Vec<Option<f64>>>,
    /// Share of the step asleep, 0 to 1.
    pub asleep: Option<Vec<Option<f64>>>,
    /// Whether an infusion set was changed in the step.
    pub set_changed: Option<Vec<bool>>,
    /// Plasma glucose as the filter sees it after the step's reading, mg/dL. Smooth where readings are
    /// noisy; a driver built on readings themselves would be correlated with their noise.
    pub glucose: Vec<f64>,
    /// Age of the glucose sensor, days, where its insertion can be told from gaps in the readings.
    pub sensor_age: Option<Vec<f64>>,
}

impl Course {
    /// Number of steps.
    #[must_use]
    pub fn len(&self) -> usize {
        self.hour.len()
    }

    /// Whether there is no step.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.hour.is_empty()
    }
}
