//! The same work in PyTorch, a process of its own.

use std::process::Command;

use anyhow::{Context as _, Result, ensure};
use pipeline::{note, workspace_root};

/// What a script of `benches/peers` prints under these options; `None` if PyTorch is not installed.
///
/// # Errors
/// If the script fails.
pub(crate) fn times(script: &str, options: &[(&str, String)]) -> Result<Option<Vec<u8>>> {
    let path = workspace_root().join("benches/peers").join(script);
    let installed = Command::new("python3").args(["-c", "import torch"]).output();
    if !installed.is_ok_and(|output| output.status.success()) || !path.exists() {
        note("PyTorch is not installed; its row is left out");
        return Ok(None);
    }
    let typed = options.iter().flat_map(|(name, value)| [format!("--{name}"), value.clone()]);
    let output =
        Command::new("python3").arg(&path).args(typed).output().context("starting python3")?;
    let errors = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "benches/peers/{script} failed: {errors}");
    Ok(Some(output.stdout))
}
