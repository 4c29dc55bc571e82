//! Everyone who was left out, at which step and why.

use crate::html::{Column, Html};
use crate::{Inputs, ReportError};

pub(super) fn body(inputs: &Inputs) -> Result<Html, ReportError> {
    let mut html = Html::default();
    let mut rows: Vec<(bool, Vec<String>)> = Vec::new();
    let mut add = |step: &str, person: &str, reason: &str| {
        rows.push((false, vec![person.to_owned(), step.to_owned(), reason.to_owned()]));
    };
    for person in inputs.diagnosis.iter().flat_map(|d| &d.people) {
        if let Some(reason) = &person.excluded {
            add("diagnosis", &person.person_id, reason);
        }
    }
    for person in inputs.twins.iter().flat_map(|t| &t.people) {
        if let Some(reason) = &person.excluded {
            add("twin", &person.person_id, reason);
        }
    }
    for exclusion in inputs.outcomes.iter().flat_map(|o| &o.exclusions) {
        add("evaluation", &exclusion.person_id, &exclusion.reason);
    }
    let any_source =
        inputs.diagnosis.is_some() || inputs.twins.is_some() || inputs.outcomes.is_some();
    if !rows.is_empty() {
        html.table(
            "People left out of a step",
            &[("Person", Column::Text), ("Left out of", Column::Text), ("Reason", Column::Text)],
            &rows,
        );
    } else if any_source {
        html.paragraph("Nobody was left out of any step that this folder holds.");
    } else {
        html.absent("This folder holds no step that takes people.");
    }
    Ok(html)
}
