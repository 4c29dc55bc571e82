//! What the checks of the data said of every person, and what was done on import.

use super::words::{channel, check, list, reason as why, sentence};
use crate::distinct::distinct;
use crate::html::{Column, Html};
use crate::number::{ABSENT, count, ends, fixed};
use crate::{Inputs, ReportError};
use contract::quality::{CheckOutcome, PersonInUse};
use contract::{DataInUse, Diagnosis};

/// People beyond whom those who pass every check share a row.
const ONE_BY_ONE: usize = 40;
/// Findings that are shown.
const SHOWN: usize = 200;

pub(super) fn body(inputs: &Inputs) -> Result<Html, ReportError> {
    let mut html = Html::default();
    match &inputs.data_in_use {
        Some(data) => people(&mut html, data),
        None => {
            html.absent("There is no list of the data in use in this folder.");
        }
    }
    match (&inputs.diagnosis, &inputs.data_in_use) {
        (Some(diagnosis), _) => estimates(&mut html, diagnosis),
        (None, Some(data)) => sentences(&mut html, data),
        (None, None) => {}
    }
    html.element("h3", "Import");
    match &inputs.import_report {
        Some(report) => super::import::body(&mut html, report),
        None => {
            html.absent("There is no import report in this folder.");
        }
    }
    Ok(html)
}

/// One row a person: the checks by what follows from them, and the days in use.
fn people(html: &mut Html, data: &DataInUse) {
    let of = |person: &PersonInUse, outcome: CheckOutcome| -> Vec<String> {
        let checks = person.checks.iter().filter(|check| check.result == outcome);
        checks.map(|found| check(&found.check)).collect()
    };
    let whole = |person: &PersonInUse| {
        person.left_out.is_none()
            && person.days_left_out.is_empty()
            && person.channels_left_out.is_empty()
            && person.checks.iter().all(|check| check.result == CheckOutcome::Pass)
    };
    let short = data.people.len() > ONE_BY_ONE;
    let (passing, shown): (Vec<&PersonInUse>, Vec<&PersonInUse>) =
        data.people.iter().partition(|person| short && whole(person));
    let words =
        |names: Vec<String>| if names.is_empty() { ABSENT.to_owned() } else { list(&names) };
    let mut rows: Vec<(bool, Vec<String>)> = shown
        .into_iter()
        .map(|person| {
            let days = match &person.left_out {
                Some(_) => format!("0 of {}", person.days),
                None => {
                    let used = person.days.saturating_sub(person.days_left_out.len());
                    format!("{used} of {}", person.days)
                }
            };
            let cells = vec![
                person.person_id.clone(),
                person.left_out.as_ref().map_or("in use", |_| "left out").to_owned(),
                days,
                of(person, CheckOutcome::Pass).len().to_string(),
                words(of(person, CheckOutcome::Warn)),
                words(of(person, CheckOutcome::Fail)),
                words(not_used(person)),
            ];
            (person.left_out.is_some(), cells)
        })
        .collect();
    if !passing.is_empty() {
        let days: usize = passing.iter().map(|person| person.days).sum();
        let checks = passing.iter().map(|person| person.checks.len()).max().unwrap_or(0);
        let who = if rows.is_empty() { "All" } else { "All others" };
        let absent = || ABSENT.to_owned();
        let cells = vec![
            format!("{who} ({})", count(passing.len(), "person", "people")),
            "in use".to_owned(),
            format!("{days} of {days}"),
            checks.to_string(),
            absent(),
            absent(),
            absent(),
        ];
        rows.push((false, cells));
    }
    html.table(
        "Checks of the data by person: a person with a warning stays in use; a person who fails a \
         check is left out (bold). Nothing is corrected silently",
        &[
            ("Person", Column::Text),
            ("Status", Column::Text),
            ("Days in use", Column::Number),
            ("Pass", Column::Number),
            ("Warn", Column::Text),
            ("Fail", Column::Text),
            ("Not used, and why", Column::Text),
        ],
        &rows,
    );
}

/// The reason why a person is left out, or what is not used of one who is not.
fn not_used(person: &PersonInUse) -> Vec<String> {
    if let Some(reason) = &person.left_out {
        return vec![why(reason)];
    }
    let channels = person.channels_left_out.iter().map(|left| {
        let share = fixed(100.0 * left.share, 0);
        let reasons: Vec<String> = left.reason.split(", ").map(check).collect();
        format!("{share}\u{a0}% of {} ({})", channel(&left.channel), reasons.join(", "))
    });
    let reasons = distinct(person.days_left_out.iter().map(|day| day.reason.as_str()));
    let days = reasons.into_iter().map(|reason| {
        let days = person.days_left_out.iter().filter(|day| day.reason == reason).count();
        format!("{} ({})", count(days, "day", "days"), check(reason))
    });
    channels.chain(days).collect()
}

/// The findings of checks, where no diagnosis holds them with their estimates.
fn sentences(html: &mut Html, data: &DataInUse) {
    let findings = data.people.iter().flat_map(|person| {
        person.checks.iter().flat_map(move |found| {
            let row =
                |finding: &String| (person.person_id.clone(), check(&found.check), finding.clone());
            found.findings.iter().map(row)
        })
    });
    let row = |(person, check, words)| (vec![person], check, words, ABSENT.to_owned());
    table(html, findings.map(row));
}

/// The findings of a diagnosis with their estimates.
fn estimates(html: &mut Html, diagnosis: &Diagnosis) {
    let findings = diagnosis.data_quality.iter().map(|finding| {
        let estimate = finding.estimate.as_ref().map_or_else(
            || ABSENT.to_owned(),
            |e| {
                let (value, unit) = (fixed(e.value, 1), &e.unit);
                if e.lower == e.upper {
                    return format!("{value} {unit}");
                }
                format!("{value} {unit}{}", ends(e.lower, e.upper, 1))
            },
        );
        (vec![finding.person_id.clone()], check(&finding.check), finding.finding.clone(), estimate)
    });
    table(html, findings);
}

/// People, check, words and estimate.
type Finding = (Vec<String>, String, String, String);

/// The same finding in several people is one row; a finding with an estimate has a row a person.
fn table(html: &mut Html, findings: impl Iterator<Item = Finding>) {
    let mut rows: Vec<Finding> = Vec::new();
    for (people, check, words, estimate) in findings {
        let same = rows.iter_mut().find(|row| {
            estimate == ABSENT && (&row.1, &row.2, &row.3) == (&check, &words, &estimate)
        });
        match same {
            Some(row) => row.0.extend(people),
            None => rows.push((people, check, words, estimate)),
        }
    }
    if rows.is_empty() {
        html.paragraph("The checks found nothing doubtful.");
        return;
    }
    let all = rows.len();
    let rows: Vec<(bool, Vec<String>)> = rows
        .into_iter()
        .take(SHOWN)
        .map(|(people, check, words, estimate)| {
            let people = match people.len() {
                n if n > ONE_BY_ONE => count(n, "person", "people"),
                _ => people.join(", "),
            };
            (false, vec![people, sentence(&check), words, estimate])
        })
        .collect();
    let rest = if all > SHOWN { format!("; the first {SHOWN} of {all}") } else { String::new() };
    html.table(
        &format!("What the checks found{rest}"),
        &[
            ("People", Column::Text),
            ("Check", Column::Text),
            ("Finding", Column::Text),
            ("Estimate (interval)", Column::Text),
        ],
        &rows,
    );
}
