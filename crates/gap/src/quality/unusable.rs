//! Readings that a filter must not be fed.

use cohort::Record;
use physiology::MgPerDl;

use super::capillary_in_cgm;
use super::interleaved_cgm::Interleaved;

/// The steps whose CGM value a filter must not be fed, with what stands there instead: `None` where
/// two sensors alternate, the line between the sensor's readings where a finger stick stands.
pub(crate) fn unusable(record: &Record) -> Vec<(usize, Option<MgPerDl>)> {
    let alternating = Interleaved::find(record.cgm());
    let hours = alternating.into_iter().flat_map(|found| found.blocks).flatten();
    let sticks = capillary_in_cgm::find(record);
    let lines = sticks.iter().flat_map(|stick| {
        let between = stick.between.clone();
        between.map(move |step| (step, Some(MgPerDl(stick.line(step)))))
    });
    lines.chain(hours.map(|step| (step, None))).collect()
}
