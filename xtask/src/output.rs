//! Output folders that are complete or absent.
//!
//! A command writes into a hidden sibling of the folder it was asked for and renames it at the end.
//! An error, a full disk or Ctrl-C leaves the asked-for folder as it was.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use serde::Serialize;

use crate::manifest::{self, Manifest};

/// A folder under construction.
#[derive(Debug)]
pub(crate) struct OutputFolder {
    target: PathBuf,
    building: tempfile::TempDir,
}

impl OutputFolder {
    /// Begins the folder `target`.
    ///
    /// # Errors
    /// If `target` is a file, or a folder that holds something but no `manifest.json` (it was not
    /// made by this program and is not replaced), or if its parent cannot be written.
    pub(crate) fn begin(target: &Path) -> Result<Self> {
        if target.is_file() {
            bail!("'{}' is a file; give --out a folder", target.display());
        }
        if target.is_dir() && !is_ours(target)? {
            bail!(
                "'{}' holds files that this program did not write; give --out an empty or new \
                 folder",
                target.display()
            );
        }
        let parent = match target.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
            _ => PathBuf::from("."),
        };
        fs::create_dir_all(&parent)
            .with_context(|| format!("cannot make the folder '{}'", parent.display()))?;
        let building = tempfile::Builder::new()
            .prefix(".building-")
            .tempdir_in(&parent)
            .with_context(|| format!("cannot write in '{}'", parent.display()))?;
        crate::interrupt::remove_if_interrupted(building.path());
        Ok(Self { target: target.to_path_buf(), building })
    }

    /// The folder in which to write.
    pub(crate) fn path(&self) -> &Path {
        self.building.path()
    }

    /// Writes `bytes` as `name`.
    pub(crate) fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
        let path = self.path().join(name);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent)
                .with_context(|| format!("cannot make the folder '{}'", parent.display()))?;
        }
        let mut file = fs::File::create(&path).with_context(|| format!("cannot write '{name}'"))?;
        file.write_all(bytes)
            .and_then(|()| file.sync_all())
            .with_context(|| format!("cannot write '{name}' (is the disk full?)"))
    }

    /// Writes `value` as readable JSON.
    pub(crate) fn write_json(&self, name: &str, value: &impl Serialize) -> Result<()> {
        let mut text = serde_json::to_string_pretty(value)
            .with_context(|| format!("cannot express '{name}' as JSON"))?;
        text.push('\n');
        self.write(name, text.as_bytes())
    }

    /// Adds the manifest and puts the folder in its place.
    pub(crate) fn finish(self, manifest: &Manifest) -> Result<PathBuf> {
        self.write_json(manifest::FILE, manifest)?;
        if self.target.is_dir() {
            fs::remove_dir_all(&self.target)
                .with_context(|| format!("cannot replace '{}'", self.target.display()))?;
        }
        let built = self.building.keep();
        fs::rename(&built, &self.target)
            .with_context(|| format!("cannot put '{}' in its place", self.target.display()))?;
        crate::interrupt::forget(&built);
        Ok(self.target)
    }
}

/// Whether `folder` is empty or was made by [`OutputFolder::finish`].
fn is_ours(folder: &Path) -> Result<bool> {
    let mut entries = fs::read_dir(folder)
        .with_context(|| format!("cannot read the folder '{}'", folder.display()))?;
    Ok(entries.next().is_none() || folder.join(manifest::FILE).is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn manifest() -> Manifest {
        Manifest::new("test", serde_json::json!({}), None)
    }

    #[test]
    fn the_folder_appears_only_when_finished() {
        let parent = tempfile::tempdir().expect("temporary folder");
        let target = parent.path().join("result");
        let output = OutputFolder::begin(&target).expect("new folder");
        output.write("deep/a.txt", b"a").expect("writable");
        assert!(!target.exists());
        output.finish(&manifest()).expect("renamed");
        assert_eq!(fs::read(target.join("deep/a.txt")).expect("file"), b"a");
        assert!(target.join(manifest::FILE).is_file());
        assert_eq!(fs::read_dir(parent.path()).expect("folder").count(), 1);
    }

    #[test]
    fn an_abandoned_folder_leaves_the_old_one_and_no_trace() {
        let parent = tempfile::tempdir().expect("temporary folder");
        let target = parent.path().join("result");
        let output = OutputFolder::begin(&target).expect("new folder");
        output.write("a.txt", b"old").expect("writable");
        output.finish(&manifest()).expect("renamed");
        let abandoned = OutputFolder::begin(&target).expect("ours");
        abandoned.write("a.txt", b"new").expect("writable");
        drop(abandoned);
        assert_eq!(fs::read(target.join("a.txt")).expect("file"), b"old");
        assert_eq!(fs::read_dir(parent.path()).expect("folder").count(), 1);
    }

    #[test]
    fn a_strangers_folder_is_not_replaced() {
        let parent = tempfile::tempdir().expect("temporary folder");
        fs::write(parent.path().join("thesis.txt"), "years of work").expect("writable");
        let error = OutputFolder::begin(parent.path()).expect_err("not ours");
        assert!(error.to_string().contains("did not write"), "{error}");
    }
}
