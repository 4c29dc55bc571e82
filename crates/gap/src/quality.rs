//! What is doubtful about a person's data, judged before anything is diagnosed.
//!
//! A clock that is an hour off, carbohydrate in servings or a basal rate in U per five minutes makes
//! a plant miss as surely as a missing effect does. Each check reads one person's record and
//! reports what it found, with an estimate and its interval where there is one, and what would mend
//! it. Nothing is corrected here. [`Consequence`] says what a diagnosis should do about it.
//!
//! Thresholds stand at the head of each check's file with their source.

mod basal_unit;
mod capillary_in_cgm;
mod carb_unit;
mod clock_offset;
mod daily_doses;
mod discontinuous_cgm;
mod dose_is_flag;
mod flat_cgm;
mod heart_rate;
mod identical_people;
mod in_use;
mod insulin_incomplete;
mod interleaved_cgm;
mod interpolated_cgm;
mod missing_channel;
mod plausible_day;
pub(crate) mod unusable;

use cohort::{Channel, Person};

pub use self::identical_people::identical_people;
pub use self::in_use::{InUse, UsedPerson};
use crate::config::InclusionRule;
use crate::filter::observations::Observations;
use contract::diagnosis::{DataQualityFinding, FindingEstimate};

/// Every check by name, in the order in which they are made.
pub const CHECKS: [&str; 14] = [
    "missing_channel",
    "interpolated_cgm",
    "flat_cgm",
    "discontinuous_cgm",
    "interleaved_cgm",
    "capillary_in_cgm",
    "insulin_incomplete",
    "dose_is_flag",
    "basal_unit",
    "carb_unit",
    "plausible_day",
    "heart_rate_alignment",
    "insulin_clock_offset",
    "meal_clock_offset",
];

/// What every stage should do about a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Consequence {
    /// Say it and go on.
    Note,
    /// Leave the person out: their insulin, carbohydrate or glucose cannot be read as recorded.
    ExcludePerson,
    /// Go on without this channel.
    IgnoreChannel(Channel),
}

/// A finding and its consequence.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// What is written.
    pub reported: DataQualityFinding,
    /// What follows from it.
    pub consequence: Consequence,
}

impl Finding {
    /// A finding that `check` made about `person`, without an estimate.
    fn new(check: &str, person: &Person, consequence: Consequence, text: String) -> Self {
        let reported = DataQualityFinding {
            check: check.to_owned(),
            person_id: person.id.clone(),
            finding: text,
            estimate: None,
        };
        Self { reported, consequence }
    }

    /// The finding with a value, the lower and the upper end of its interval, and their unit.
    fn with_estimate(mut self, (value, lower, upper): (f64, f64, f64), unit: &str) -> Self {
        let unit = unit.to_owned();
        self.reported.estimate = Some(FindingEstimate { value, lower, upper, unit });
        self
    }
}

/// Every finding about a person, in the order of the checks; [`InclusionRule::working`] says how many
/// readings are needed.
///
/// `observations` are the person's, from [`Observations::from_person`]. The answer depends on the
/// two alone: no check draws random numbers.
#[must_use]
pub fn findings(person: &Person, observations: &Observations) -> Vec<Finding> {
    findings_under(person, observations, &InclusionRule::working())
}

/// The same under another rule.
fn findings_under(
    person: &Person,
    observations: &Observations,
    rule: &InclusionRule,
) -> Vec<Finding> {
    let mut found = missing_channel::findings(person);
    found.extend(interpolated_cgm::finding(person, observations, rule.least_cgm_share));
    found.extend(flat_cgm::finding(person));
    // Rows out of order alternate by chance.
    found.extend(discontinuous_cgm::finding(person).or_else(|| interleaved_cgm::finding(person)));
    found.extend(capillary_in_cgm::finding(person));
    found.extend(insulin_incomplete::finding(person));
    found.extend(dose_is_flag::findings(person));
    found.extend(basal_unit::finding(person));
    // Flags and the wrong unit of one dose make another look wrong.
    if exclusion(&found).is_none() {
        found.extend(carb_unit::finding(person));
    }
    found.extend(plausible_day::findings(person, &found));
    found.extend(heart_rate::finding(person));
    found.extend(clock_offset::findings(person));
    found
}

/// Why a person is to be excluded: the first finding with that consequence, in words.
#[must_use]
pub fn exclusion(findings: &[Finding]) -> Option<String> {
    findings
        .iter()
        .find(|finding| finding.consequence == Consequence::ExcludePerson)
        .map(|finding| format!("{}: {}", finding.reported.check, finding.reported.finding))
}

/// The channels that are to be ignored.
#[must_use]
pub fn ignored_channels(findings: &[Finding]) -> Vec<Channel> {
    let channel = |finding: &Finding| match finding.consequence {
        Consequence::IgnoreChannel(channel) => Some(channel),
        Consequence::Note | Consequence::ExcludePerson => None,
    };
    findings.iter().filter_map(channel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use cohort::{Record, Therapy};
    use physiology::STEPS_PER_DAY;

    /// A person of a fortnight with nothing but some doses, one every two hours.
    pub(super) fn person_with(channel: Channel, doses: &[f64]) -> Person {
        let start = "2024-03-04T00:00:00".parse().expect("a literal time");
        let mut record = Record::new(start, 14 * STEPS_PER_DAY).expect("on the grid");
        let values = record.channel_mut(channel);
        values.fill(Some(0.0));
        for (index, dose) in doses.iter().enumerate() {
            values[24 * index] = Some(*dose);
        }
        Person {
            id: "p".into(),
            weight: None,
            therapy: Therapy::OpenLoopPump,
            heart_rate_baseline: None,
            record,
        }
    }

    #[test]
    fn consequences_are_gathered() {
        let person = person_with(Channel::Bolus, &[]);
        let found =
            |consequence| Finding::new("carb_unit", &person, consequence, "servings".to_owned());
        let ignored = Consequence::IgnoreChannel(Channel::HeartRate);
        let list = [found(Consequence::Note), found(ignored)];
        assert_eq!(exclusion(&list), None);
        assert_eq!(ignored_channels(&list), [Channel::HeartRate]);
        let excluded = [found(Consequence::Note), found(Consequence::ExcludePerson)];
        assert_eq!(exclusion(&excluded).as_deref(), Some("carb_unit: servings"));
    }
}
