//! How to make this report again: commands, version, seed, configuration, input hashes.

use serde_json::Value;

use super::any_json::json;
use super::shown_path::{shown_command, shown_json, shown_path};
use crate::ReportError;
use crate::html::{Column, Html};
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
        let configured = match &manifest.config {
            Value::Null => false,
            Value::Object(config) => !config.is_empty(),
            _ => true,
        };
        let mut folded = Html::default();
        if configured {
            json(&mut folded, "Resolved configuration", &shown_json(&manifest.config));
        }
        if manifest.inputs.is_empty() {
            folded.paragraph("No file was read.");
        } else {
            let rows: Vec<(bool, Vec<String>)> = manifest
                .inputs
                .iter()
                .map(|input| (false, vec![shown_path(&input.path), input.sha256.clone()]))
                .collect();
            folded.table(
                "Files that were read",
                &[("File", Column::Text), ("SHA-256", Column::Text)],
                &rows,
            );
        }
        html.folded("Configuration, and hashes of the files that were read", &folded);
    }
    Ok(html)
}
