//! The targets of `fuzz-targets` under libFuzzer; `docs/fuzzing.md` says how to run them.

use std::panic::{self, AssertUnwindSafe};
use std::sync::{Mutex, Once, PoisonError};

/// Where and why the last panic was.
static LAST: Mutex<String> = Mutex::new(String::new());

/// Runs a target on bytes and aborts if it panics. A panic inside a library that its caller turns
/// into an error is none of the target.
pub fn run(name: &str, bytes: &[u8]) {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        panic::set_hook(Box::new(|info| {
            *LAST.lock().unwrap_or_else(PoisonError::into_inner) = info.to_string();
        }));
    });
    let target = fuzz_targets::target(name).expect("named after a target");
    if panic::catch_unwind(AssertUnwindSafe(|| (target.run)(bytes))).is_err() {
        eprintln!("{}", LAST.lock().unwrap_or_else(PoisonError::into_inner));
        std::process::abort();
    }
}
