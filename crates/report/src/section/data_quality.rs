//! What the checks of the data said of every person, and what was done on import.

use super::words::{channel, check, list, reason as why, sentence};
use crate::Inputs;
use crate::distinct::distinct;
use crate::html::{Column, Html};
use crate::number::{ABSENT, count, ends, fixed};
use contract::quality::{CheckOutcome, PersonInUse};
use contract::{DataInUse, Diagnosis};

/// People beyond whom those who pass every check share a row.
const ONE_BY_ONE: usize = 40;
/// Findings that are shown.
const SHOWN: usize = 200;

pub(super) fn body(html: &mut Html, inputs: &Inputs) {
    match &inputs.data_in_use {
        Some(data) => people(html, data),
        None => html.absent("There is no list of the data in use in this folder."),
    }
    match (&inputs.diagnosis, &inputs.data_in_use) {
        (Some(diagnosis), _) => findings(html, estimates(diagnosis)),
        (None, Some(data)) => findings(html, sentences(data)),
        (None, None) => {}
    }
    html.element("h3", "Import");
    match &inputs.import_report {
        Some(report) => super::import::body(html, report),
        None => html.absent("There is no import report in this folder."),
    }
}

/// One row a person: the checks by what follows from them, and the days in use.
fn people(html: &mut Html, data: &DataInUse) {
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
    let row = |person: &PersonInUse| {
        let of = |outcome: CheckOutcome| -> Vec<String> {
            let checks = person.checks.iter().filter(|check| check.result == outcome);
            checks.map(|found| check(&found.check)).collect()
        };
        let (status, used) = match person.left_out {
            Some(_) => ("left out", 0),
            None => ("in use", person.days.saturating_sub(person.days_left_out.len())),
        };
        let cells = vec![
            person.person_id.clone(),
            status.to_owned(),
            format!("{used} of {}", person.days),
            of(CheckOutcome::Pass).len().to_string(),
            words(of(CheckOutcome::Warn)),
            words(of(CheckOutcome::Fail)),
            words(not_used(person)),
        ];
        (person.left_out.is_some(), cells)
    };
    let mut rows: Vec<(bool, Vec<String>)> = shown.into_iter().map(row).collect();
    if !passing.is_empty() {
        let days: usize = passing.iter().map(|person| person.days).sum();
        let checks = passing.iter().map(|person| person.checks.len()).max().unwrap_or(0);
        let who = if rows.is_empty() { "All" } else { "All others" };
        let who = format!("{who} ({})", count(passing.len(), "person", "people"));
        let (status, used) = ("in use".to_owned(), format!("{days} of {days}"));
        let mut cells = vec![who, status, used, checks.to_string()];
        cells.extend([ABSENT; 3].map(str::to_owned));
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
        rows,
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

/// People; then check, words and estimate.
type Finding = (Vec<String>, [String; 3]);

/// The findings of checks, where no diagnosis holds them with their estimates.
fn sentences(data: &DataInUse) -> Vec<Finding> {
    let mut findings = Vec::new();
    for person in &data.people {
        for found in &person.checks {
            findings.extend(found.findings.iter().map(|words| {
                let cells = [check(&found.check), words.clone(), ABSENT.to_owned()];
                (vec![person.person_id.clone()], cells)
            }));
        }
    }
    findings
}

/// The findings of a diagnosis with their estimates.
fn estimates(diagnosis: &Diagnosis) -> Vec<Finding> {
    let findings = diagnosis.data_quality.iter().map(|finding| {
        let estimate = finding.estimate.as_ref().map(|e| {
            let ends = if e.lower == e.upper { String::new() } else { ends(e.lower, e.upper, 1) };
            format!("{} {}{ends}", fixed(e.value, 1), e.unit)
        });
        let estimate = estimate.unwrap_or_else(|| ABSENT.to_owned());
        let cells = [check(&finding.check), finding.finding.clone(), estimate];
        (vec![finding.person_id.clone()], cells)
    });
    findings.collect()
}

/// The same finding in several people is one row; a finding with an estimate has a row a person.
fn findings(html: &mut Html, findings: Vec<Finding>) {
    let mut rows: Vec<Finding> = Vec::new();
    for (people, cells) in findings {
        let same = rows.iter_mut().find(|row| cells[2] == ABSENT && row.1 == cells);
        match same {
            Some(row) => row.0.extend(people),
            None => rows.push((people, cells)),
        }
    }
    if rows.is_empty() {
        html.paragraph("The checks found nothing doubtful.");
    }
    let all = rows.len();
    rows.truncate(SHOWN);
    let rest = if all > SHOWN { format!("; the first {SHOWN} of {all}") } else { String::new() };
    html.rows(
        &format!("What the checks found{rest}"),
        &rows,
        &[
            ("People", Column::Text, &|(people, _)| match people.len() {
                n if n > ONE_BY_ONE => count(n, "person", "people"),
                _ => people.join(", "),
            }),
            ("Check", Column::Text, &|(_, [check, ..])| sentence(check)),
            ("Finding", Column::Text, &|(_, [_, words, _])| words.clone()),
            ("Estimate (interval)", Column::Text, &|(_, [.., estimate])| estimate.clone()),
        ],
    );
}
