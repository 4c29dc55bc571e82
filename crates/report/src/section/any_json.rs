//! Any JSON as tables, for parts that the report does not know by name.

use serde_json::Value;

use super::words::plain;
use crate::distinct::distinct;
use crate::html::{Column, Html};
use crate::number::{ABSENT, count};

/// Rows of one table that are shown.
const SHOWN: usize = 100;

/// Any JSON as tables: plain values in one table, each list of objects in its own.
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
        let objects = items.iter().filter_map(Value::as_object);
        let keys = distinct(objects.flat_map(|object| object.keys().map(String::as_str)));
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
