//! Processes of ours that are running, so that an interruption can end them.

use std::process::Child;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Processes that have not been seen to end.
static RUNNING: Mutex<Vec<Arc<Mutex<Child>>>> = Mutex::new(Vec::new());

pub(crate) fn running() -> MutexGuard<'static, Vec<Arc<Mutex<Child>>>> {
    held(&RUNNING)
}

pub(crate) fn held<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Ends a process of ours; one that has ended by itself is as good.
pub(crate) fn end(child: &Mutex<Child>) {
    let mut child = held(child);
    let _ = child.kill();
    let _ = child.wait();
}

/// Ends every process that was asked. None begins as long as the returned guard is held.
pub(crate) fn end_all() -> MutexGuard<'static, impl Sized> {
    let running = running();
    running.iter().for_each(|child| end(child));
    running
}
