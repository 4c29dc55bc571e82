//! `interpolated_cgm`: values that the source drew between readings.
//!
//! A line between two readings of one sensor stands for glucose; a longer one fills a gap. A person whose column
//! is mostly such lines was not measured.

use cohort::{Person, StraightLines};

use super::{Consequence, Finding};
use crate::filter::observations::{INTERPOLATED_SHARE, LONGEST_INTERPOLATION, Observations};

/// `least` is the smallest share of steps that readings must cover.
pub(super) fn finding(person: &Person, observations: &Observations, least: f64) -> Option<Finding> {
    let share = observations.interpolated_share;
    if share <= INTERPOLATED_SHARE {
        return None;
    }
    let recorded = person.record.cgm().iter().flatten().count() as f64 / observations.len() as f64;
    let coverage = observations.coverage();
    let lines = StraightLines::find(person.record.cgm());
    let filled = lines.values_in_lines_of(LONGEST_INTERPOLATION + 1) > 0;
    let share = 100.0 * share;
    let (text, consequence) = if filled && recorded >= least && coverage < least {
        let text = format!(
            "{share:.0} % of the CGM values lie on straight lines, and without those of more than {} min \
             readings cover {:.0} % of the steps, less than {:.0} %",
            5 * LONGEST_INTERPOLATION,
            100.0 * coverage,
            100.0 * least
        );
        (text, Consequence::ExcludePerson)
    } else {
        let text = "CGM values lie on straight lines between readings; the filter uses the \
                    readings alone";
        (text.to_owned(), Consequence::Note)
    };
    let found = Finding::new("interpolated_cgm", person, consequence, text);
    Some(found.with_estimate((share, share, share), "% of values"))
}
