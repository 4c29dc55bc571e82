//! A hidden folder beside an output: where a run builds, and where it puts aside what is about to be removed.

use std::ffi::OsStr;
use std::fs::{self, File, Permissions};
use std::io;
use std::path::Path;

use anyhow::{Context as _, Result, bail};
use tempfile::TempDir;

use crate::interrupt;
use crate::lock::{self, Lock};

/// How the names of hidden folders begin; the number of the process follows.
const BEGINS: &str = ".building-";
/// The file in it that is locked as long as its run lives.
const LOCK: &str = "lock";
/// The folder in it that holds an earlier output, under its own name, until the new one is in its place.
const REPLACED: &str = "replaced";
/// How often one is made that another run takes away at this moment.
const ATTEMPTS: usize = 50;

/// A hidden folder, removed when it is dropped, on interruption, or by a later run where this one is killed.
#[derive(Debug)]
pub(crate) struct HiddenFolder {
    folder: TempDir,
    // Dropped last: nobody else takes the folder for a dead run's.
    _held: File,
}

impl HiddenFolder {
    /// A new one in `parent`.
    ///
    /// # Errors
    /// If `parent` cannot be written.
    pub(crate) fn within(parent: &Path) -> Result<Self> {
        let prefix = format!("{BEGINS}{}-", std::process::id());
        let make = || {
            tempfile::Builder::new()
                .prefix(&prefix)
                .permissions(everyones(0o777))
                .tempdir_in(parent)
        };
        let path = |folder: &TempDir| folder.path().to_path_buf();
        let problem = || format!("cannot write in '{}'", parent.display());
        for _ in 0..ATTEMPTS {
            let folder = interrupt::make_removable(make, path).with_context(problem)?;
            if let Some(held) = lock::held(&folder.path().join(LOCK)).with_context(problem)? {
                return Ok(Self { folder, _held: held });
            }
            interrupt::forget(folder.path());
        }
        bail!("other runs remove what is made in '{}'; try again", parent.display())
    }

    /// Where it is.
    pub(crate) fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Puts `built`, which lies within, in the place of `target`, and removes the rest.
    ///
    /// # Errors
    /// Where a folder cannot be renamed; an earlier `target` is then where it was.
    pub(crate) fn put(self, built: &Path, target: &Path) -> io::Result<()> {
        let replaced = self.path().join(REPLACED);
        let earlier = replaced.join(target.file_name().unwrap_or(OsStr::new("output")));
        let put = || {
            if target.is_dir() {
                fs::create_dir(&replaced)?;
                fs::rename(target, &earlier)?;
            }
            fs::rename(built, target).inspect_err(|_| {
                let _ = fs::rename(&earlier, target);
            })
        };
        let done = interrupt::undisturbed(put);
        if done.is_err() && earlier.exists() {
            // It cannot go back now; the next run tries again.
            interrupt::forget(self.path());
            let _ = self.folder.keep();
        }
        done
    }
}

/// Permissions of which the user's mask takes away what it will; temporary files are otherwise for
/// their owner's eyes only, which results are not.
pub(crate) fn everyones(mode: u32) -> Permissions {
    std::os::unix::fs::PermissionsExt::from_mode(mode)
}

/// Removes what killed runs left in `parent`, and puts back an output that one of them was about to replace. Best
/// effort: another run may be at work beside us.
pub(crate) fn sweep(parent: &Path) {
    let Ok(entries) = fs::read_dir(parent) else { return };
    for entry in entries.flatten() {
        lock::sweep(&entry.path());
        if entry.file_name().to_string_lossy().starts_with(BEGINS) {
            sweep_folder(&entry.path(), parent);
        }
    }
}

fn sweep_folder(folder: &Path, parent: &Path) {
    // A run that was killed before it could lock left an empty one; what holds anything stays.
    let _ = fs::remove_dir(folder);
    let Ok(file) = File::open(folder.join(LOCK)) else { return };
    if file.try_lock().is_err() {
        return;
    }
    if nothing_is_lost_with(folder, parent) {
        let _ = fs::remove_dir_all(folder);
    }
    // A process that starts at this moment has inherited the file: to close it would not free the folder.
    let _ = file.unlock();
}

/// Puts back what a killed run was about to replace; whether nothing in the folder is of use any more.
fn nothing_is_lost_with(folder: &Path, parent: &Path) -> bool {
    let replaced = folder.join(REPLACED);
    let Ok(entries) = fs::read_dir(&replaced) else { return !replaced.exists() };
    entries.flatten().all(|earlier| {
        let target = parent.join(earlier.file_name());
        // Whoever writes there now is about to put another in its place.
        let Ok(_lock) = Lock::hold(&target) else { return false };
        target.exists() || fs::rename(earlier.path(), &target).is_ok()
    })
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    /// What a run left that was killed when it had put aside the output `out`.
    fn killed(parent: &Path) -> PathBuf {
        // That process is alive: its number says nothing, as that of a process in another container.
        let folder = parent.join(format!("{BEGINS}{}-abc", std::process::id()));
        for (name, text) in [("built/a.txt", "new"), ("replaced/out/a.txt", "old"), (LOCK, "")] {
            let file = folder.join(name);
            fs::create_dir_all(file.parent().expect("a parent")).expect("writable");
            fs::write(file, text).expect("writable");
        }
        folder
    }

    #[test]
    fn what_killed_runs_left_is_swept_away_and_what_lives_is_not() {
        let parent = tempfile::tempdir().expect("a folder");
        let empty = parent.path().join(".building-1-abc");
        fs::create_dir(&empty).expect("writable");
        // No process here has this number: it is one of another machine or container.
        let alive = parent.path().join(".building-4194999-abc");
        fs::create_dir(&alive).expect("writable");
        let held = lock::held(&alive.join(LOCK)).expect("writable").expect("free");
        let dead = killed(parent.path());
        fs::remove_dir_all(dead.join(REPLACED)).expect("ours");
        sweep(parent.path());
        assert!(alive.exists() && !dead.exists() && !empty.exists());
        held.unlock().expect("held");
        sweep(parent.path());
        assert!(!alive.exists());
    }

    #[test]
    fn an_output_that_a_killed_run_had_put_aside_is_put_back() {
        let parent = tempfile::tempdir().expect("a folder");
        let out = parent.path().join("out");
        let read = || fs::read_to_string(out.join("a.txt")).expect("readable");
        killed(parent.path());
        let writing = Lock::hold(&out).expect("free");
        sweep(parent.path());
        assert!(!out.exists(), "another run is writing it");
        drop(writing);
        sweep(parent.path());
        assert_eq!(read(), "old");
        assert_eq!(fs::read_dir(parent.path()).expect("a folder").count(), 1);

        // Where another stands in its place it is of no use.
        fs::write(out.join("a.txt"), "new").expect("writable");
        killed(parent.path());
        sweep(parent.path());
        assert_eq!(read(), "new");
        assert_eq!(fs::read_dir(parent.path()).expect("a folder").count(), 1);
    }

    #[test]
    fn an_output_whose_successor_cannot_take_its_place_stays() {
        let parent = tempfile::tempdir().expect("a folder");
        let out = parent.path().join("out");
        fs::create_dir(&out).expect("writable");
        fs::write(out.join("a.txt"), "old").expect("writable");
        let hidden = HiddenFolder::within(parent.path()).expect("writable");
        let built = hidden.path().join("never built");
        hidden.put(&built, &out).expect_err("nothing to put");
        assert_eq!(fs::read_to_string(out.join("a.txt")).expect("readable"), "old");
        assert_eq!(fs::read_dir(parent.path()).expect("a folder").count(), 1);
    }
}
