//! `discontinuous_cgm`: readings that have nothing to do with the ones beside them.
//!
//! A sensor's reading is its last reading and a little more. Where rows were shuffled, or times lost, the
//! correlation of neighbours is gone. How large it is at least follows from the fastest course that glucose takes: that
//! after a meal, whose absorption has the time constant t_max,G. Two sensors that alternate also break it, but not
//! over two readings; they are left to `interleaved_cgm`.

use cohort::{Person, SensorCadence};
use ode_sim::OdeParameters;
use ode_sim::personal::Factor;
use physiology::STEP;

use super::{Consequence, Finding};
use crate::filter::noise::NoiseModel;

/// Standard deviations of people by which the fastest gut is faster than the population's.
const FASTEST: f64 = 2.0;
/// Fewest pairs of readings that are judged: a day of a sensor that reads every 15 min.
const FEWEST: usize = 96;

pub(super) fn finding(person: &Person) -> Option<Finding> {
    let cgm = person.record.cgm();
    let apart = SensorCadence::find(cgm).map_or(1, |cadence| cadence.steps);
    let (found, least) = broken(cgm, apart)?;
    broken(cgm, 2 * apart)?;
    let text = format!(
        "neighbouring readings have little to do with each other (glucose has a correlation of {least:.2} or \
         more): rows or times are mixed up"
    );
    let finding = Finding::new("discontinuous_cgm", person, Consequence::ExcludePerson, text);
    Some(finding.with_estimate((found, found, found), "correlation of neighbours"))
}

/// The correlation of readings some steps apart, and the least that glucose and a sensor's error leave, where the
/// correlation is below that.
///
/// Reference people have 0.96 and more at their sensors' cadence, where the least is 0.5 to 0.8; shuffled within days
/// their largest is 0.17. `None` also where there are too few, or where they do not vary: `flat_cgm` tells of that.
fn broken(cgm: &[Option<f64>], apart: usize) -> Option<(f64, f64)> {
    let later = cgm.get(apart..)?;
    let pairs: Vec<(f64, f64)> = cgm.iter().zip(later).filter_map(|(a, b)| (*a).zip(*b)).collect();
    if pairs.len() < FEWEST {
        return None;
    }
    let count = pairs.len() as f64;
    let mean = pairs.iter().map(|(a, b)| 0.5 * (a + b)).sum::<f64>() / count;
    let spread: f64 = pairs.iter().map(|(a, b)| (a - mean).powi(2) + (b - mean).powi(2)).sum();
    let steps: f64 = pairs.iter().map(|(a, b)| (b - a).powi(2)).sum();
    let gut = OdeParameters::nominal().t_max_g * (-FASTEST * Factor::TMaxG.prior_sd()).exp();
    let of_glucose = (-(apart as f64) * STEP.0 / gut).exp();
    let error = NoiseModel::working().sensor_sd.powi(2) / (0.5 * spread / count);
    let (correlation, least) = (1.0 - steps / spread, of_glucose * (1.0 - error).max(0.0));
    (spread > 0.0 && correlation < least).then_some((correlation, least))
}
