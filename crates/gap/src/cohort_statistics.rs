//! What a posterior reads of a cohort whose first round is known, as numbers by name.

use std::collections::BTreeMap;

use cohort::Channel;

use crate::calibrated_person::CalibratedPerson;
use crate::person_statistics::{mean_and_sd, of_person};
use contract::diagnosis::Evidence;

/// Channels whose presence decides what a record can show.
const CHANNELS: [Channel; 4] =
    [Channel::HeartRate, Channel::Steps, Channel::SleepEfficiency, Channel::SetChange];

/// How evidence, nats, is shared by people, who have so many days each: that of the person in the middle in a fortnight, the
/// share of those who show any, and what is left of it without the one who shows most.
pub(crate) fn evidence_of_people(name: &str, gains: &[f64], days: &[f64]) -> [(String, f64); 3] {
    let mut rates: Vec<f64> = gains.iter().zip(days).map(|(gain, d)| gain * 14.0 / d).collect();
    rates.sort_by(f64::total_cmp);
    let middle = rates.get(rates.len() / 2).copied().unwrap_or(0.0);
    let count = gains.len().max(1) as f64;
    let show = gains.iter().filter(|gain| **gain > 0.5).count() as f64 / count;
    let most = gains.iter().copied().fold(0.0, f64::max);
    let rest = gains.iter().sum::<f64>() - most;
    let named = |what: &str| format!("evidence of people/{name}/{what}");
    [(named("middle"), middle), (named("share"), show), (named("without the most"), rest)]
}

/// The statistics of people whose first round is known: its evidence, its spreads and what natural units show.
pub(crate) fn statistics(
    people: &[CalibratedPerson<'_>],
    evidence: &Evidence,
    spreads: &BTreeMap<String, f64>,
    units: &BTreeMap<String, f64>,
) -> BTreeMap<String, f64> {
    let count = people.len() as f64;
    let mut found = BTreeMap::new();
    found.insert("cohort/people".to_owned(), count.ln());
    found.insert("cohort/person-days".to_owned(), evidence.person_days.ln());
    for channel in CHANNELS {
        let has = |p: &&CalibratedPerson<'_>| {
            p.person.record.channel(channel).iter().any(Option::is_some)
        };
        let share = people.iter().filter(has).count() as f64 / count;
        found.insert(format!("cohort/{channel:?}"), share);
    }
    let mut of_people: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for person in people {
        for (name, value) in of_person(person) {
            of_people.entry(name).or_default().push(value);
        }
    }
    for (name, values) in of_people {
        let (mean, sd) = mean_and_sd(&values);
        found.insert(format!("{name}/mean"), mean);
        found.insert(format!("{name}/SD"), sd);
    }
    for (group, values) in [("spread", spreads), ("evidence", &evidence.gains), ("units", units)] {
        found.extend(values.iter().map(|(name, value)| (format!("{group}/{name}"), *value)));
    }
    found
}
