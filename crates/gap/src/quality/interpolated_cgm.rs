//! `interpolated_cgm`: values that the source drew between readings.

use cohort::Person;

use super::Finding;
use crate::filter::observations::{INTERPOLATED_SHARE, Observations};
use contract::diagnosis::FindingEstimate;

pub(super) fn finding(person: &Person, observations: &Observations) -> Option<Finding> {
    let share = observations.interpolated_share;
    (share > INTERPOLATED_SHARE).then(|| {
        let text = "CGM values lie on straight lines between readings; the filter uses the \
                    readings alone";
        Finding::note("interpolated_cgm", person, text).with_estimate(FindingEstimate {
            value: 100.0 * share,
            lower: 100.0 * share,
            upper: 100.0 * share,
            unit: "% of values".to_owned(),
        })
    })
}
