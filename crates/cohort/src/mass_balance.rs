//! The daily totals of a person's record, in one line that a reader can judge.

use contract::import_report::MassBalance;
use physiology::{STEPS_PER_DAY, STEPS_PER_HOUR};

use crate::person::Person;
use crate::record::Channel;

/// The figures of `person`. A day has 288 steps; amounts are over the steps in which the channel is
/// recorded, so a missing channel is `None` and not a small number.
#[must_use]
pub fn mass_balance(person: &Person) -> MassBalance {
    let record = &person.record;
    let total = |channel: Channel| -> (f64, f64) {
        let values = record.channel(channel).iter().flatten();
        values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0))
    };
    let mean = |channel| {
        let (sum, count) = total(channel);
        (count > 0.0).then(|| sum / count)
    };
    let share = |channel| match record.len() {
        0 => 0.0,
        len => total(channel).1 / len as f64,
    };
    let steps_per_day = STEPS_PER_DAY as f64;
    MassBalance {
        person: person.id.clone(),
        days: record.len() as f64 / steps_per_day,
        basal_u_day: mean(Channel::Basal).map(|rate| rate * steps_per_day / STEPS_PER_HOUR as f64),
        bolus_u_day: mean(Channel::Bolus).map(|dose| dose * steps_per_day),
        carbs_g_day: mean(Channel::Carbs).map(|grams| grams * steps_per_day),
        mean_glucose_mg_dl: mean(Channel::Cgm),
        cgm_share: share(Channel::Cgm),
        heart_rate_share: share(Channel::HeartRate),
    }
}

/// Basal and bolus together, U/day; `None` unless both are recorded.
#[must_use]
pub fn insulin_u_day(balance: &MassBalance) -> Option<f64> {
    balance.basal_u_day.zip(balance.bolus_u_day).map(|(basal, bolus)| basal + bolus)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Record, Therapy};

    #[test]
    fn amounts_are_per_recorded_day_and_missing_ones_are_marked() {
        let start = "2024-03-08T00:00:00".parse().expect("a literal time");
        let mut record = Record::new(start, 2 * STEPS_PER_DAY).expect("on the grid");
        // Basal of 1 U/h and boluses of 0.01 U a step, recorded on the first day alone.
        record.channel_mut(Channel::Basal)[..STEPS_PER_DAY].fill(Some(1.0));
        record.channel_mut(Channel::Bolus)[..STEPS_PER_DAY].fill(Some(0.01));
        record.channel_mut(Channel::Cgm)[..432].fill(Some(150.0));
        let person = Person {
            id: "2301".into(),
            weight: None,
            therapy: Therapy::Unknown,
            heart_rate_baseline: None,
            record,
        };
        let balance = mass_balance(&person);
        assert_eq!(
            balance.to_string(),
            "2301: 2 days, 24.0 + 2.9 U/day, ? g/day, mean 150 mg/dL, CGM 75 %, heart rate 0 %"
        );
        // 24 U and 2.88 U, rounding of sums.
        assert!(insulin_u_day(&balance).is_some_and(|u| (u - 26.88).abs() < 1e-9));
    }
}
