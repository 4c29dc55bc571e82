//! What Ctrl-C leaves behind: nothing half-written.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};
use std::time::Duration;

static BUILDING: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());
static HANDLER: Once = Once::new();

/// Exit status of a program that was ended by SIGINT, as shells report it.
const INTERRUPTED: i32 = 130;
/// How often a folder's removal is tried, and how long the next trial is put off.
const ATTEMPTS: usize = 20;
const PAUSE: Duration = Duration::from_millis(25);

/// Removes `folder` if the program is interrupted before [`forget`].
pub(crate) fn remove_if_interrupted(folder: &Path) {
    HANDLER.call_once(|| {
        // Without a handler the default applies: the program ends and the hidden folder stays, which
        // no later run mistakes for a result.
        let _ = ctrlc::set_handler(|| {
            // No process of ours may go on writing, and none may begin.
            let _none_begins = crate::asked::end_all();
            for folder in building().iter() {
                remove(folder);
            }
            crate::progress::say("interrupted; nothing half-written was left behind");
            std::process::exit(INTERRUPTED);
        });
    });
    building().push(folder.to_path_buf());
}

/// Removes a folder into which another thread may still be writing its last file.
fn remove(folder: &Path) {
    for _ in 0..ATTEMPTS {
        let _ = std::fs::remove_dir_all(folder);
        if !folder.exists() {
            return;
        }
        std::thread::sleep(PAUSE);
    }
}

/// The folder is in its place; an interruption must not touch it.
pub(crate) fn forget(folder: &Path) {
    building().retain(|known| known != folder);
}

fn building() -> MutexGuard<'static, Vec<PathBuf>> {
    BUILDING.lock().unwrap_or_else(PoisonError::into_inner)
}
