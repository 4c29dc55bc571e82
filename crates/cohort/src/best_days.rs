//! The days of a record with the most readings.

use physiology::STEPS_PER_DAY;

use crate::Person;

impl Person {
    /// The whole days in a row, at most so many, that hold the most readings; of equal ones the first.
    ///
    /// Evidence grows with the days: people are compared over as many.
    #[must_use]
    pub fn best_days(&self, days: usize) -> Self {
        let cgm = self.record.cgm();
        let length = (days * STEPS_PER_DAY).min(cgm.len());
        let readings = |first: usize| cgm[first..first + length].iter().flatten().count();
        let starts = 0..(cgm.len() - length) / STEPS_PER_DAY + 1;
        let best = starts.rev().max_by_key(|day| readings(day * STEPS_PER_DAY)).unwrap_or(0);
        let first = best * STEPS_PER_DAY;
        let record = self.record.slice(first..first + length);
        Self { record: record.unwrap_or_else(|| self.record.clone()), ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Channel, Record, Therapy};

    #[test]
    fn the_days_with_the_most_readings_are_taken() {
        let start = "2024-03-04T00:00:00".parse().expect("a literal time");
        let mut record = Record::new(start, 5 * STEPS_PER_DAY).expect("on the grid");
        for step in 2 * STEPS_PER_DAY..4 * STEPS_PER_DAY {
            record.channel_mut(Channel::Cgm)[step] = Some(120.0);
        }
        let person = Person {
            id: "p".to_owned(),
            weight: None,
            therapy: Therapy::Unknown,
            heart_rate_baseline: None,
            record,
        };
        let best = person.best_days(2);
        assert_eq!(best.record.len(), 2 * STEPS_PER_DAY);
        assert!(best.record.cgm().iter().all(Option::is_some));
        assert_eq!(person.best_days(9).record, person.record);
    }
}
