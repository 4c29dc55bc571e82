//! When a glucose sensor is worn and its readings arrive.

use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};
use rand::{Rng, RngExt};
use rand_distr::{Distribution, Exp};

use crate::calendar::{Calendar, days_since_last, within};
use crate::everyday::SensorKind;

/// The sensors worn through a record, and the steps without a reading.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SensorWear {
    /// Steps at which a new sensor is inserted; the first may lie before the record.
    starts: Vec<i64>,
    /// Whether the reading of a step is lost, warm-up included.
    lost: Vec<bool>,
}

impl SensorWear {
    /// Draws the wear of a kind of sensor: life, warm-up and stretches without signal as it has
    /// them, changed between 8:00 and 22:00.
    #[must_use]
    pub fn sample(calendar: &Calendar, kind: &SensorKind, rng: &mut (impl Rng + ?Sized)) -> Self {
        let steps = calendar.steps() as i64;
        let mut lost = vec![false; calendar.steps()];
        let mut lose =
            |from: i64, length: i64| lost[within(from..from + length, calendar.steps())].fill(true);
        let mut starts = Vec::new();
        let mut day = -rng.random_range(1..kind.life_days as i64);
        while day * (STEPS_PER_DAY as i64) < steps {
            let hour: f64 = rng.random_range(8.0..22.0);
            let start = day * STEPS_PER_DAY as i64 + (hour * STEPS_PER_HOUR as f64) as i64;
            starts.push(start);
            lose(start, kind.warm_up as i64);
            day += kind.life_days as i64;
        }
        let gap =
            Exp::new(1.0 / (kind.days_between_losses * STEPS_PER_DAY as f64)).expect("positive");
        let length = Exp::new(1.0 / kind.loss_steps).expect("positive");
        let mut at = gap.sample(rng);
        while at < steps as f64 {
            lose(at as i64, 1 + length.sample(rng) as i64);
            at += gap.sample(rng);
        }
        Self { starts, lost }
    }

    /// Whether the reading of `step` is lost.
    #[must_use]
    pub fn is_lost(&self, step: usize) -> bool {
        self.lost.get(step).copied().unwrap_or(false)
    }

    /// Whether a sensor is inserted at `step`.
    #[must_use]
    pub fn starts_at(&self, step: usize) -> bool {
        self.starts.binary_search(&(step as i64)).is_ok()
    }

    /// Index of the sensor worn at `step`, counted from the one worn at the start.
    #[must_use]
    pub fn sensor(&self, step: usize) -> usize {
        let worn = |step: i64| self.starts.partition_point(|start| *start <= step);
        worn(step as i64).saturating_sub(worn(0).max(1))
    }

    /// Age in days of the sensor worn at `step`.
    #[must_use]
    pub fn age_days(&self, step: usize) -> f64 {
        days_since_last(&self.starts, step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::{Concept, stream};
    use chrono::NaiveDate;

    #[test]
    fn a_few_per_cent_of_the_readings_are_lost() {
        let start = NaiveDate::from_ymd_opt(2024, 1, 8).expect("a date");
        let calendar = Calendar::new(start, 200);
        let wear = SensorWear::sample(
            &calendar,
            &SensorKind::PUBLISHED,
            &mut stream(2, 0, Concept::Sensor),
        );
        let lost = (0..calendar.steps()).filter(|s| wear.is_lost(*s)).count() as f64
            / calendar.steps() as f64;
        // 24/2880 in warm-ups and 8.5/576 in stretches: 2.3 %; 100 stretches leave a tenth each
        // way.
        assert!((0.015..0.032).contains(&lost), "{lost}");
        let changes = (0..calendar.steps()).filter(|s| wear.starts_at(*s)).count();
        assert!((19..=21).contains(&changes), "{changes}");
        assert!((0..calendar.steps()).all(|s| wear.age_days(s) < 10.7));
    }
}
