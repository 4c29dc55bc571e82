//! `interleaved_cgm`: readings of two sensors, or of a sensor and its smoothed copy, in one column.
//!
//! Glucose moves smoothly: over ten minutes it differs by more than over five. Where readings of two
//! sensors alternate, neighbours differ by the sensors' disagreement, and values two apart
//! agree. Blocks of six hours are judged, since an overlap lasts from hours to days.

use cohort::Person;

use super::{Consequence, Finding};
use crate::diagnosis::FindingEstimate;

/// Length of a block, steps: 6 h.
const BLOCK: usize = 72;
/// Share of a block's triples of neighbours that must be recorded.
const RECORDED: f64 = 0.5;
/// Differences over two steps, squared, over those over one. Smooth glucose has 2 to 4, noise without
/// memory 1, alternation less.
const MOST_RATIO: f64 = 0.8;
/// Smallest disagreement that is reported, mg/dL: noise of a good sensor is a few.
const SMALLEST: f64 = 5.0;
/// Share of the blocks from which the person is left out.
const EXCLUDED: f64 = 0.2;
/// Fewest such blocks.
const FEWEST: usize = 2;

pub(super) fn finding(person: &Person) -> Option<Finding> {
    let cgm = person.record.cgm();
    let mut judged = 0usize;
    let mut disagreements = Vec::new();
    let mut first = None;
    for (block, values) in cgm.chunks_exact(BLOCK).enumerate() {
        let (mut one, mut two, mut sizes, mut count) = (0.0, 0.0, 0.0, 0usize);
        for triple in values.windows(3) {
            let &[Some(a), Some(b), Some(c)] = triple else { continue };
            one += 0.5 * ((b - a).powi(2) + (c - b).powi(2));
            two += (c - a).powi(2);
            // Half the disagreement shows against the middle of the neighbours' line.
            sizes += (b - 0.5 * (a + c)).abs();
            count += 1;
        }
        if (count as f64) < RECORDED * BLOCK as f64 {
            continue;
        }
        judged += 1;
        let size = sizes / count as f64;
        if one > 0.0 && two < MOST_RATIO * one && size > SMALLEST {
            first = first.or(Some(block * BLOCK));
            disagreements.push(size);
        }
    }
    let first = first.filter(|_| disagreements.len() >= FEWEST)?;
    disagreements.sort_by(f64::total_cmp);
    let (count, last) = (disagreements.len(), disagreements.len() - 1);
    let share = count as f64 / judged as f64;
    let hours = count * BLOCK / 12;
    let text = format!(
        "in {hours} h of {}, first on {}, neighbouring readings disagree and every other one agrees: two \
         sensors in one column; keep the readings of one",
        judged * BLOCK / 12,
        person.record.time(first).date()
    );
    let consequence = if share > EXCLUDED { Consequence::ExcludePerson } else { Consequence::Note };
    Some(
        Finding::note("interleaved_cgm", person, text)
            .with_estimate(FindingEstimate {
                value: disagreements[count / 2],
                lower: disagreements[last * 5 / 100],
                upper: disagreements[last * 95 / 100],
                unit: "mg/dL between neighbours".to_owned(),
            })
            .with_consequence(consequence),
    )
}
