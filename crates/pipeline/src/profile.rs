//! How much a stage computes.

/// How much to compute.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Profile {
    /// Minutes on two cores.
    Quick,
    /// The paper's widths, schedules and simulated days; hours, of which `train` takes a quarter of one.
    Paper,
}
