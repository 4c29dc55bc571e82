//! Output folders that are complete or absent.
//!
//! A command writes into a hidden folder beside the one it was asked for and renames it at the end.
//! An error, a full disk or Ctrl-C leaves the asked-for folder as it was; so does a kill, after the next run.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, anyhow, bail};
use contract::Document;

use crate::hidden_folder::{HiddenFolder, everyones, sweep};
use crate::lock::{Lock, parent};
use crate::manifest::{self, Manifest};
use crate::next_step::wrote;
use crate::progress::table;
use crate::result_file::print_result;

/// A folder under construction.
#[derive(Debug)]
pub struct OutputFolder {
    target: PathBuf,
    /// Where it is built, in the hidden folder.
    built: PathBuf,
    hidden: HiddenFolder,
    /// The manifest of the run, outputs not yet listed.
    pub(crate) manifest: Manifest,
    // Dropped last: nobody else begins before the folder is in its place.
    _lock: Lock,
}

/// The name of a folder under construction within its hidden folder.
const BUILT: &str = "built";

impl OutputFolder {
    /// Begins the folder `target` for the run that `manifest` describes.
    ///
    /// # Errors
    /// If `target` is a file, lies in a folder that is an input of the run or holds one, or holds
    /// anything but the output of the same command (it is not replaced), if another run is writing it,
    /// or if its parent cannot be written. A link to a folder is followed.
    pub fn begin(target: &Path, manifest: Manifest) -> Result<Self> {
        let target = followed(target)?;
        let parent = parent(&target);
        check_replaceable(&target, &manifest)?;
        fs::create_dir_all(&parent)
            .with_context(|| format!("cannot make the folder '{}'", parent.display()))?;
        sweep(&parent);
        // That may have put an earlier output back.
        check_replaceable(&target, &manifest)?;
        let lock = Lock::hold(&target)?;
        let hidden = HiddenFolder::within(&parent)?;
        let built = hidden.path().join(BUILT);
        fs::create_dir(&built)
            .with_context(|| format!("cannot write in '{}'", parent.display()))?;
        Ok(Self { target, built, hidden, manifest, _lock: lock })
    }

    /// The folder in which to write.
    pub fn path(&self) -> &Path {
        crate::interrupt::wait_if_interrupted();
        &self.built
    }

    /// Writes `bytes` as `name`.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
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

    /// Writes a document under its own name as readable JSON.
    pub fn write_document<T: Document>(&self, document: &T) -> Result<()> {
        self.write_document_as(T::FILE, document)
    }

    /// Writes a document under another name.
    pub fn write_document_as(&self, name: &str, document: &impl Document) -> Result<()> {
        let mut text = serde_json::to_string_pretty(document)
            .with_context(|| format!("cannot express '{name}' as JSON"))?;
        text.push('\n');
        self.write(name, text.as_bytes())
    }

    /// Adds the manifest and puts the folder in its place.
    pub fn finish(self) -> Result<PathBuf> {
        let manifest = self.manifest.clone().with_outputs_in(self.path())?;
        self.write_document::<contract::Manifest>(&manifest)?;
        self.hidden
            .put(&self.built, &self.target)
            .with_context(|| format!("cannot put '{}' in its place", self.target.display()))?;
        print_result(&self.manifest.stage, &self.target);
        let cohort = self.manifest.folders.first().map(PathBuf::as_path);
        wrote(&self.manifest.stage, &self.target, cohort);
        Ok(self.target)
    }

    /// The same with a table of text, which is written as `name` and printed.
    pub fn finish_with_table(self, name: &str, text: &str) -> Result<PathBuf> {
        self.write(name, text.as_bytes())?;
        let place = self.finish()?;
        table(text);
        Ok(place)
    }
}

/// Removes a finished folder; a run that is killed meanwhile leaves nothing of it under its name.
///
/// # Errors
/// If its parent cannot be written.
pub(crate) fn discard(folder: &Path) -> Result<()> {
    let aside = HiddenFolder::within(&parent(folder))?;
    fs::rename(folder, aside.path().join("discarded"))
        .with_context(|| format!("cannot remove '{}'", folder.display()))
}

/// Where an output is to stand: the folder itself, or the one that a link names.
///
/// # Errors
/// For a link to nothing, and a path that cannot be.
pub(crate) fn followed(target: &Path) -> Result<PathBuf> {
    match fs::symlink_metadata(target) {
        Ok(metadata) if metadata.is_symlink() => {
            let named = fs::read_link(target).unwrap_or_default();
            if !target.exists() {
                // A killed run may have put it aside.
                sweep(&parent(&parent(target).join(&named)));
            }
            target.canonicalize().map_err(|_| {
                anyhow!(
                    "'{}' is a link to '{}', which is not there; make that folder, or give another --out",
                    target.display(),
                    named.display()
                )
            })
        }
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(error).with_context(|| format!("cannot write '{}'", target.display()))
        }
        _ => Ok(target.to_path_buf()),
    }
}

/// Writes a file beside finished folders so that it is there whole or not at all.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut whole = tempfile::Builder::new()
        .permissions(everyones(0o666))
        .tempfile_in(folder)
        .with_context(|| format!("cannot write in '{}'", folder.display()))?;
    whole
        .write_all(bytes)
        .with_context(|| format!("cannot write '{}' (is the disk full?)", path.display()))?;
    whole.persist(path).with_context(|| format!("cannot write '{}'", path.display()))?;
    Ok(())
}

/// Refuses a target whose replacement would lose something.
fn check_replaceable(target: &Path, manifest: &Manifest) -> Result<()> {
    if let Some(input) = manifest.folder_around(target) {
        bail!(
            "'{}' lies in '{}', an input of this run, and would be read with it; give another --out",
            target.display(),
            input.display()
        );
    }
    if !target.exists() {
        return Ok(());
    }
    if !target.is_dir() {
        bail!("'{}' is a file; give --out a folder", target.display());
    }
    if let Some(input) = manifest.input_within(target) {
        bail!(
            "'{}' holds '{input}', an input of this run, and would be replaced; give another --out",
            target.display()
        );
    }
    let mut entries = fs::read_dir(target)
        .with_context(|| format!("cannot read the folder '{}'", target.display()))?;
    let Some(first) = entries.next() else { return Ok(()) };
    let strangers = match Manifest::read(target) {
        Some(before) if before.stage == manifest.stage => {
            let mut strangers = before.strangers_in(target)?;
            // The command `report` adds its file to folders that are finished.
            strangers.retain(|name| name != manifest::REPORT);
            strangers
        }
        Some(before) => bail!(
            "'{}' is the output of '{}'; give --out an empty or new folder",
            target.display(),
            before.stage
        ),
        None => vec![first.map_or_else(
            |error| error.to_string(),
            |entry| entry.file_name().to_string_lossy().into_owned(),
        )],
    };
    if let Some(first) = strangers.first() {
        bail!(
            "'{}' holds files that this program did not write ({first}); give --out an empty or new \
             folder",
            target.display()
        );
    }
    Ok(())
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
        let output = OutputFolder::begin(&target, manifest()).expect("new folder");
        output.write("deep/a.txt", b"a").expect("writable");
        assert!(!target.exists());
        output.finish().expect("renamed");
        assert_eq!(fs::read(target.join("deep/a.txt")).expect("file"), b"a");
        assert!(target.join(manifest::FILE).is_file());
        let mode = fs::metadata(&target).expect("a folder").permissions();
        let plain = parent.path().join("plain");
        fs::create_dir(&plain).expect("writable");
        assert_eq!(mode, fs::metadata(&plain).expect("a folder").permissions());
        fs::remove_dir(&plain).expect("empty");
        assert_eq!(fs::read_dir(parent.path()).expect("folder").count(), 1);
    }

    #[test]
    fn an_abandoned_folder_leaves_the_old_one_and_no_trace() {
        let parent = tempfile::tempdir().expect("temporary folder");
        let target = parent.path().join("result");
        let output = OutputFolder::begin(&target, manifest()).expect("new folder");
        output.write("a.txt", b"old").expect("writable");
        output.finish().expect("renamed");
        let abandoned = OutputFolder::begin(&target, manifest()).expect("ours");
        abandoned.write("a.txt", b"new").expect("writable");
        drop(abandoned);
        assert_eq!(fs::read(target.join("a.txt")).expect("file"), b"old");
        assert_eq!(fs::read_dir(parent.path()).expect("folder").count(), 1);
    }

    #[test]
    fn nothing_is_lost_in_a_folder_that_was_ours() {
        let parent = tempfile::tempdir().expect("temporary folder");
        let target = parent.path().join("result");
        let output = OutputFolder::begin(&target, manifest()).expect("new folder");
        output.write("a.txt", b"ours").expect("writable");
        output.finish().expect("renamed");

        let other = Manifest::new("other", serde_json::json!({}), None);
        let error = OutputFolder::begin(&target, other).expect_err("another command's");
        assert!(error.to_string().contains("output of 'test'"), "{error}");

        let input = Manifest::new("test", serde_json::json!({}), None)
            .with_input(&target.join("a.txt"))
            .expect("readable");
        let error = OutputFolder::begin(&target, input).expect_err("an input");
        assert!(error.to_string().contains("an input of this run"), "{error}");

        fs::write(target.join("notes.txt"), "mine").expect("writable");
        let error = OutputFolder::begin(&target, manifest()).expect_err("a stranger's file");
        assert!(error.to_string().contains("notes.txt"), "{error}");
    }

    #[test]
    fn a_link_is_followed_and_stays_a_link() {
        let parent = tempfile::tempdir().expect("temporary folder");
        let (real, link) = (parent.path().join("real"), parent.path().join("link"));
        std::os::unix::fs::symlink("real", &link).expect("a link");
        let error = OutputFolder::begin(&link, manifest()).expect_err("a link to nothing");
        assert!(error.to_string().contains("a link to 'real'"), "{error}");
        fs::create_dir(&real).expect("writable");
        for text in ["first", "second"] {
            let output = OutputFolder::begin(&link, manifest()).expect("a link to a folder");
            output.write("a.txt", text.as_bytes()).expect("writable");
            output.finish().expect("renamed");
            assert!(link.is_symlink());
            assert_eq!(fs::read_to_string(real.join("a.txt")).expect("a file"), text);
        }
    }

    #[test]
    fn an_output_does_not_lie_in_an_input() {
        let parent = tempfile::tempdir().expect("temporary folder");
        let input = parent.path().join("cohort");
        fs::create_dir(&input).expect("writable");
        fs::write(input.join("people.csv"), "x").expect("writable");
        let with = |path: &Path| manifest().with_input(path).expect("readable");
        for within in ["out", "new/out"] {
            let error = OutputFolder::begin(&input.join(within), with(&input)).expect_err("in it");
            assert!(error.to_string().contains("lies in"), "{error}");
        }
        assert_eq!(fs::read_dir(&input).expect("a folder").count(), 1);
        // A file's folder is no input.
        let beside = with(&input.join("people.csv"));
        OutputFolder::begin(&input.join("out"), beside).expect("beside a file");
    }

    #[test]
    fn two_runs_do_not_write_one_folder() {
        let parent = tempfile::tempdir().expect("temporary folder");
        let target = parent.path().join("result");
        let first = OutputFolder::begin(&target, manifest()).expect("free");
        let error = OutputFolder::begin(&target, manifest()).expect_err("held");
        assert!(error.to_string().contains("another run"), "{error}");
        first.finish().expect("renamed");
        OutputFolder::begin(&target, manifest()).expect("free again");
        assert_eq!(fs::read_dir(parent.path()).expect("folder").count(), 1);
    }

    #[test]
    fn what_a_killed_run_put_aside_is_put_back_and_then_judged() {
        let parent = tempfile::tempdir().expect("temporary folder");
        let target = parent.path().join("result");
        let output = OutputFolder::begin(&target, manifest()).expect("new folder");
        output.write("a.txt", b"old").expect("writable");
        output.finish().expect("renamed");
        let replaced = parent.path().join(".building-4194999-abc/replaced");
        fs::create_dir_all(&replaced).expect("writable");
        fs::write(replaced.with_file_name("lock"), "").expect("writable");
        fs::rename(&target, replaced.join("result")).expect("ours");

        let other = Manifest::new("other", serde_json::json!({}), None);
        let error = OutputFolder::begin(&target, other).expect_err("another command's");
        assert!(error.to_string().contains("output of 'test'"), "{error}");
        assert_eq!(fs::read(target.join("a.txt")).expect("file"), b"old");
        assert_eq!(fs::read_dir(parent.path()).expect("folder").count(), 1);
    }

    #[test]
    fn a_strangers_folder_is_not_replaced() {
        let parent = tempfile::tempdir().expect("temporary folder");
        fs::write(parent.path().join("thesis.txt"), "years of work").expect("writable");
        let error = OutputFolder::begin(parent.path(), manifest()).expect_err("not ours");
        assert!(error.to_string().contains("did not write"), "{error}");
    }
}
