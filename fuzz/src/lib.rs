//! The targets of `fuzz-targets` under libFuzzer; `docs/fuzzing.md` says how to run them.

/// Runs a target on bytes.
pub fn run(name: &str, bytes: &[u8]) {
    let target = fuzz_targets::target(name).expect("named after a target");
    (target.run)(bytes);
}
