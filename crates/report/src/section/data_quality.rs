//! What is doubtful about the data, and what was done on import.

use serde_json::Value;

use super::words::plain;
use crate::html::{Column, Html};
use crate::number::{ABSENT, count, fixed};
use crate::{Inputs, ReportError};

/// Rows of one table of the import report that are shown.
const SHOWN: usize = 100;

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

/// Any JSON as tables: plain values in one, each list of objects in its own.
pub(super) fn json(html: &mut Html, caption: &str, value: &Value) {
    let Value::Object(object) = value else {
        html.table(caption, &[("Value", Column::Text)], &[(false, vec![scalar(value)])]);
        return;
    };
    let is_list = |v: &Value| v.as_array().is_some_and(|a| a.iter().any(Value::is_object));
    let rows: Vec<(bool, Vec<String>)> = object
        .iter()
        .filter(|(_, v)| !is_list(v))
        .map(|(key, v)| (false, vec![plain(key), scalar(v)]))
        .collect();
    if !rows.is_empty() {
        html.table(caption, &[("Item", Column::Text), ("Value", Column::Text)], &rows);
    }
    for (key, items) in object {
        let Some(items) = items.as_array().filter(|items| items.iter().any(Value::is_object))
        else {
            continue;
        };
        let mut keys: Vec<&str> = Vec::new();
        for key in items.iter().filter_map(Value::as_object).flat_map(|o| o.keys()) {
            if !keys.contains(&key.as_str()) {
                keys.push(key);
            }
        }
        let columns: Vec<(String, Column)> =
            keys.iter().map(|key| (plain(key), Column::Text)).collect();
        let columns: Vec<(&str, Column)> =
            columns.iter().map(|(name, column)| (name.as_str(), *column)).collect();
        let rows: Vec<(bool, Vec<String>)> = items
            .iter()
            .take(SHOWN)
            .map(|item| (false, keys.iter().map(|key| scalar(&item[*key])).collect()))
            .collect();
        let shown = if items.len() > SHOWN {
            format!("{}: the first {SHOWN} of {}", plain(key), items.len())
        } else {
            format!("{}: {}", plain(key), count(items.len(), "entry", "entries"))
        };
        html.table(&shown, &columns, &rows);
    }
}

/// A JSON value in one cell.
fn scalar(value: &Value) -> String {
    match value {
        Value::Null => ABSENT.to_owned(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}
