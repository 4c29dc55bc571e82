//! The situation that the verdict names.

use super::LEVEL;
use contract::Diagnosis;
use contract::diagnosis::{CellFactor, CellGap};

/// Situations that a verdict may name.
fn situations(diagnosis: &Diagnosis) -> impl Iterator<Item = &CellGap> {
    let named = [CellFactor::Hour, CellFactor::Context, CellFactor::GlucoseBand];
    diagnosis.cells.iter().filter(move |cell| named.contains(&cell.factor))
}

/// The situation that stands out with the largest share of the error.
pub(super) fn worst(diagnosis: &Diagnosis) -> Option<&CellGap> {
    situations(diagnosis)
        .filter(|cell| cell.p_adjusted < LEVEL)
        .max_by(|a, b| a.share_of_gap.total_cmp(&b.share_of_gap))
}

/// The situation in which the largest part of what is missing is expected, where anything is.
pub(super) fn expected(diagnosis: &Diagnosis) -> Option<&CellGap> {
    situations(diagnosis)
        .filter(|cell| cell.expected_mg_dl.is_some())
        .max_by(|a, b| a.share_of_gap.total_cmp(&b.share_of_gap))
}

/// `under` or `over`.
pub(super) fn direction(cell: &CellGap) -> &'static str {
    if cell.mean_error_mg_dl > 0.0 { "under" } else { "over" }
}
