//! `dose_is_flag`: entries that say that a dose was given, and not how much.
//!
//! HUPA-UCM marks the boluses and meals of some people with 1. Amounts that people enter differ, so
//! a column that says the same thing every time carries none.

use cohort::{Channel, Person};

use super::{Consequence, Finding};

/// Fewest entries of exactly one that are taken for a flag; as in the import of HUPA-UCM.
const FEWEST: usize = 10;
/// Share of the entries that must be one: a few may have been corrected by hand.
const SHARE: f64 = 0.95;
/// Fewest entries of one other value, a flag that was multiplied, that are taken for a flag.
const FEWEST_OF_ANOTHER: usize = 25;
/// Share of the entries that must be that value. Among people who round to 5 g or whole units the
/// commonest value has a third to a half.
const SHARE_OF_ANOTHER: f64 = 0.98;

pub(super) fn findings(person: &Person) -> Vec<Finding> {
    [(Channel::Bolus, "boluses"), (Channel::Carbs, "meals")]
        .into_iter()
        .filter_map(|(channel, name)| finding(person, channel, name))
        .collect()
}

fn finding(person: &Person, channel: Channel, name: &str) -> Option<Finding> {
    let mut entries: Vec<f64> =
        person.record.channel(channel).iter().flatten().copied().filter(|v| *v > 0.0).collect();
    entries.sort_by(f64::total_cmp);
    let runs = entries.chunk_by(|a, b| a == b);
    let commonest = runs.max_by_key(|run| run.len())?;
    let (value, count) = (commonest[0], commonest.len());
    let share = count as f64 / entries.len() as f64;
    let flag = if value == 1.0 {
        count >= FEWEST && share >= SHARE
    } else {
        count >= FEWEST_OF_ANOTHER && share >= SHARE_OF_ANOTHER
    };
    flag.then(|| {
        let text = format!(
            "{count} of {} {name} are exactly {value}: marks without an amount; export the amounts, \
             or leave the column {} empty",
            entries.len(),
            channel.name()
        );
        let share = 100.0 * share;
        Finding::new("dose_is_flag", person, Consequence::ExcludePerson, text)
            .with_estimate((share, share, share), "% of entries")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quality::tests::person_with;

    #[test]
    fn marks_are_told_from_amounts() {
        let meals = |carbs: Vec<f64>| findings(&person_with(Channel::Carbs, &carbs)).len();
        assert_eq!(meals(vec![1.0; 10]), 1);
        assert_eq!(meals(vec![1.0; 9]), 0);
        assert_eq!(meals(vec![30.0; 24]), 0);
        assert_eq!(meals(vec![10.0; 25]), 1);
        // Servings are often one, and not nearly always.
        assert_eq!(meals([vec![1.0; 20], vec![2.0; 10]].concat()), 0);
        let found = findings(&person_with(Channel::Bolus, &[1.0; 40]));
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].consequence, Consequence::ExcludePerson);
        assert!(found[0].reported.finding.starts_with("40 of 40 boluses are exactly 1:"));
    }
}
