//! Whether a person's record looks like one of a free-living person with type 1 diabetes.

use cohort::Record;
use physiology::STEPS_PER_DAY;
use serde::Serialize;

/// A figure of a record, with its plausible range.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Check {
    /// What is measured.
    pub figure: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its value.
    pub value: f64,
    /// Lowest plausible value.
    pub lowest: f64,
    /// Highest plausible value.
    pub highest: f64,
}

impl Check {
    /// Whether the value lies in its range; NaN does not.
    #[must_use]
    pub fn holds(&self) -> bool {
        (self.lowest..=self.highest).contains(&self.value)
    }
}

/// The figures of a record: glucose over the recorded readings, insulin and carbohydrate by day.
///
/// The ranges enclose adults on pumps in observational cohorts (mean glucose 130 to 190 mg/dL, CV
/// 28 to 45 %, 50 to 85 % in and 1 to 6 % below range, 20 to 70 U and 100 to 300 g a day, 90 to
/// 99.5 % of readings present). An empty record has figures that are not numbers.
#[must_use]
pub fn checks(record: &Record) -> Vec<Check> {
    let readings: Vec<f64> = record.cgm().iter().flatten().copied().collect();
    let n = readings.len() as f64;
    let days = record.len() as f64 / STEPS_PER_DAY as f64;
    let mean = readings.iter().sum::<f64>() / n;
    let variance = readings.iter().map(|g| (g - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let percent = |within: &dyn Fn(f64) -> bool| {
        100.0 * readings.iter().filter(|g| within(**g)).count() as f64 / n
    };
    let sum = |channel: &[Option<f64>]| channel.iter().flatten().sum::<f64>();
    let insulin = (sum(record.basal()) / 12.0 + sum(record.bolus())) / days;
    let check =
        |figure, unit, value, lowest, highest| Check { figure, unit, value, lowest, highest };
    vec![
        check("mean glucose", "mg/dL", mean, 130.0, 190.0),
        check("coefficient of variation", "%", 100.0 * variance.sqrt() / mean, 28.0, 45.0),
        check("time in 70-180 mg/dL", "%", percent(&|g| (70.0..=180.0).contains(&g)), 50.0, 85.0),
        check("time below 70 mg/dL", "%", percent(&|g| g < 70.0), 1.0, 6.0),
        check("total daily insulin", "U", insulin, 20.0, 70.0),
        check("carbohydrate logged a day", "g", sum(record.carbs()) / days, 100.0, 300.0),
        check("readings present", "%", 100.0 * n / record.len() as f64, 90.0, 99.5),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use cohort::Channel;

    #[test]
    fn figures_by_hand() {
        let start = "2024-01-08T00:00:00".parse().expect("a literal time");
        let mut record = Record::new(start, STEPS_PER_DAY).expect("on the grid");
        for (step, slot) in record.channel_mut(Channel::Cgm).iter_mut().enumerate() {
            *slot = (step % 4 != 0).then_some([0.0, 60.0, 120.0, 240.0][step % 4]);
        }
        record.channel_mut(Channel::Basal).fill(Some(0.5));
        record.channel_mut(Channel::Bolus)[3] = Some(6.0);
        record.channel_mut(Channel::Carbs)[3] = Some(80.0);
        // Glucose 60, 120, 240 in turn, 216 readings: SD = sqrt(5600 x 216/215).
        let by_hand = [140.0, 53.5764, 100.0 / 3.0, 100.0 / 3.0, 18.0, 80.0, 75.0];
        for (check, expected) in checks(&record).iter().zip(by_hand) {
            assert!((check.value - expected).abs() < 1e-4, "{check:?}"); // printed digits
        }
        let empty = Record::new(start, STEPS_PER_DAY).expect("on the grid");
        assert!(checks(&empty).iter().take(4).all(|check| !check.holds()));
    }
}
