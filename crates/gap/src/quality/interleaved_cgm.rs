//! `interleaved_cgm`: readings of two sensors, or of a sensor and its smoothed copy, in one column.
//!
//! Glucose moves smoothly: over two readings it differs by more than over one. Where readings of two
//! sensors alternate, neighbours differ by the sensors' disagreement, and values two apart
//! agree. Blocks of six hours are judged, since an overlap lasts from hours to days, and readings at the
//! sensor's own cadence, since lines that a source drew over 15 min are smooth whatever was read.
//!
//! Which of the two streams is right, the column does not say. The filter therefore uses neither: these
//! hours count as not recorded. A person who has many of them is left out.

use std::ops::Range;

use cohort::{Person, SensorCadence};

use super::daily_doses::median_with_range;
use super::{Consequence, Finding};

/// Length of a block, steps: 6 h.
const BLOCK: usize = 72;
/// Share of a block's triples of neighbours that must be recorded.
const RECORDED: f64 = 0.5;
/// Differences over two readings, squared, over those over one. Smooth glucose has 2 to 4, noise without
/// memory 1, alternation less. Over every block of the reference people that is rough enough the least is
/// 1.13 (readings of 15 min) and 1.95 (of 5 min).
const MOST_RATIO: f64 = 0.8;
/// Smallest disagreement that is reported, mg/dL: noise of a good sensor is a few.
const SMALLEST: f64 = 5.0;
/// Share of the blocks from which the person is left out.
const EXCLUDED: f64 = 0.2;
/// Fewest such blocks.
const FEWEST: usize = 2;

/// The blocks of a column in which readings alternate.
pub(super) struct Interleaved {
    /// Blocks with enough readings.
    judged: usize,
    /// Steps of each block in which readings alternate.
    pub(super) blocks: Vec<Range<usize>>,
    /// Their mean disagreements between neighbours, mg/dL.
    disagreements: Vec<f64>,
}

impl Interleaved {
    /// Judges a column of one value a step; `None` below two such blocks.
    pub(super) fn find(cgm: &[Option<f64>]) -> Option<Self> {
        let apart = SensorCadence::find(cgm).map_or(1, |cadence| cadence.steps);
        let mut found = Self { judged: 0, blocks: Vec::new(), disagreements: Vec::new() };
        for start in (0..cgm.len()).step_by(BLOCK).filter(|start| start + BLOCK <= cgm.len()) {
            let phases = (0..apart).map(|phase| triples(&cgm[start + phase..start + BLOCK], apart));
            // The sensor's own phase: on the others lie values drawn between its readings, whose
            // second differences are smaller.
            let roughest = phases.max_by(|a, b| roughness(a).total_cmp(&roughness(b)));
            let triples = roughest.unwrap_or_default();
            if (triples.len() as f64) < RECORDED * (BLOCK / apart) as f64 {
                continue;
            }
            found.judged += 1;
            let (mut one, mut two) = (0.0, 0.0);
            for (_, [a, b, c]) in &triples {
                one += 0.5 * ((b - a).powi(2) + (c - b).powi(2));
                two += (c - a).powi(2);
            }
            let size = roughness(&triples) / triples.len() as f64;
            if one > 0.0 && two < MOST_RATIO * one && size > SMALLEST {
                found.blocks.push(start..start + BLOCK);
                found.disagreements.push(size);
            }
        }
        (found.blocks.len() >= FEWEST).then_some(found)
    }
}

/// Recorded values `apart` steps from each other, three at a time, with the step of the first.
pub(super) fn triples(values: &[Option<f64>], apart: usize) -> Vec<(usize, [f64; 3])> {
    let spans = values.windows(2 * apart + 1).enumerate().step_by(apart);
    spans.filter_map(|(k, v)| Some((k, [v[0]?, v[apart]?, v[2 * apart]?]))).collect()
}

/// Sum of the distances of the middle values from their neighbours' line, mg/dL: half of a disagreement
/// of two alternating sensors is above it and half below, so that the whole of it shows.
fn roughness(triples: &[(usize, [f64; 3])]) -> f64 {
    triples.iter().map(|(_, [a, b, c])| (b - 0.5 * (a + c)).abs()).sum()
}

pub(super) fn finding(person: &Person) -> Option<Finding> {
    let Interleaved { judged, blocks, disagreements } = Interleaved::find(person.record.cgm())?;
    let text = format!(
        "in {} h of {}, first on {}, neighbouring readings disagree and every other one agrees: two \
         sensors in one column; the filter uses none of these hours; keep the readings of one sensor",
        blocks.len() * BLOCK / 12,
        judged * BLOCK / 12,
        person.record.time(blocks[0].start).date()
    );
    let share = blocks.len() as f64 / judged as f64;
    let consequence = if share > EXCLUDED { Consequence::ExcludePerson } else { Consequence::Note };
    let found = Finding::new("interleaved_cgm", person, consequence, text);
    Some(found.with_estimate(median_with_range(disagreements)?, "mg/dL between neighbours"))
}
