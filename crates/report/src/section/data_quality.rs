//! What is doubtful about the data, and what was done on import.

use super::words::plain;
use crate::html::{Column, Html};
use crate::number::{ABSENT, fixed};
use crate::{Inputs, ReportError};

pub(super) fn body(inputs: &Inputs) -> Result<Html, ReportError> {
    let mut html = Html::default();
    match &inputs.diagnosis {
        None => {
            html.absent("There is no diagnosis in this folder, so the data were not checked.");
        }
        Some(diagnosis) if diagnosis.data_quality.is_empty() => {
            html.paragraph("The checks of the diagnosis found nothing doubtful.");
        }
        Some(diagnosis) => {
            // The same finding in several people is one row; a finding with an estimate has a row
            // per person.
            let mut rows: Vec<(Vec<String>, String, String, String)> = Vec::new();
            for finding in &diagnosis.data_quality {
                let (check, words) = (plain(&finding.check), finding.finding.clone());
                let estimate = finding.estimate.as_ref().map_or_else(
                    || ABSENT.to_owned(),
                    |e| {
                        let (value, unit) = (fixed(e.value, 1), &e.unit);
                        if e.lower == e.upper {
                            return format!("{value} {unit}");
                        }
                        format!("{value} {unit} ({} to {})", fixed(e.lower, 1), fixed(e.upper, 1))
                    },
                );
                let same = rows.iter_mut().find(|row| {
                    estimate == ABSENT && (&row.1, &row.2, &row.3) == (&check, &words, &estimate)
                });
                match same {
                    Some(row) => row.0.push(finding.person_id.clone()),
                    None => rows.push((vec![finding.person_id.clone()], check, words, estimate)),
                }
            }
            let rows: Vec<(bool, Vec<String>)> = rows
                .into_iter()
                .map(|(people, check, words, estimate)| {
                    (false, vec![people.join(", "), check, words, estimate])
                })
                .collect();
            html.table(
                "What was found; offered as it is, nothing was corrected silently",
                &[
                    ("People", Column::Text),
                    ("Check", Column::Text),
                    ("Finding", Column::Text),
                    ("Estimate (interval)", Column::Text),
                ],
                &rows,
            );
        }
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
