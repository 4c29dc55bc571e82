//! What was done on import: daily amounts by person, inferences, notes and the account of totals.
//!
//! The keys are those of `import_report.json` as the importers write it; anything else in the file
//! is shown as plain tables.

use serde_json::Value;

use super::any_json::json;
use super::words::plain;
use crate::html::{Column, Html};
use crate::number::{ABSENT, compact};

/// Rows of one table that are shown.
const SHOWN: usize = 100;

pub(super) fn body(html: &mut Html, report: &Value) {
    let people = list(report, "people");
    if !people.iter().any(|person| person["line"].is_string()) {
        json(html, "Import report", report);
        return;
    }
    if let Some(format) = report["format"].as_str() {
        html.paragraph(&format!("Read from: {format}."));
    }
    let rows = people.iter().map(|p| vec![text(&p["line"]), text(&p["therapy"])]).collect();
    table(html, "Daily amounts by person", &["Amounts", "Therapy"], rows);

    html.literal("<details>\n").element("summary", "The account of the import");
    let nested = |key| people.iter().flat_map(move |p| list(p, key).iter().map(move |x| (p, x)));
    let rows = nested("findings")
        .map(|(_, f)| {
            vec![
                text(&f["person"]),
                [text(&f["date"]), text(&f["time"])]
                    .into_iter()
                    .find(|when| when != ABSENT)
                    .unwrap_or_else(|| "whole record".to_owned()),
                plain(&text(&f["what"])),
                format!("{} {}", text(&f["value"]), text(&f["unit"])),
                format!("{} to {}", text(&f["plausible"][0]), text(&f["plausible"][1])),
            ]
        })
        .collect();
    table(
        html,
        "Implausible figures; nothing was changed because of them",
        &["Person", "When", "What", "Value", "Plausible"],
        rows,
    );
    let rows = list(report, "inferences")
        .iter()
        .map(|i| vec![text(&i["person"]), place(i), text(&i["conclusion"]), text(&i["evidence"])])
        .collect();
    table(
        html,
        "Units and meanings that the source does not state",
        &["Person", "Where", "Taken as", "Evidence"],
        rows,
    );
    let rows = list(report, "notes")
        .iter()
        .map(|n| vec![text(&n["person"]), place(n), text(&n["what"]), text(&n["count"])])
        .collect();
    table(
        html,
        "What was changed, merged, left out or looks odd",
        &["Person", "Where", "What", "Count"],
        rows,
    );
    let rows = nested("totals")
        .map(|(person, t)| {
            let id = person["balance"]["person"].as_str().unwrap_or(ABSENT).to_owned();
            let amounts = ["source", "record", "left_out"].map(|key| text(&t[key]));
            [vec![id, text(&t["column"]), text(&t["unit"])], amounts.to_vec()].concat()
        })
        .collect();
    table(
        html,
        "Account of amounts: the source is the record plus what was left out",
        &["Person", "Column", "Unit", "Source", "Record", "Left out"],
        rows,
    );
    html.literal("</details>\n");
}

/// A table of texts, if there is a row; last columns that are empty in every row are dropped.
fn table(html: &mut Html, caption: &str, columns: &[&str], mut rows: Vec<Vec<String>>) {
    if rows.is_empty() {
        return;
    }
    let mut width = columns.len();
    while width > 1 && rows.iter().all(|row| row[width - 1] == ABSENT) {
        width -= 1;
    }
    let caption = if rows.len() > SHOWN {
        format!("{caption}: the first {SHOWN} of {}", rows.len())
    } else {
        caption.to_owned()
    };
    rows.truncate(SHOWN);
    let columns: Vec<(&str, Column)> =
        columns[..width].iter().map(|name| (*name, Column::Text)).collect();
    let rows: Vec<(bool, Vec<String>)> =
        rows.into_iter().map(|row| (false, row.into_iter().take(width).collect())).collect();
    html.table(&caption, &columns, &rows);
}

fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().map_or(&[], Vec::as_slice)
}

fn text(value: &Value) -> String {
    match value {
        Value::Null => ABSENT.to_owned(),
        Value::String(text) => text.clone(),
        Value::Number(number) => number.as_f64().map_or_else(|| number.to_string(), compact),
        other => other.to_string(),
    }
}

/// The entry's `file`, `row` and `column` as words.
fn place(value: &Value) -> String {
    let mut parts = Vec::new();
    for (key, label) in [("file", ""), ("row", "row "), ("column", "column ")] {
        if !value[key].is_null() {
            parts.push(format!("{label}{}", text(&value[key])));
        }
    }
    if parts.is_empty() { ABSENT.to_owned() } else { parts.join(", ") }
}
