//! Everyone who was left out, at which step and why.

use super::words;
use crate::html::{Column, Html};
use crate::{Inputs, ReportError};

pub(super) fn body(inputs: &Inputs) -> Result<Html, ReportError> {
    let mut html = Html::default();
    let mut rows: Vec<(bool, Vec<String>)> = Vec::new();
    let mut add = |step: &str, person: &str, reason: &str| {
        rows.push((false, vec![person.to_owned(), step.to_owned(), words::reason(reason)]));
    };
    for person in inputs.data_in_use.iter().flat_map(|data| &data.people) {
        if let Some(reason) = &person.left_out {
            add("every step", &person.person_id, reason);
        }
    }
    let everywhere = |id: &str| {
        let mut people = inputs.data_in_use.iter().flat_map(|data| &data.people);
        people.any(|person| person.person_id == id && person.left_out.is_some())
    };
    for person in inputs.diagnosis.iter().flat_map(|d| &d.people) {
        if let Some(reason) = person.excluded.as_ref().filter(|_| !everywhere(&person.person_id)) {
            add("diagnosis", &person.person_id, reason);
        }
    }
    for person in inputs.twins.iter().flat_map(|t| &t.people) {
        if let Some(reason) = person.excluded.as_ref().filter(|_| !everywhere(&person.person_id)) {
            add("twin", &person.person_id, reason);
        }
    }
    let of_outcomes = inputs.outcomes.iter().flat_map(|outcomes| &outcomes.exclusions);
    let alone = inputs.exclusions.iter().flat_map(|exclusions| &exclusions.0);
    for exclusion in of_outcomes.chain(alone).filter(|e| !everywhere(&e.person_id)) {
        add("evaluation", &exclusion.person_id, &exclusion.reason);
    }
    if rows.is_empty() {
        html.paragraph("Nobody was left out of any step that this folder holds.");
    } else {
        html.table(
            "People left out of a step",
            &[("Person", Column::Text), ("Left out of", Column::Text), ("Reason", Column::Text)],
            &rows,
        );
    }
    Ok(html)
}
