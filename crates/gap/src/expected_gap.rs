//! Where the missing effect is expected to move glucose, from the posterior.

use std::collections::BTreeMap;

use posterior::Gap;

use crate::context::{HOURS_OF_PART, PARTS, hours_of_part};
use contract::diagnosis::{CellFactor, CellGap};

/// Length of the runs whose gap is expected, min: whole days from midnight.
const MINUTES: u32 = 1440;

/// Gives each cell its share of the expected gap and its mean, and puts the largest first.
///
/// The share is that of the cell's squared size among those of all hours, contexts and glucose bands. Of people and horizons
/// nothing is expected: their share is 0, and they come last.
pub(crate) fn share_out(cells: &mut [CellGap], gaps: &BTreeMap<String, Gap>) {
    let size = |cell: &CellGap| expected(cell, gaps, |gap| gap.size).unwrap_or(0.0);
    let sizes: Vec<f64> = cells.iter().map(size).collect();
    let all: f64 = sizes.iter().map(|size| size * size).sum();
    for (cell, size) in cells.iter_mut().zip(&sizes) {
        cell.share_of_gap = if all > 0.0 { size * size / all } else { 0.0 };
        cell.expected_mg_dl = expected(cell, gaps, |gap| gap.mean);
    }
    cells.sort_by(|a, b| b.share_of_gap.total_cmp(&a.share_of_gap));
}

/// What is expected of the gap in a cell, mg/dL.
fn expected(
    cell: &CellGap,
    gaps: &BTreeMap<String, Gap>,
    what: impl Fn(&Gap) -> f64,
) -> Option<f64> {
    let of =
        |factor: &str, level: &str| gaps.get(&format!("{MINUTES}/{factor}/{level}")).map(&what);
    match cell.factor {
        CellFactor::Hour => {
            let part = (0..PARTS).find(|part| hours_of_part(*part) == cell.level)?;
            let hours: Vec<f64> = (HOURS_OF_PART * part..HOURS_OF_PART * (part + 1))
                .filter_map(|hour| of("hour", &format!("{hour:02}")))
                .collect();
            (!hours.is_empty()).then(|| hours.iter().sum::<f64>() / hours.len() as f64)
        }
        CellFactor::Context => of("context", &cell.level),
        CellFactor::GlucoseBand => of("glucose_band", &cell.level),
        CellFactor::Person | CellFactor::Horizon => None,
    }
}
