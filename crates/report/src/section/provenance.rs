//! How to make this report again: commands, version, seed, configuration, input hashes.

use serde_json::Value;

use super::shown_path::{shown_command, shown_json, shown_path};
use super::words::plain;
use crate::ReportError;
use crate::html::{Column, Html};
use crate::number::ABSENT;
use contract::Manifest;

pub(super) fn body(manifests: &[Manifest]) -> Result<Html, ReportError> {
    let mut html = Html::default();
    if manifests.is_empty() {
        html.absent(
            "There is no manifest in this folder, so the run cannot be repeated from here.",
        );
    }
    for manifest in manifests {
        html.element("h3", &manifest.stage);
        html.literal("<pre><code>")
            .text(&shown_command(&manifest.command))
            .literal("</code></pre>\n");
        let seed = manifest.seed.map_or_else(|| "none".to_owned(), |seed| seed.to_string());
        let again = match manifest.seed {
            Some(seed) if !manifest.command.contains("--seed") => {
                format!(" Add --seed {seed} to the command to get the same again.")
            }
            _ => String::new(),
        };
        html.paragraph(&format!("Version {}, seed {seed}.{again}", manifest.version));
        let mut folded = Html::default();
        if let Value::Object(config) = shown_json(&manifest.config) {
            folded.rows(
                "Resolved configuration",
                &config.into_iter().collect::<Vec<(String, Value)>>(),
                |_| false,
                &[
                    ("Item", Column::Text, &|(key, _)| plain(key)),
                    ("Value", Column::Text, &|(_, value)| in_a_cell(value)),
                ],
            );
        }
        if manifest.inputs.is_empty() {
            folded.paragraph("No file was read.");
        }
        folded.rows(
            "Files that were read",
            &manifest.inputs,
            |_| false,
            &[
                ("File", Column::Text, &|input| shown_path(&input.path)),
                ("SHA-256", Column::Text, &|input| input.sha256.clone()),
            ],
        );
        html.folded("Configuration, and hashes of the files that were read", &folded);
    }
    Ok(html)
}

/// A JSON value in one cell.
fn in_a_cell(value: &Value) -> String {
    match value {
        Value::Null => ABSENT.to_owned(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}
