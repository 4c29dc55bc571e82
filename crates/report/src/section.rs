//! The page and its sections, in reading order.

mod absorbed;
mod agp;
mod any_json;
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

/// A section of the page.
struct Section {
    /// Its anchor.
    id: &'static str,
    /// Its heading.
    heading: &'static str,
    /// Whether a folder with these inputs has the section.
    applies: fn(&Inputs) -> bool,
    /// What writes it.
    body: fn(&Inputs) -> Result<Html, ReportError>,
}

const fn section(
    id: &'static str,
    heading: &'static str,
    applies: fn(&Inputs) -> bool,
    body: fn(&Inputs) -> Result<Html, ReportError>,
) -> Section {
    Section { id, heading, applies, body }
}

const HAS_DIAGNOSIS: fn(&Inputs) -> bool = |inputs| inputs.diagnosis.is_some();
const HAS_BLIND_CHECK: fn(&Inputs) -> bool = |inputs| inputs.blind_check.is_some();

/// Every section below the verdict.
const SECTIONS: [Section; 26] = [
    section("where", "Where the gap lies", HAS_DIAGNOSIS, location::body),
    section("which", "Which effect explains the gap", HAS_DIAGNOSIS, effects::body),
    section("truth", "Truth beside answer", truth::applies, truth::body),
    section("how-far", "How far the gap shrinks", HAS_DIAGNOSIS, how_far::body),
    section("tried", "What was weighed", HAS_DIAGNOSIS, candidates::body),
    section(
        "absorbed",
        "What the residual networks have absorbed",
        absorbed::applies,
        absorbed::body,
    ),
    section("ports", "At which place in the model", HAS_DIAGNOSIS, ports::body),
    section(
        "data-quality",
        "Data checks by person",
        |i| i.diagnosis.is_some() || i.import_report.is_some() || i.data_in_use.is_some(),
        data_quality::body,
    ),
    section("people", "Every person", |i| i.glucose_by_person.is_some(), people::body),
    section("targets", "Blind check: targets", HAS_BLIND_CHECK, blind_check::targets),
    section("confusion", "Blind check: truth and answer", HAS_BLIND_CHECK, blind_check::confusion),
    section("power", "Blind check: how small an effect is found", HAS_BLIND_CHECK, {
        blind_check::power
    }),
    section("reliability", "Blind check: do probabilities come true", HAS_BLIND_CHECK, {
        blind_check::reliability
    }),
    section("scores", "Blind check: false alarms and other counts", HAS_BLIND_CHECK, {
        blind_check::scores
    }),
    section("worlds", "Blind check: every world", HAS_BLIND_CHECK, blind_check::worlds),
    section("outcomes", "Glucose outcomes", |i| i.outcomes.is_some(), outcomes::body),
    section("agp", "Ambulatory glucose profile", |i| i.agp.is_some(), agp::body),
    section("example-day", "Example days", |i| i.example_day.is_some(), example_day::body),
    section("what-if", "Meals under other doses", what_if::applies, what_if::body),
    section(
        "conformance",
        "Physiological conformance",
        |i| i.conformance.is_some(),
        conformance::body,
    ),
    section(
        "training",
        "Training of the population network",
        |i| i.training.is_some(),
        training::body,
    ),
    section("twins", "Digital twins", |i| i.twins.is_some(), twins::body),
    section(
        "exclusions",
        "Who was left out",
        |i| {
            let takes_people = i.twins.is_some() || i.outcomes.is_some();
            i.data_in_use.is_some() || i.diagnosis.is_some() || takes_people
        },
        exclusions::body,
    ),
    section("next", "What to do next", HAS_DIAGNOSIS, next_steps::body),
    section("glossary", "Glossary", |inputs| !inputs.is_empty(), glossary::body),
    section("provenance", "How to reproduce this", |_| true, provenance::body),
];

/// The answer of a diagnosis as lines of text.
pub(crate) fn answer(
    diagnosis: &contract::Diagnosis,
    truth: Option<&contract::StatedTruth>,
) -> String {
    let beside = truth.map_or_else(String::new, |truth| truth::text(diagnosis, truth));
    format!("{}\n{beside}", verdict::sentence(diagnosis))
}

/// The whole document.
pub(crate) fn page(inputs: &Inputs) -> Result<String, ReportError> {
    let title = verdict::title(inputs);
    let (shown, left_out): (Vec<&Section>, Vec<&Section>) =
        SECTIONS.iter().partition(|section| (section.applies)(inputs));
    let mut html = Html::default();
    html.literal("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
    html.literal("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n");
    html.element("title", &title);
    html.literal("<style>\n").literal(include_str!("style.css")).literal("</style>\n");
    html.literal("</head>\n<body>\n<header>\n");
    html.element("h1", &title);
    html.literal("<p class=\"disclaimer\">").text(DISCLAIMER).literal("</p>\n</header>\n");
    html.literal("<main>\n<section id=\"verdict\">\n").push(&verdict::body(inputs));
    html.literal("</section>\n<nav aria-label=\"Contents\">\n<ul>");
    for Section { id, heading, .. } in &shown {
        html.literal("<li><a href=\"#").literal(id).literal("\">").text(heading);
        html.literal("</a></li>");
    }
    html.literal("</ul>\n</nav>\n");
    for Section { id, heading, body, .. } in &shown {
        html.push(&Html::section(id, heading, &body(inputs)?));
    }
    if !left_out.is_empty() {
        let names: Vec<String> =
            left_out.iter().map(|section| section.heading.to_owned()).collect();
        html.literal("<p class=\"absent\" id=\"left-out\">");
        html.text("This folder holds nothing for: ").text(&names.join("; "));
        html.literal(".</p>\n");
    }
    html.literal("</main>\n<footer>\n<p class=\"disclaimer\">").text(DISCLAIMER);
    html.literal("</p>\n</footer>\n</body>\n</html>\n");
    Ok(html.into_string())
}
