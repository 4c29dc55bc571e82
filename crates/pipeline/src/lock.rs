//! One run at a time on an output folder.

use std::fs::{self, File, TryLockError};
use std::io;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};

use crate::interrupt;

/// How the names of locks begin and end; the name of the folder stands between.
const BEGINS: &str = ".";
const ENDS: &str = ".lock";
/// How often a lock is tried that another run takes away at this moment.
const ATTEMPTS: usize = 50;

/// Held as long as a run writes a folder. A run that is killed lets go of it.
#[derive(Debug)]
pub(crate) struct Lock {
    path: PathBuf,
    _file: File,
}

impl Lock {
    /// Holds the folder `target`, whose parent exists.
    ///
    /// # Errors
    /// If another run holds it, or its parent cannot be written.
    pub(crate) fn hold(target: &Path) -> Result<Self> {
        let parent = parent(target);
        let Some(name) = target.file_name() else {
            bail!("'{}' cannot be replaced; give --out a folder with a name", target.display());
        };
        let path = parent.join(format!("{BEGINS}{}{ENDS}", name.to_string_lossy()));
        for _ in 0..ATTEMPTS {
            let open = || File::options().create(true).write(true).truncate(false).open(&path);
            let file = interrupt::make_removable(open, |_| path.clone())
                .with_context(|| format!("cannot write in '{}'", parent.display()))?;
            match file.try_lock() {
                Ok(()) if still_there(&file, &path) => return Ok(Self { path, _file: file }),
                // Whoever held it has taken the file away.
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    interrupt::forget(&path);
                    bail!(
                        "another run is writing '{}'; wait for its end, or give another --out",
                        target.display()
                    );
                }
                Err(TryLockError::Error(error)) => {
                    interrupt::forget(&path);
                    return Err(error).with_context(|| format!("cannot lock '{}'", path.display()));
                }
            }
        }
        bail!("other runs are writing '{}'; give another --out", target.display())
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Taken away while it is held: nobody can hold a file that another run removes.
        let _ = fs::remove_file(&self.path);
        interrupt::forget(&self.path);
    }
}

/// A new file that is held until it is closed; `None` where another run took it, or its folder, away at this moment.
///
/// # Errors
/// If it cannot be written or locked.
pub(crate) fn held(path: &Path) -> io::Result<Option<File>> {
    let file = match File::create(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        made => made?,
    };
    match file.try_lock() {
        Ok(()) if still_there(&file, path) => Ok(Some(file)),
        Ok(()) | Err(TryLockError::WouldBlock) => Ok(None),
        Err(TryLockError::Error(error)) => Err(error),
    }
}

/// The folder in which a path lies.
pub(crate) fn parent(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

/// Whether the path still names the open file.
fn still_there(file: &File, path: &Path) -> bool {
    let of = |metadata: fs::Metadata| (metadata.dev(), metadata.ino());
    match (file.metadata(), fs::metadata(path)) {
        (Ok(open), Ok(named)) => of(open) == of(named),
        _ => false,
    }
}

/// Removes a lock that a killed run left behind.
pub(crate) fn sweep(path: &Path) {
    let name = path.file_name().map(|name| name.to_string_lossy()).unwrap_or_default();
    if !(name.starts_with(BEGINS) && name.ends_with(ENDS)) {
        return;
    }
    let Ok(file) = File::open(path) else { return };
    let empty = file.metadata().is_ok_and(|metadata| metadata.is_file() && metadata.len() == 0);
    if empty && file.try_lock().is_ok() && still_there(&file, path) {
        let _ = fs::remove_file(path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_held_by_one_run_and_free_after_it() {
        let folder = tempfile::tempdir().expect("a folder");
        let target = folder.path().join("out");
        let first = Lock::hold(&target).expect("free");
        let error = Lock::hold(&target).expect_err("held").to_string();
        assert!(error.contains("another run is writing"), "{error}");
        drop(first);
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 0);
        Lock::hold(&target).expect("free again");
    }

    #[test]
    fn only_a_lock_that_nobody_holds_is_swept_away() {
        let folder = tempfile::tempdir().expect("a folder");
        let held = Lock::hold(&folder.path().join("held")).expect("free");
        let stale = folder.path().join(".stale.lock");
        let theirs = folder.path().join(".theirs.lock");
        fs::write(&stale, "").expect("writable");
        fs::write(&theirs, "notes").expect("writable");
        for path in [&held.path, &stale, &theirs] {
            sweep(path);
        }
        assert!(held.path.exists() && theirs.exists() && !stale.exists());
    }
}
