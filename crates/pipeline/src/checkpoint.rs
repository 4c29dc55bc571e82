//! A file beside an output folder from which a command that was ended goes on.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};

use crate::note;

/// The checkpoint of the run that writes one output folder.
#[derive(Debug)]
pub(crate) struct CheckpointFile {
    path: PathBuf,
}

impl CheckpointFile {
    /// The one that belongs to the folder `out`: `out/train.checkpoint` to `out/train`.
    pub(crate) fn beside(out: &Path) -> Self {
        let mut name = out.file_name().unwrap_or_default().to_owned();
        name.push(".checkpoint");
        Self { path: out.with_file_name(name) }
    }

    /// What `resume` makes of what was written last, if a run of this stage was ended before it was done; it also says
    /// how far that run had come, or why it is of no use.
    pub(crate) fn resumed<T>(
        &self,
        stage: &str,
        resume: impl FnOnce(&[u8]) -> Result<(T, String)>,
    ) -> Option<T> {
        let bytes = fs::read(&self.path).ok()?;
        let place = self.path.display();
        match resume(&bytes) {
            Ok((found, done)) => {
                note(format!("{stage}: goes on from '{place}' after {done}"));
                Some(found)
            }
            Err(error) => {
                note(format!("{stage}: '{place}' is not used: {error}"));
                None
            }
        }
    }

    /// Replaces it. Whoever reads it finds either these bytes or those before, whole.
    pub(crate) fn write(&self, bytes: &[u8]) -> Result<()> {
        let mut beside = self.path.as_os_str().to_owned();
        beside.push(".partial");
        let written = fs::File::create(&beside)
            .and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()))
            .and_then(|()| fs::rename(&beside, &self.path));
        written.with_context(|| format!("cannot write '{}'", self.path.display()))
    }

    /// Removes it once the folder is complete.
    pub(crate) fn remove(&self) {
        // It may never have been written; one that stays is only read by the same run.
        let _ = fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slash_at_the_end_of_the_folder_changes_nothing() {
        for out in ["out/train", "out/train/", "out/train/."] {
            let file = CheckpointFile::beside(Path::new(out));
            assert_eq!(file.path, Path::new("out/train.checkpoint"), "{out}");
        }
    }

    #[test]
    fn what_was_written_last_is_read_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = CheckpointFile::beside(&folder.path().join("train"));
        let read = || file.resumed("train", |bytes| Ok((bytes.to_vec(), String::new())));
        assert_eq!(read(), None);
        file.write(b"first").expect("writable");
        file.write(b"last").expect("writable");
        assert_eq!(read().as_deref(), Some(b"last".as_slice()));
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
        file.remove();
        assert_eq!(read(), None);
    }
}
