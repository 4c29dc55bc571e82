//! Ambulatory glucose profile, measured and simulated.

use crate::html::Html;
use crate::{ReportError, figure};
use contract::GlucoseProfile;

pub(super) fn body(agp: &GlucoseProfile) -> Result<Html, ReportError> {
    let mut html = Html::default();
    let name = "Glucose percentiles by time of day, measured and twin";
    let whose = if agp.person_id == "cohort" {
        "all people together".to_owned()
    } else {
        format!("person {}", agp.person_id)
    };
    let caption = format!(
        "Percentiles of glucose by time of day, {whose}. Where the twin's broken lines \
         follow the solid line and the dark band, the twin has the person's day; where they \
         part, it misses at that time of day."
    );
    if !html.figure(figure::agp(name, &agp.hour, &agp.observed, Some(&agp.twin))?, &caption) {
        html.absent("There is no glucose profile in this folder.");
    }
    Ok(html)
}
