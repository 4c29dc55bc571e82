//! What Ctrl-C leaves behind: nothing half-written.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};

static BUILDING: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());
static HANDLER: Once = Once::new();

/// Exit status of a program that was ended by SIGINT, as shells report it.
const INTERRUPTED: i32 = 130;

/// Removes `folder` if the program is interrupted before [`forget`].
pub(crate) fn remove_if_interrupted(folder: &Path) {
    HANDLER.call_once(|| {
        // Without a handler the default applies: the program ends and the hidden folder stays, which
        // no later run mistakes for a result.
        let _ = ctrlc::set_handler(|| {
            for folder in building().iter() {
                let _ = std::fs::remove_dir_all(folder);
            }
            crate::progress::say("interrupted; nothing half-written was left behind");
            std::process::exit(INTERRUPTED);
        });
    });
    building().push(folder.to_path_buf());
}

/// The folder is in its place; an interruption must not touch it.
pub(crate) fn forget(folder: &Path) {
    building().retain(|known| known != folder);
}

fn building() -> MutexGuard<'static, Vec<PathBuf>> {
    BUILDING.lock().unwrap_or_else(PoisonError::into_inner)
}
