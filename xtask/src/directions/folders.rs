//! Which part of a crate may know which of its modules.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use anyhow::{Context as _, Result, bail};

/// A module with a folder, and the modules of its crate that it may name.
struct Folder {
    /// Path of the module without `.rs`, from the root of the workspace.
    module: &'static str,
    may_know: &'static [&'static str],
}

/// The filter answers; the questions that are put to it are elsewhere.
const FOLDERS: [Folder; 1] =
    [Folder { module: "crates/gap/src/filter", may_know: &["error", "filter", "quality"] }];

/// Reports every module of its crate that a folder names and must not know.
pub(super) fn check(root: &Path) -> Result<()> {
    for folder in &FOLDERS {
        let mut text = read(&root.join(folder.module).with_extension("rs"))?;
        collect(&root.join(folder.module), &mut text)?;
        let wrong: Vec<String> = modules_named(&text)
            .into_iter()
            .filter(|name| !folder.may_know.contains(&name.as_str()))
            .collect();
        if !wrong.is_empty() {
            bail!(
                "{} names modules that it must not know (docs/architecture.md): {}",
                folder.module,
                wrong.join(", ")
            );
        }
    }
    Ok(())
}

fn read(path: &Path) -> Result<String> {
    fs::read_to_string(path).with_context(|| format!("reading '{}'", path.display()))
}

fn collect(folder: &Path, text: &mut String) -> Result<()> {
    let entries =
        fs::read_dir(folder).with_context(|| format!("reading '{}'", folder.display()))?;
    for entry in entries {
        let path = entry.with_context(|| format!("reading '{}'", folder.display()))?.path();
        if path.is_dir() {
            collect(&path, text)?;
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            text.push_str(&read(&path)?);
        }
    }
    Ok(())
}

/// The modules behind `crate::` in a text; types at the root of the crate begin with a capital and do not count.
fn modules_named(text: &str) -> BTreeSet<String> {
    text.split("crate::")
        .skip(1)
        .map(|rest| rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect())
        .filter(|name: &String| name.starts_with(|c: char| c.is_lowercase()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modules_are_read_behind_the_word_crate() {
        let text = "use crate::which::round;\nfn f(x: crate::NoiseModel) -> crate::error::E {}";
        assert_eq!(modules_named(text).into_iter().collect::<Vec<_>>(), ["error", "which"]);
    }
}
