//! Where tests find other people's data and results.
//!
//! Published weights, reference traces and open data sets are checked against but never copied
//! into this project. Tests ask for them here and skip, saying so, where they are absent; a clone
//! alone therefore passes its tests. Used as a development dependency only.

use std::path::{Path, PathBuf};

/// The environment variable that names the folder of reference material.
pub const VARIABLE: &str = "T1D_REFERENCE";

/// The path of `name` inside the reference folder, or `None` after a message that says so.
///
/// The folder is `$T1D_REFERENCE` if that is set, else `shared/reference` beside the workspace.
/// `test` is the name of the asking test, for the message.
#[must_use]
pub fn find(name: &str, test: &str) -> Option<PathBuf> {
    let folder = std::env::var_os(VARIABLE).map_or_else(beside_the_workspace, PathBuf::from);
    let path = folder.join(name);
    if path.exists() {
        return Some(path);
    }
    #[expect(clippy::print_stderr, reason = "a skipped test must say that it was skipped")]
    {
        eprintln!(
            "skipped {test}: no reference material '{name}'; set {VARIABLE} to the folder that \
             holds it"
        );
    }
    None
}

fn beside_the_workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/reference")
}
