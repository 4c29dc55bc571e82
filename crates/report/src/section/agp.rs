//! Ambulatory glucose profile, measured and simulated.

use crate::figure;
use crate::html::Html;
use contract::GlucoseProfile;

pub(super) fn body(html: &mut Html, agp: &GlucoseProfile) {
    let name = "Glucose percentiles by time of day, measured and twin";
    let whose = match agp.person_id.as_str() {
        "cohort" => "all people together".to_owned(),
        person => format!("person {person}"),
    };
    let caption = format!(
        "Percentiles of glucose by time of day, {whose}. Where the twin's broken lines \
         follow the solid line and the dark band, the twin has the person's day; where they \
         part, it misses at that time of day."
    );
    if !html.figure(figure::agp(name, &agp.hour, &agp.observed, Some(&agp.twin)), &caption) {
        html.absent("There is no glucose profile in this folder.");
    }
}
