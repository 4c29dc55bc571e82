//! Days of one person, measured and simulated.

use crate::html::Html;
use crate::number::fixed;
use crate::{ReportError, figure};
use contract::ExampleDay;
use contract::example_day::TimeInRanges;

pub(super) fn body(day: &ExampleDay) -> Result<Html, ReportError> {
    let mut html = Html::default();
    if !html.figure(figure::example_day(day)?, &caption(day)) {
        html.absent("There is no example day in this folder.");
    }
    Ok(html)
}

fn caption(day: &ExampleDay) -> String {
    let mut text = format!(
        "Person {}, {}. Above, glucose: compare each broken line, which runs freely from the first \
         reading on, with the solid sensor line. Then boluses and basal insulin, and meals. Below, what \
         the twin knows besides: heart rate and sleep. Gaps are missing data; insulin and meals that nobody recorded count as none.",
        day.person_id, day.date
    );
    if day.days > 1 {
        text.push_str(" Upright lines stand at midnight.");
    }
    let outcomes = &day.outcomes;
    let named = [
        ("sensor", Some(outcomes.cgm)),
        ("digital twin", Some(outcomes.twin)),
        ("closest virtual patient", outcomes.closest),
        ("population network", Some(outcomes.population)),
        ("ODE with population parameters", Some(outcomes.ode)),
    ];
    let shares: Vec<String> = named
        .into_iter()
        .filter_map(|(name, shares)| {
            let TimeInRanges { tbr, tir, tar } = shares?;
            let [tbr, tir, tar] = [tbr, tir, tar].map(|share| fixed(share, 1));
            Some(format!("{name} {tbr}\u{a0}%, {tir}\u{a0}% and {tar}\u{a0}%"))
        })
        .collect();
    text.push_str(&format!(" TBR, TIR and TAR: {}. Chosen: {}.", shares.join("; "), day.chosen));
    text
}
