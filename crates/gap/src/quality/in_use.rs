//! What of a cohort is used: people, days and channels, decided once for every stage.
//!
//! A diagnosis, the training of a twin and the judging of both read the same people and the same values. Whoever is left
//! out, or whatever is not read, has its reason here.

use std::collections::BTreeMap;

use chrono::NaiveDate;
use cohort::{Channel, Cohort, Person, Record, StraightLines};
use contract::quality::{ChannelLeftOut, CheckOutcome, CheckResult, DayLeftOut, PersonInUse};
use contract::{DataInUse, Document as _};
use physiology::STEPS_PER_DAY;
use rayon::prelude::*;

use super::unusable::unusable;
use super::{
    CHECKS, Consequence, Finding, exclusion, findings_under, identical_people, ignored_channels,
};
use crate::config::InclusionRule;
use crate::error::GapError;
use crate::filter::observations::{INTERPOLATED_SHARE, LONGEST_INTERPOLATION, Observations};

/// The check that is none of [`CHECKS`]: whether there is enough of a record.
const ENOUGH: &str = "enough_data";
/// Most values on one line where nobody draws lines, 1 h: whole mg/dL lie on the line between their neighbours in one case
/// of five at most (reference people and made ones), on twelve lines in a row in 0.2^12 = 4e-9.
const LONGEST_BY_CHANCE: usize = 12;

/// The people, days and channels of a cohort that every stage uses.
#[derive(Debug, Clone)]
pub struct InUse {
    people: Vec<UsedPerson>,
}

/// What is used of one person.
#[derive(Debug, Clone)]
pub struct UsedPerson {
    /// Every finding about the data.
    pub findings: Vec<Finding>,
    /// Who it is and what is left out, as it is written.
    pub table: PersonInUse,
    /// The person without channels that are ignored; `None` where all are read.
    without: Option<Person>,
    /// The values of the CGM column that are used; `None` where all are.
    cgm: Option<Vec<Option<f64>>>,
}

impl InUse {
    /// Judges everybody of a cohort.
    ///
    /// # Errors
    /// [`GapError::IdenticalPeople`] for one record under two names, [`GapError::Value`] for data that
    /// cannot be.
    pub fn of(cohort: &Cohort, rule: &InclusionRule) -> Result<Self, GapError> {
        if let Some((one, other)) = identical_people(cohort) {
            return Err(GapError::IdenticalPeople { one: one.to_owned(), other: other.to_owned() });
        }
        let people = cohort.people.par_iter().map(|person| UsedPerson::of(person, rule));
        Ok(Self { people: people.collect::<Result<_, _>>()? })
    }

    /// The same; whoever another list leaves out is left out here too, with its reason. For parts of
    /// the same people's records.
    #[must_use]
    pub fn without_those_of(mut self, other: &Self) -> Self {
        for person in &mut self.people {
            let other = other.of_person(&person.table.person_id);
            let reason = other.and_then(|other| other.table.left_out.clone());
            person.table.left_out = reason.or(person.table.left_out.take());
        }
        self
    }

    /// What is used of a person.
    #[must_use]
    pub fn of_person(&self, id: &str) -> Option<&UsedPerson> {
        self.people.iter().find(|person| person.table.person_id == id)
    }

    /// People who are left out, with the reason.
    pub fn left_out(&self) -> impl Iterator<Item = (&str, &str)> {
        let tables = self.people.iter().map(|person| &person.table);
        tables.filter_map(|table| Some((table.person_id.as_str(), table.left_out.as_deref()?)))
    }

    /// The people who are used, with the values that are used: the others are missing.
    #[must_use]
    pub fn used(&self, cohort: &Cohort) -> Cohort {
        let people = cohort.people.iter().filter_map(|person| {
            let used = self.of_person(&person.id).filter(|used| used.table.left_out.is_none())?;
            let mut person = used.read(person).clone();
            if let Some(cgm) = &used.cgm {
                person.record.channel_mut(Channel::Cgm).copy_from_slice(cgm);
            }
            Some(person)
        });
        Cohort { people: people.collect() }
    }

    /// The list as it is written.
    #[must_use]
    pub fn table(&self) -> DataInUse {
        let people = self.people.iter().map(|person| person.table.clone()).collect();
        DataInUse { schema: DataInUse::SCHEMA.to_owned(), people }
    }
}

impl UsedPerson {
    /// Judges one person.
    pub(crate) fn of(person: &Person, rule: &InclusionRule) -> Result<Self, GapError> {
        let recorded = Observations::from_person(person)?;
        let findings = findings_under(person, &recorded, rule);
        let ignored = ignored_channels(&findings);
        let without = (!ignored.is_empty()).then(|| {
            let mut without = person.clone();
            ignored.iter().for_each(|channel| without.record.channel_mut(*channel).fill(None));
            without
        });
        let read = without.as_ref().unwrap_or(person);
        let observations =
            if without.is_some() { Observations::from_person(read)? } else { recorded };
        let lacks = lacking(person, &observations, rule);
        // A record that cannot be a person's is named for that, and for what it lacks besides.
        let left_out = match (exclusion(&findings), &lacks) {
            (Some(fault), Some(lacks)) => Some(format!("{fault}; besides, {lacks}")),
            (fault, lacks) => fault.or_else(|| lacks.clone()),
        };
        let cgm = used_readings(read, &observations);
        let cgm = (cgm != read.record.cgm()).then_some(cgm);
        let mut checks: Vec<CheckResult> =
            CHECKS.iter().map(|check| result(check, &findings)).collect();
        checks.push(CheckResult {
            check: ENOUGH.to_owned(),
            result: if lacks.is_some() { CheckOutcome::Fail } else { CheckOutcome::Pass },
            findings: lacks.into_iter().collect(),
        });
        let (days, days_left_out) = days(&person.record, cgm.as_deref(), &findings);
        let table = PersonInUse {
            person_id: person.id.clone(),
            days_left_out: if left_out.is_some() { Vec::new() } else { days_left_out },
            left_out,
            checks,
            days,
            channels_left_out: channels(&person.record, cgm.as_deref(), &findings),
        };
        Ok(Self { findings, table, without, cgm })
    }

    /// The person without channels that are ignored, given the person as recorded.
    pub(crate) fn read<'a>(&'a self, person: &'a Person) -> &'a Person {
        self.without.as_ref().unwrap_or(person)
    }
}

/// The number of days, and those of which nothing is used; `cgm` is what is used where that is not all.
fn days(
    record: &Record,
    cgm: Option<&[Option<f64>]>,
    findings: &[Finding],
) -> (usize, Vec<DayLeftOut>) {
    // Readings on record and in use by date.
    let mut dates: BTreeMap<NaiveDate, (bool, bool)> = BTreeMap::new();
    for (k, used) in cgm.unwrap_or(record.cgm()).iter().enumerate() {
        let day = dates.entry(record.time(k).date()).or_default();
        *day = (day.0 || record.cgm()[k].is_some(), day.1 || used.is_some());
    }
    let left_out = dates.iter().filter_map(|(date, (recorded, used))| {
        let reason = match (recorded, used) {
            (_, true) => return None,
            (true, false) => not_read(findings),
            (false, false) => "no CGM reading".to_owned(),
        };
        Some(DayLeftOut { date: date.to_string(), reason })
    });
    (dates.len(), left_out.collect())
}

/// The checks because of which readings are not used.
fn not_read(findings: &[Finding]) -> String {
    let found = |check: &&str| findings.iter().any(|finding| finding.reported.check == **check);
    let of_readings = ["interpolated_cgm", "interleaved_cgm", "capillary_in_cgm"];
    let named: Vec<&str> = of_readings.into_iter().filter(found).collect();
    // A single line too long to stand for glucose is no finding.
    if named.is_empty() { "interpolated_cgm".to_owned() } else { named.join(", ") }
}

/// The channels of which not everything is used; `cgm` is what is used where that is not all.
fn channels(
    record: &Record,
    cgm: Option<&[Option<f64>]>,
    findings: &[Finding],
) -> Vec<ChannelLeftOut> {
    let row = |channel: Channel, share: f64, reason: String| {
        let channel = channel.name().to_owned();
        ChannelLeftOut { channel, share, reason }
    };
    let ignored = findings.iter().filter_map(|finding| match finding.consequence {
        Consequence::IgnoreChannel(channel) => {
            Some(row(channel, 1.0, finding.reported.check.clone()))
        }
        _ => None,
    });
    let partly = cgm.map(|used| {
        let recorded = record.cgm();
        let changed = recorded.iter().zip(used).filter(|(a, b)| a != b).count();
        let share = changed as f64 / recorded.iter().flatten().count().max(1) as f64;
        row(Channel::Cgm, share, not_read(findings))
    });
    ignored.chain(partly).collect()
}

/// What one check said.
fn result(check: &str, findings: &[Finding]) -> CheckResult {
    let of_check = || findings.iter().filter(|finding| finding.reported.check == check);
    let outcome = |finding: &Finding| match finding.consequence {
        Consequence::ExcludePerson => CheckOutcome::Fail,
        Consequence::Note | Consequence::IgnoreChannel(_) => CheckOutcome::Warn,
    };
    CheckResult {
        check: check.to_owned(),
        result: of_check().map(outcome).max().unwrap_or(CheckOutcome::Pass),
        findings: of_check().map(|finding| finding.reported.finding.clone()).collect(),
    }
}

/// The values of the CGM column that stand for glucose: the recorded ones, the sensor's line where a finger stick
/// stands, none where a source drew a long line or where two sensors alternate.
fn used_readings(person: &Person, observations: &Observations) -> Vec<Option<f64>> {
    let recorded = person.record.cgm();
    let mut used = recorded.to_vec();
    let drawn = observations.interpolated_share > INTERPOLATED_SHARE;
    let longest = if drawn { LONGEST_INTERPOLATION } else { LONGEST_BY_CHANCE };
    for line in StraightLines::find(recorded).inside {
        if line.len() > longest {
            used[line].fill(None);
        }
    }
    for (step, instead) in unusable(&person.record) {
        used[step] = instead.map(|glucose| glucose.0);
    }
    used
}

/// What a record lacks to be used.
fn lacking(person: &Person, observations: &Observations, rule: &InclusionRule) -> Option<String> {
    let days = person.record.len() / STEPS_PER_DAY;
    if days < rule.fewest_days {
        return Some(format!("{days} whole days of record, fewer than {}", rule.fewest_days));
    }
    let coverage = observations.coverage();
    if coverage < rule.least_cgm_share {
        let (found, least) = (100.0 * coverage, 100.0 * rule.least_cgm_share);
        return Some(format!(
            "CGM readings cover {found:.0} % of the steps, less than {least:.0} %"
        ));
    }
    if !observations.inputs.iter().any(|input| input.insulin().0 > 0.0) {
        return Some("no insulin on record".to_owned());
    }
    if !observations.inputs.iter().any(|input| input.carbs.0 > 0.0) {
        return Some("no carbohydrate on record".to_owned());
    }
    None
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn filled_lines_exclude_by_the_share_of_the_rule() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/embedded/cohort");
        let read = cohort::read_folder(&folder).expect("the embedded cohort reads");
        let mut person = read.people.into_iter().next().expect("six people");
        let steps = 14 * STEPS_PER_DAY;
        person.record = person.record.slice(0..steps).expect("inside the record");
        // Of every four hours one and a half are read, and a line is drawn through the others: readings cover 44 %.
        let old: Vec<f64> = person.record.cgm().iter().map(|g| g.unwrap_or(120.0)).collect();
        for (k, value) in person.record.channel_mut(Channel::Cgm).iter_mut().enumerate() {
            let (from, to) = (k / 48 * 48 + 18, (k / 48 * 48 + 48).min(steps - 1));
            let part = k.saturating_sub(from) as f64 / (to - from) as f64;
            let drawn = old[from] + part * (old[to] - old[from]);
            *value = Some(if k > from { drawn } else { old[k] });
        }
        for (least_cgm_share, expected) in [
            (0.5, [CheckOutcome::Fail, CheckOutcome::Fail]),
            (0.3, [CheckOutcome::Warn, CheckOutcome::Pass]),
        ] {
            let rule = InclusionRule { least_cgm_share, ..InclusionRule::working() };
            let checks = UsedPerson::of(&person, &rule).expect("good values").table.checks;
            let result =
                |check: &str| checks.iter().find(|row| row.check == check).map(|r| r.result);
            let found = ["interpolated_cgm", ENOUGH].map(result);
            assert_eq!(found, expected.map(Some), "{least_cgm_share}");
        }
    }
}
