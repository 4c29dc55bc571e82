//! Infusion set changes.

use physiology::STEPS_PER_DAY;
use rand::{Rng, RngExt};

use super::habits::Habits;
use crate::calendar::{Calendar, days_since_last};
use crate::stream::standard_normal;

/// Set changes of one person.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InfusionSets {
    changes: Vec<i64>,
}

impl InfusionSets {
    /// Draws changes, at 8:00 to 21:00 of the day in which the person's longest wear (SD half a day) ends: half a day
    /// before its end on average. The set worn at
    /// the start was inserted before the record.
    #[must_use]
    pub fn sample(habits: &Habits, calendar: &Calendar, rng: &mut (impl Rng + ?Sized)) -> Self {
        let mut day = -rng.random_range(0.0..habits.set_change_days);
        let mut changes = Vec::new();
        while day < calendar.days() as f64 {
            let hour: f64 = rng.random_range(8.0..21.0);
            changes.push(((day.floor() + hour / 24.0) * STEPS_PER_DAY as f64) as i64);
            day = day.floor() + (habits.set_change_days + 0.5 * standard_normal(rng)).max(1.0);
        }
        if changes.first().is_some_and(|first| *first > 0) {
            let before = (habits.set_change_days * STEPS_PER_DAY as f64) as i64;
            changes.insert(0, changes[0] - before);
        }
        Self { changes }
    }

    /// Steps of the changes in order; the first ones may lie before the record.
    #[must_use]
    pub fn changes(&self) -> &[i64] {
        &self.changes
    }

    /// Whether the set is changed within `step`.
    #[must_use]
    pub fn changed_at(&self, step: usize) -> bool {
        self.changes.binary_search(&(step as i64)).is_ok()
    }

    /// Age in days of the set worn at `step`.
    #[must_use]
    pub fn age_days(&self, step: usize) -> f64 {
        days_since_last(&self.changes, step)
    }
}
