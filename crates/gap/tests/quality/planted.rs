//! Clean people, and what is done to them.

use std::path::Path;

use cohort::{Channel, Person};
use gap::Observations;
use gap::quality::{Finding, findings};

/// What a pump's clock stamps.
pub(crate) const INSULIN: [Channel; 2] = [Channel::Basal, Channel::Bolus];
/// What a food log's clock stamps.
pub(crate) const MEALS: [Channel; 1] = [Channel::Carbs];

/// The first fortnight of the six people of the embedded cohort: three programmed pumps, three
/// closed loops.
pub(crate) fn embedded() -> Vec<Person> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/embedded/cohort");
    let cohort = cohort::read_folder(&folder).expect("the embedded cohort reads");
    cohort.people.iter().flat_map(|person| stretches(person).into_iter().next()).collect()
}

/// Stretches of 14 days in which boluses and meals are recorded (those ever recorded), the last up
/// to 21 days; none of less than a week.
pub(crate) fn stretches(person: &Person) -> Vec<Person> {
    let record = &person.record;
    let ever = |channel| record.channel(channel).iter().any(Option::is_some);
    let doses = [Channel::Bolus, Channel::Carbs].into_iter().filter(|channel| ever(*channel));
    let doses: Vec<Channel> = doses.collect();
    let recorded = |k: &usize| doses.iter().all(|channel| record.channel(*channel)[*k].is_some());
    let first = (0..record.len()).find(recorded).unwrap_or(0);
    let end = (0..record.len()).rfind(recorded).map_or(0, |last| last + 1);
    let mut found = Vec::new();
    let mut start = first;
    while start + 7 * 288 <= end {
        let next = if end - start < 21 * 288 { end } else { start + 14 * 288 };
        let record = record.slice(start..next).expect("inside the record");
        found.push(Person { record, ..person.clone() });
        start = next;
    }
    found
}

/// The person with some channels recorded `minutes` later than they are, from step `since` on.
pub(crate) fn late(person: &Person, channels: &[Channel], minutes: i32, since: usize) -> Person {
    let mut moved = person.clone();
    let steps = (minutes / 5) as isize;
    for channel in channels {
        let old = person.record.channel(*channel);
        let values = moved.record.channel_mut(*channel).iter_mut().enumerate();
        for (k, value) in values.filter(|(k, _)| *k >= since) {
            let from = k.checked_add_signed(-steps).filter(|from| *from < old.len());
            *value = match from {
                Some(from) => old[from],
                None if *channel == Channel::Basal => old[k],
                None => old[k].map(|_| 0.0),
            };
        }
    }
    moved
}

/// The person with every recorded value of a channel changed, given its step.
pub(crate) fn changed(
    person: &Person,
    channel: Channel,
    new: impl Fn(usize, f64) -> f64,
) -> Person {
    let mut person = person.clone();
    for (k, value) in person.record.channel_mut(channel).iter_mut().enumerate() {
        *value = value.map(|value| new(k, value));
    }
    person
}

/// The person with every third CGM value, and lines drawn between: a sensor that reads every 15 min, as a
/// source with a grid of five fills it.
pub(crate) fn drawn_over_15_minutes(person: &Person) -> Person {
    let old = person.record.cgm().to_vec();
    let mut drawn = person.clone();
    for (k, value) in drawn.record.channel_mut(Channel::Cgm).iter_mut().enumerate() {
        let (before, part) = (k / 3 * 3, (k % 3) as f64 / 3.0);
        let after = old.get(before + 3).copied().unwrap_or(None);
        *value = match (old[before], after) {
            (Some(a), _) if k == before => Some(a),
            (Some(a), Some(b)) => Some(a + part * (b - a)),
            _ => None,
        };
    }
    drawn
}

/// Every finding but those about what was never recorded or was drawn by the source.
pub(crate) fn doubts(person: &Person) -> Vec<Finding> {
    let observations = Observations::from_person(person).expect("values that can be");
    let mut found = findings(person, &observations);
    let known = ["missing_channel", "interpolated_cgm"];
    found.retain(|finding| !known.contains(&finding.reported.check.as_str()));
    found
}

/// The checks that found something, each once.
pub(crate) fn checks(found: &[Finding]) -> Vec<&str> {
    let mut checks: Vec<&str> = found.iter().map(|f| f.reported.check.as_str()).collect();
    checks.dedup();
    checks
}

/// The estimate of a check's finding: value, lower and upper end.
pub(crate) fn estimate(found: &[Finding], check: &str) -> Option<(f64, f64, f64)> {
    let found = found.iter().find(|finding| finding.reported.check == check)?;
    let estimate = found.reported.estimate.as_ref()?;
    assert!(estimate.lower <= estimate.value && estimate.value <= estimate.upper, "{estimate:?}");
    Some((estimate.value, estimate.lower, estimate.upper))
}
