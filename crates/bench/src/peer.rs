//! The same work in PyTorch, a process of its own.

use std::process::Command;

use anyhow::{Context as _, Result, ensure};
use pipeline::{note, workspace_root};
use serde::Deserialize;

/// What a script of `benches/peers` prints.
#[derive(Debug, Deserialize)]
pub(crate) struct Peer {
    pub engine: String,
    parameters: usize,
    pub median_ms: f64,
    pub least_ms: f64,
    /// Only some scripts take it.
    pub median_processor_ms: Option<f64>,
}

/// What a script takes under these options for a network of so many parameters; `None` if PyTorch is not installed.
///
/// # Errors
/// If the script fails, or its network has another size.
pub(crate) fn times(
    script: &str,
    options: &[(&str, String)],
    parameters: usize,
) -> Result<Option<Peer>> {
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
    let peer: Peer = serde_json::from_slice(&output.stdout).context("what PyTorch took")?;
    let found = peer.parameters;
    ensure!(found == parameters, "the peer has {found} parameters, not {parameters}");
    Ok(Some(peer))
}
