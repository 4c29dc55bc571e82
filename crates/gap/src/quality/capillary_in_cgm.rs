//! `capillary_in_cgm`: finger-stick readings in the sensor's column.
//!
//! People prick a finger before they dose, and some sources write what the meter showed where the sensor's
//! readings stand. To a filter that is a jump of glucose and a jump back, at the very steps at which
//! insulin and carbohydrate enter.
//!
//! Where a sensor reads every 15 min and the source drew lines between, a reading of another origin lies
//! between two of the sensor's and off their line ([`SensorCadence::strangers`]): no threshold is needed.
//! Of eight HUPA-UCM people two have 50 each, the others none. Where the sensor reads at every step, such a
//! reading stands out from both neighbours, and so do a sensor's own spikes: these are taken for finger
//! sticks only where they keep company with doses more often than chance.

use std::ops::Range;

use cohort::{Person, Record, SensorCadence};
use stats::proportion::clopper_pearson;

use super::daily_doses::median_with_range;
use super::interleaved_cgm::triples;
use super::{Consequence, Finding};
use crate::filter::whitening::robust_scale;

/// Steps between a finger stick and the dose that it was for: 10 min.
const NEAR_DOSE: usize = 2;
/// Smallest jump from both neighbours that stands out at five minutes, mg/dL: 10 % of usual glucose,
/// the disagreement of meters and sensors (MARD 8 to 10 %).
const SMALLEST_JUMP: f64 = 15.0;
/// The same in robust standard deviations of a value from its neighbours' line.
const SMALLEST_JUMP_SD: f64 = 8.0;
/// Largest step between the two neighbours, over the jump.
const NEIGHBOURS_AGREE: f64 = 0.5;
/// Two-sided level of the interval of the share at doses whose lower end must exceed chance.
const LEVEL: f64 = 0.998;

/// A reading of another origin between two readings of the sensor.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Capillary {
    /// Its step.
    pub(super) step: usize,
    /// Steps strictly between the sensor's readings before and after.
    pub(super) between: Range<usize>,
    /// The sensor's readings before and after, mg/dL.
    ends: (f64, f64),
}

impl Capillary {
    /// What the sensor's line has at a step, mg/dL.
    pub(super) fn line(&self, step: usize) -> f64 {
        let (from, to) = (self.between.start as f64 - 1.0, self.between.end as f64);
        self.ends.0 + (self.ends.1 - self.ends.0) * (step as f64 - from) / (to - from)
    }
}

/// The finger-stick readings of a record, ascending.
pub(super) fn find(record: &Record) -> Vec<Capillary> {
    let values = record.cgm();
    if let Some(cadence) = SensorCadence::find(values).filter(|cadence| cadence.steps > 1) {
        let off_phase = cadence.strangers.iter();
        return off_phase.filter_map(|step| between_readings(values, &cadence, *step)).collect();
    }
    let isolated = isolated(values);
    let (count, chance) = at_doses(record, &isolated);
    let share = clopper_pearson(count, isolated.len(), LEVEL);
    if share.is_ok_and(|share| share.lower > chance) { isolated } else { Vec::new() }
}

fn between_readings(
    values: &[Option<f64>],
    cadence: &SensorCadence,
    step: usize,
) -> Option<Capillary> {
    // A reading that lies on a line by chance is no corner; the sensor's phase tells where it is.
    let next = cadence.readings.partition_point(|reading| *reading < step);
    let known = cadence.readings[..next].last().or_else(|| cadence.readings.get(next))?;
    let after_phase = (step + cadence.steps - known % cadence.steps) % cadence.steps;
    let from = step.checked_sub(after_phase)?;
    let to = from + cadence.steps;
    let ends = (values[from]?, (*values.get(to)?)?);
    Some(Capillary { step, between: from + 1..to, ends })
}

/// Values that jump from both neighbours and back.
fn isolated(values: &[Option<f64>]) -> Vec<Capillary> {
    let triples = triples(values, 1);
    let height = |(_, [a, b, c]): &(usize, [f64; 3])| Some(b - 0.5 * (a + c));
    let heights: Vec<Option<f64>> = triples.iter().map(height).collect();
    let least = SMALLEST_JUMP.max(SMALLEST_JUMP_SD * robust_scale(&heights));
    let standing_out = triples.into_iter().filter(|(_, [a, b, c])| {
        let (from, back) = (b - a, b - c);
        let jump = from.abs().min(back.abs());
        from * back > 0.0 && jump >= least && (c - a).abs() <= NEIGHBOURS_AGREE * jump
    });
    standing_out
        .map(|(k, [a, _, c])| Capillary { step: k + 1, between: k + 1..k + 2, ends: (a, c) })
        .collect()
}

/// How many of the readings keep company with a dose, and which share would by chance.
fn at_doses(record: &Record, readings: &[Capillary]) -> (usize, f64) {
    let dosed = |k: usize| {
        let given = |dose: Option<f64>| dose.is_some_and(|dose| dose > 0.0);
        given(record.bolus()[k]) || given(record.carbs()[k])
    };
    let near =
        |k: usize| (k.saturating_sub(NEAR_DOSE)..(k + NEAR_DOSE + 1).min(record.len())).any(dosed);
    let steps = record.len().max(1) as f64;
    let count = readings.iter().filter(|reading| near(reading.step)).count();
    (count, (0..record.len()).filter(|k| near(*k)).count() as f64 / steps)
}

pub(super) fn finding(person: &Person) -> Option<Finding> {
    let record = &person.record;
    let readings = find(record);
    let off_line = readings.iter().filter_map(|reading| {
        Some((record.cgm()[reading.step]? - reading.line(reading.step)).abs())
    });
    let estimate = median_with_range(off_line.collect())?;
    let (count, chance) = at_doses(record, &readings);
    let text = format!(
        "{} readings stand between the sensor's, {count} of them within {} min of a bolus or a meal (by chance {:.0}): \
         finger-stick readings in the CGM column; the filter does not use them",
        readings.len(),
        5 * NEAR_DOSE,
        chance * readings.len() as f64,
    );
    let found = Finding::new("capillary_in_cgm", person, Consequence::Note, text);
    Some(found.with_estimate(estimate, "mg/dL from the sensor's line"))
}
