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
            let rows: Vec<(bool, Vec<String>)> = diagnosis
                .data_quality
                .iter()
                .map(|finding| {
                    let estimate = finding.estimate.as_ref().map_or_else(
                        || ABSENT.to_owned(),
                        |e| {
                            format!(
                                "{} {} ({} to {})",
                                fixed(e.value, 1),
                                e.unit,
                                fixed(e.lower, 1),
                                fixed(e.upper, 1)
                            )
                        },
                    );
                    let check = plain(&finding.check);
                    (
                        false,
                        vec![finding.person_id.clone(), check, finding.finding.clone(), estimate],
                    )
                })
                .collect();
            html.table(
                "Findings by person; offered as they are, nothing was corrected silently",
                &[
                    ("Person", Column::Text),
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
