//! Everyone who was left out, at which step and why.

use super::words::reason as why;
use crate::Inputs;
use crate::html::{Column, Html};

/// A person, the step, and the reason.
type LeftOut<'a> = (&'a str, &'static str, &'a str);

pub(super) fn body(html: &mut Html, inputs: &Inputs) {
    let checked = inputs.data_in_use.iter().flat_map(|data| &data.people);
    let checked =
        checked.filter_map(|p| Some((&*p.person_id, "every step", p.left_out.as_deref()?)));
    let diagnosed = inputs.diagnosis.iter().flat_map(|diagnosis| &diagnosis.people);
    let diagnosed =
        diagnosed.filter_map(|p| Some((&*p.person_id, "diagnosis", p.excluded.as_deref()?)));
    let twins = inputs.twins.iter().flat_map(|twins| &twins.people);
    let twins = twins.filter_map(|p| Some((&*p.person_id, "twin", p.excluded.as_deref()?)));
    let judged = inputs.outcomes.iter().flat_map(|outcomes| &outcomes.exclusions);
    let judged = judged.chain(inputs.exclusions.iter().flat_map(|exclusions| &exclusions.0));
    let judged = judged.map(|row| (&*row.person_id, "evaluation", &*row.reason));

    let mut rows: Vec<LeftOut<'_>> = checked.collect();
    let everywhere: Vec<&str> = rows.iter().map(|(person, ..)| *person).collect();
    let others = diagnosed.chain(twins).chain(judged);
    rows.extend(others.filter(|(person, ..)| !everywhere.contains(person)));
    if rows.is_empty() {
        html.paragraph("Nobody was left out of any step that this folder holds.");
    }
    html.rows(
        "People left out of a step",
        &rows,
        &[
            ("Person", Column::Text, &|(person, ..)| (*person).to_owned()),
            ("Left out of", Column::Text, &|(_, step, _)| (*step).to_owned()),
            ("Reason", Column::Text, &|(.., reason)| why(reason)),
        ],
    );
}
