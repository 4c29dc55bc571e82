//! `discontinuous_cgm`: readings that have nothing to do with the ones beside them.
//!
//! A sensor's reading is its last reading and a little more. Where rows were shuffled, or times lost, the
//! correlation of neighbours is gone.

use cohort::{Person, SensorCadence};

use super::{Consequence, Finding};
use contract::diagnosis::FindingEstimate;

/// Correlation of neighbouring readings below which there is no continuity. The least of the reference people
/// is 0.96; shuffled within days their largest is 0.17.
const LEAST: f64 = 0.6;
/// Fewest pairs of readings that are judged: a day of a sensor that reads every 15 min.
const FEWEST: usize = 96;

pub(super) fn finding(person: &Person) -> Option<Finding> {
    let cgm = person.record.cgm();
    let apart = SensorCadence::find(cgm).map_or(1, |cadence| cadence.steps);
    let pairs: Vec<(f64, f64)> =
        cgm.iter().zip(&cgm[apart.min(cgm.len())..]).filter_map(|(a, b)| (*a).zip(*b)).collect();
    if pairs.len() < FEWEST {
        return None;
    }
    let count = pairs.len() as f64;
    let mean = pairs.iter().map(|(a, b)| 0.5 * (a + b)).sum::<f64>() / count;
    let spread: f64 = pairs.iter().map(|(a, b)| (a - mean).powi(2) + (b - mean).powi(2)).sum();
    let steps: f64 = pairs.iter().map(|(a, b)| (b - a).powi(2)).sum();
    let correlation = 1.0 - steps / spread;
    // A column without spread has no correlation; `flat_cgm` tells of it.
    (spread > 0.0 && correlation < LEAST).then(|| {
        let text =
            "neighbouring readings have little to do with each other: rows or times are mixed up";
        Finding::note("discontinuous_cgm", person, text)
            .with_estimate(FindingEstimate {
                value: correlation,
                lower: correlation,
                upper: correlation,
                unit: "correlation of neighbours".to_owned(),
            })
            .with_consequence(Consequence::ExcludePerson)
    })
}
