//! What Ctrl-C leaves behind: nothing half-written, and no process of ours.

use std::io;
use std::path::{Path, PathBuf};
use std::process::Child;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, Once, PoisonError};
use std::time::Duration;

/// Processes that have not been seen to end.
static RUNNING: Mutex<Vec<Arc<Mutex<Child>>>> = Mutex::new(Vec::new());
static BUILDING: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());
static HANDLER: Once = Once::new();
/// Set by an interruption.
static ENDING: AtomicBool = AtomicBool::new(false);

/// Exit status of a program that was ended by SIGINT, as shells report it.
const INTERRUPTED: i32 = 130;
/// How often a folder's removal is tried, and how long the next trial is put off.
const ATTEMPTS: usize = 20;
const PAUSE: Duration = Duration::from_millis(25);

/// Makes a folder or a file that is removed if the program is interrupted before [`forget`]; `path` says where it is.
///
/// An interruption waits until what is being made is known, and lets nothing be made after it.
///
/// # Errors
/// Those of `make`.
pub(crate) fn make_removable<T>(
    make: impl FnOnce() -> io::Result<T>,
    path: impl FnOnce(&T) -> PathBuf,
) -> io::Result<T> {
    handle();
    let mut building = held(&BUILDING);
    let made = make()?;
    building.push(path(&made));
    Ok(made)
}

/// Puts folders in their places without an interruption between.
///
/// # Errors
/// Those of `put`.
pub(crate) fn undisturbed(put: impl FnOnce() -> io::Result<()>) -> io::Result<()> {
    let _none_between = held(&BUILDING);
    put()
}

/// Begins to listen for interruptions.
fn handle() {
    HANDLER.call_once(|| {
        // Without a handler the default applies: the program ends and the hidden folder stays, which
        // no later run mistakes for a result.
        let _ = ctrlc::set_handler(|| {
            // No process or thread of ours may go on writing, and none may begin.
            ENDING.store(true, Ordering::SeqCst);
            let (running, building) = (running(), held(&BUILDING));
            running.iter().for_each(|child| end(child));
            building.iter().for_each(|folder| remove(folder));
            crate::progress::say("interrupted; nothing half-written was left behind");
            std::process::exit(INTERRUPTED);
        });
    });
}

/// Removes a file, or a folder into which another thread may still be writing its last file: it has to stay
/// away for a while, since a thread that makes a folder for its file brings it back.
fn remove(folder: &Path) {
    let mut absent = false;
    if folder.is_file() {
        let _ = std::fs::remove_file(folder);
        return;
    }
    for _ in 0..ATTEMPTS {
        let _ = std::fs::remove_dir_all(folder);
        let gone = !folder.exists();
        if gone && absent {
            return;
        }
        absent = gone;
        std::thread::sleep(PAUSE);
    }
}

/// Where a thread is about to write: waits for the end if the program was interrupted.
pub(crate) fn wait_if_interrupted() {
    while ENDING.load(Ordering::SeqCst) {
        std::thread::sleep(PAUSE);
    }
}

/// It is gone, or in its place; an interruption must not touch it.
pub(crate) fn forget(folder: &Path) {
    held(&BUILDING).retain(|known| known != folder);
}

/// Processes of ours that are running, so that an interruption can end them; none begins as long as the guard is held.
pub(crate) fn running() -> MutexGuard<'static, Vec<Arc<Mutex<Child>>>> {
    held(&RUNNING)
}

/// Ends a process of ours; one that has ended by itself is as good.
pub(crate) fn end(child: &Mutex<Child>) {
    let mut child = held(child);
    let _ = child.kill();
    let _ = child.wait();
}

/// What a mutex holds, also after a thread that held it has failed.
pub(crate) fn held<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
