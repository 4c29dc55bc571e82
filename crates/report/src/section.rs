//! The page and its sections, in reading order.

mod absorbed;
mod agp;
mod blind_check;
mod candidates;
mod conformance;
mod data_quality;
mod effects;
mod example_day;
mod exclusions;
mod glossary;
mod how_far;
mod import;
mod location;
mod next_steps;
mod outcomes;
mod people;
mod ports;
mod provenance;
mod shown_path;
mod training;
mod truth;
mod twins;
mod verdict;
mod what_if;
mod words;

use crate::html::Html;
use crate::{DISCLAIMER, Inputs, ReportError};

/// A section: its anchor, its heading, and what writes it where the folder holds something for it.
type Section = (&'static str, &'static str, fn(&Inputs) -> Option<Result<Html, ReportError>>);

/// Every section below the verdict.
const SECTIONS: [Section; 27] = [
    ("where", "Where the gap lies", |i| i.diagnosis.as_ref().map(location::body)),
    ("which", "Which effect explains the gap", |i| i.diagnosis.as_ref().map(effects::body)),
    ("truth", "Truth beside answer", |i| {
        Some(truth::body(i.diagnosis.as_ref()?, i.truth.as_ref()?))
    }),
    ("how-far", "How far the gap shrinks", |i| i.diagnosis.as_ref().map(how_far::body)),
    ("tried", candidates::HEADING, |i| i.diagnosis.as_ref().map(candidates::body)),
    ("absorbed", "What the residual networks have absorbed", |i| {
        i.diagnosis.as_ref()?.absorbed.as_ref().map(absorbed::body)
    }),
    ("ports", "At which place in the model", |i| i.diagnosis.as_ref().map(ports::body)),
    ("data-quality", "Data checks by person", |i| {
        let told = i.diagnosis.is_some() || i.import_report.is_some() || i.data_in_use.is_some();
        told.then(|| data_quality::body(i))
    }),
    ("people", "Every person", |i| Some(people::body(i.glucose_by_person.as_ref()?, i))),
    ("targets", "Blind check: targets", |i| i.blind_check.as_ref().map(blind_check::targets)),
    ("confusion", "Blind check: truth and answer", |i| {
        i.blind_check.as_ref().map(blind_check::confusion)
    }),
    ("power", "Blind check: how small an effect is found", |i| {
        i.blind_check.as_ref().map(blind_check::power)
    }),
    ("ceiling", "Blind check: what exact courses would name", |i| {
        i.blind_check.as_ref()?.ceiling.as_ref().map(blind_check::ceiling)
    }),
    ("reliability", "Blind check: do probabilities come true", |i| {
        i.blind_check.as_ref().map(blind_check::reliability)
    }),
    ("scores", "Blind check: false alarms and other counts", |i| {
        i.blind_check.as_ref().map(blind_check::scores)
    }),
    ("worlds", "Blind check: every world", |i| {
        Some(blind_check::worlds(i.blind_check.as_ref()?, i.seal.as_ref()))
    }),
    ("outcomes", "Glucose outcomes", |i| i.outcomes.as_ref().map(outcomes::body)),
    ("agp", "Ambulatory glucose profile", |i| i.agp.as_ref().map(agp::body)),
    ("example-day", "Example days", |i| i.example_day.as_ref().map(example_day::body)),
    ("what-if", "Meals under other doses", |i| {
        let told = i.what_if.is_some() || i.what_if_constrained.is_some();
        told.then(|| what_if::body(i))
    }),
    ("conformance", "Physiological conformance", |i| i.conformance.as_ref().map(conformance::body)),
    ("training", "Training of the population network", |i| i.training.as_ref().map(training::body)),
    ("twins", "Digital twins", |i| i.twins.as_ref().map(twins::body)),
    ("exclusions", "Who was left out", |i| {
        let judged = i.outcomes.is_some() || i.exclusions.is_some();
        let takes_people = i.twins.is_some() || judged;
        let told = i.data_in_use.is_some() || i.diagnosis.is_some() || takes_people;
        told.then(|| exclusions::body(i))
    }),
    ("next", "What to do next", |i| {
        Some(next_steps::body(i.diagnosis.as_ref()?, i.data_in_use.as_ref()))
    }),
    ("glossary", "Glossary", |i| (!i.is_empty()).then(glossary::body)),
    ("provenance", "How to reproduce this", |i| Some(provenance::body(&i.manifests))),
];

/// The answer of a diagnosis as lines of text: the sentence of the report, and what the makers of the
/// cohort state beside what was found.
#[must_use]
pub fn answer(diagnosis: &contract::Diagnosis, truth: Option<&contract::StatedTruth>) -> String {
    let beside = truth.map_or_else(String::new, |truth| truth::text(diagnosis, truth));
    format!("{}\n{beside}", verdict::sentence(diagnosis))
}

/// Renders the report as one HTML document.
///
/// # Errors
///
/// [`ReportError::Figure`] where a figure cannot be drawn.
pub fn render(inputs: &Inputs) -> Result<String, ReportError> {
    let title = verdict::title(inputs);
    let mut shown: Vec<(&'static str, &'static str, Html)> = Vec::new();
    let mut left_out: Vec<&'static str> = Vec::new();
    for (id, heading, body) in SECTIONS {
        match body(inputs) {
            Some(body) => shown.push((id, heading, body?)),
            None => left_out.push(heading),
        }
    }
    let mut html = Html::default();
    html.literal("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
    html.literal("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n");
    html.element("title", &title);
    html.literal("<style>\n").literal(include_str!("style.css")).literal("</style>\n");
    html.literal("</head>\n<body>\n<header>\n");
    html.element("h1", &title);
    html.paragraph_of("disclaimer", DISCLAIMER).literal("</header>\n");
    html.literal("<main>\n<section id=\"verdict\">\n").push(&verdict::body(inputs));
    html.literal("</section>\n<nav aria-label=\"Contents\">\n<ul>");
    for &(id, heading, _) in &shown {
        html.literal("<li><a href=\"#").literal(id).literal("\">").text(heading);
        html.literal("</a></li>");
    }
    html.literal("</ul>\n</nav>\n");
    for (id, heading, body) in shown {
        html.push(&Html::section(id, heading, &body));
    }
    if !left_out.is_empty() {
        html.literal("<p class=\"absent\" id=\"left-out\">");
        html.text("This folder holds nothing for: ").text(&left_out.join("; "));
        html.literal(".</p>\n");
    }
    html.literal("</main>\n<footer>\n").paragraph_of("disclaimer", DISCLAIMER);
    html.literal("</footer>\n</body>\n</html>\n");
    Ok(html.into_string())
}
