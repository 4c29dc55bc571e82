//! What was done on import: daily amounts by person, inferences, notes and the account of totals.

use contract::ImportReport;

use super::words::{plain, therapy};
use crate::html::{Column, Html};
use crate::number::{ABSENT, compact};

/// Rows of one table that are shown.
const SHOWN: usize = 100;

pub(super) fn body(html: &mut Html, report: &ImportReport) {
    let people = &report.people;
    html.paragraph(&format!("Read from: {}.", report.format));
    let rows = people
        .iter()
        .map(|p| vec![p.line.clone(), or_absent(p.therapy.as_deref().map(therapy))])
        .collect();
    table(html, "Daily amounts by person", &["Amounts", "Therapy"], rows);
    html.folded("The account of the import", |html| account(html, report));
}

fn account(html: &mut Html, report: &ImportReport) {
    let rows = report.people.iter().flat_map(|person| &person.findings).map(|found| {
        let when = found.date.as_ref().or(found.time.as_ref());
        let (least, most) = found.plausible;
        vec![
            found.person.clone(),
            when.map_or_else(|| "whole record".to_owned(), Clone::clone),
            plain(&found.what),
            format!("{} {}", compact(found.value), found.unit),
            format!("{} to {}", compact(least), compact(most)),
        ]
    });
    table(
        html,
        "Implausible figures; nothing was changed because of them",
        &["Person", "When", "What", "Value", "Plausible"],
        rows.collect(),
    );
    let rows = report.inferences.iter().flatten().map(|i| {
        let place = place(&i.file, i.row, i.column.as_deref());
        vec![i.person.clone(), place, i.conclusion.clone(), i.evidence.clone()]
    });
    table(
        html,
        "Units and meanings that the source does not state",
        &["Person", "Where", "Taken as", "Evidence"],
        rows.collect(),
    );
    let rows = report.notes.iter().map(|note| {
        let place = place(&note.file, note.row, note.column.as_deref());
        let count = compact(note.count as f64);
        vec![or_absent(note.person.clone()), place, note.what.clone(), count]
    });
    table(
        html,
        "What was changed, merged, left out or looks odd",
        &["Person", "Where", "What", "Count"],
        rows.collect(),
    );
    let totals = report.people.iter().flat_map(|person| {
        person.totals.iter().flatten().map(move |totals| (&person.balance.person, totals))
    });
    let rows = totals.map(|(person, t)| {
        let amounts = [t.source, t.record, t.left_out].map(compact);
        [vec![person.clone(), t.column.clone(), t.unit.clone()], amounts.to_vec()].concat()
    });
    table(
        html,
        "Account of amounts: the source is the record plus what was left out",
        &["Person", "Column", "Unit", "Source", "Record", "Left out"],
        rows.collect(),
    );
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
    let mut caption = caption.to_owned();
    if rows.len() > SHOWN {
        caption += &format!(": the first {SHOWN} of {}", rows.len());
    }
    rows.truncate(SHOWN);
    let columns: Vec<(&str, Column)> =
        columns[..width].iter().map(|name| (*name, Column::Text)).collect();
    rows.iter_mut().for_each(|row| row.truncate(width));
    html.table(&caption, &columns, rows.into_iter().map(|row| (false, row)).collect());
}

fn or_absent(text: Option<String>) -> String {
    text.unwrap_or_else(|| ABSENT.to_owned())
}

/// A place in a file as words.
fn place(file: &str, row: Option<usize>, column: Option<&str>) -> String {
    let row = row.map(|row| format!(", row {}", compact(row as f64)));
    let column = column.map(|column| format!(", column {column}"));
    [file.to_owned(), row.unwrap_or_default(), column.unwrap_or_default()].concat()
}
