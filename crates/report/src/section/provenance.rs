//! How to make this report again: commands, version, seed, configuration, input hashes.

use serde_json::Value;

use super::shown_path::{shown_command, shown_json, shown_path};
use super::words::plain;
use crate::html::{Column, Html};
use crate::number::ABSENT;
use contract::Manifest;

pub(super) fn body(html: &mut Html, manifests: &[Manifest]) {
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
        html.folded("Configuration, and hashes of the files that were read", |html| {
            settings_and_files(html, manifest);
        });
    }
}

fn settings_and_files(html: &mut Html, manifest: &Manifest) {
    if let Value::Object(config) = shown_json(&manifest.config) {
        html.rows(
            "Resolved configuration",
            &config.into_iter().collect::<Vec<(String, Value)>>(),
            &[
                ("Item", Column::Text, &|(key, _)| plain(key)),
                ("Value", Column::Text, &|(_, value)| match value {
                    Value::Null => ABSENT.to_owned(),
                    Value::String(text) => text.clone(),
                    other => other.to_string(),
                }),
            ],
        );
    }
    if manifest.inputs.is_empty() {
        html.paragraph("No file was read.");
    }
    html.rows(
        "Files that were read",
        &manifest.inputs,
        &[
            ("File", Column::Text, &|input| shown_path(&input.path)),
            ("SHA-256", Column::Text, &|input| input.sha256.clone()),
        ],
    );
}
