//! `interpolated_cgm`: values that the source drew between readings.
//!
//! A line between two readings of one sensor stands for glucose; a longer one fills a gap. A person whose column
//! is mostly such lines was not measured.

use cohort::{Person, StraightLines};

use super::{Consequence, Finding};
use crate::config::InclusionRule;
use crate::filter::observations::{INTERPOLATED_SHARE, LONGEST_INTERPOLATION, Observations};
use contract::diagnosis::FindingEstimate;

pub(super) fn finding(person: &Person, observations: &Observations) -> Option<Finding> {
    let share = observations.interpolated_share;
    if share <= INTERPOLATED_SHARE {
        return None;
    }
    let recorded = person.record.cgm().iter().flatten().count() as f64 / observations.len() as f64;
    let least = InclusionRule::working().least_cgm_share;
    let drawn = Finding::note("interpolated_cgm", person, "").with_estimate(FindingEstimate {
        value: 100.0 * share,
        lower: 100.0 * share,
        upper: 100.0 * share,
        unit: "% of values".to_owned(),
    });
    let coverage = observations.coverage();
    let lines = StraightLines::find(person.record.cgm());
    let filled = lines.values_in_lines_of(LONGEST_INTERPOLATION + 1) > 0;
    Some(if filled && recorded >= least && coverage < least {
        drawn
            .saying(format!(
                "{:.0} % of the CGM values lie on straight lines, and without those of more than {} min \
                 readings cover {:.0} % of the steps, less than {:.0} %",
                100.0 * share,
                5 * LONGEST_INTERPOLATION,
                100.0 * coverage,
                100.0 * least
            ))
            .with_consequence(Consequence::ExcludePerson)
    } else {
        drawn.saying(
            "CGM values lie on straight lines between readings; the filter uses the readings alone",
        )
    })
}
