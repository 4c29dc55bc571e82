//! The situation that the verdict names.

use super::LEVEL;
use contract::Diagnosis;
use contract::diagnosis::{CellFactor, CellGap};

/// The situation that stands out with the largest share of the error.
pub(super) fn worst(diagnosis: &Diagnosis) -> Option<&CellGap> {
    largest(diagnosis, |cell| cell.p_adjusted < LEVEL)
}

/// The situation in which the largest part of what is missing is expected, where anything is.
pub(super) fn expected(diagnosis: &Diagnosis) -> Option<&CellGap> {
    largest(diagnosis, |cell| cell.expected_mg_dl.is_some())
}

/// Of the situations that a verdict may name and of which something holds, that with the largest share.
fn largest(diagnosis: &Diagnosis, holds: impl Fn(&CellGap) -> bool) -> Option<&CellGap> {
    let named = [CellFactor::Hour, CellFactor::Context, CellFactor::GlucoseBand];
    let cells = diagnosis.cells.iter().filter(|cell| named.contains(&cell.factor) && holds(cell));
    cells.max_by(|a, b| a.share_of_gap.total_cmp(&b.share_of_gap))
}

/// `under` or `over`.
pub(super) fn direction(cell: &CellGap) -> &'static str {
    if cell.mean_error_mg_dl > 0.0 { "under" } else { "over" }
}
