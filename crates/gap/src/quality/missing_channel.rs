//! `missing_channel`: what was never recorded.

use cohort::{Channel, Person};

use super::{Consequence, Finding};
use crate::filter::observations::DEFAULT_WEIGHT;

pub(super) fn findings(person: &Person) -> Vec<Finding> {
    let record = &person.record;
    let never = |channel| record.channel(channel).iter().all(Option::is_none);
    let mut missing = Vec::new();
    if never(Channel::Basal) && never(Channel::Bolus) {
        missing.push("no insulin on record".to_owned());
    } else if never(Channel::Basal) {
        missing.push("no basal insulin on record; boluses alone are used".to_owned());
    }
    for (channel, name) in [
        (Channel::Cgm, "CGM"),
        (Channel::Carbs, "carbohydrate"),
        (Channel::HeartRate, "heart rate"),
        (Channel::SleepEfficiency, "sleep"),
        (Channel::SetChange, "infusion set changes"),
    ] {
        if never(channel) {
            missing.push(format!("no {name} on record"));
        }
    }
    if person.weight.is_none() {
        missing.push(format!("no body weight on record; {DEFAULT_WEIGHT} assumed"));
    }
    let noted = |text| Finding::new("missing_channel", person, Consequence::Note, text);
    missing.into_iter().map(noted).collect()
}
