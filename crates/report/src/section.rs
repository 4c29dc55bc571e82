//! The page and its sections, in reading order.

mod agp;
mod any_json;
mod conformance;
mod data_quality;
mod effects;
mod example_day;
mod exclusions;
mod how_far;
mod import;
mod location;
mod outcomes;
mod provenance;
mod training;
mod twins;
mod verdict;
mod words;

use crate::html::Html;
use crate::{DISCLAIMER, Inputs, ReportError};

/// A section: its anchor, its heading, and what writes it.
type Section = (&'static str, &'static str, fn(&Inputs) -> Result<Html, ReportError>);

/// Every section below the verdict.
const SECTIONS: [Section; 12] = [
    ("data-quality", "Data quality", data_quality::body),
    ("where", "Where the gap lies", location::body),
    ("which", "Which effect explains it", effects::body),
    ("how-far", "How far the gap shrinks", how_far::body),
    ("outcomes", "Glucose outcomes", outcomes::body),
    ("agp", "Ambulatory glucose profile", agp::body),
    ("example-day", "An example day", example_day::body),
    ("conformance", "Physiological conformance", conformance::body),
    ("training", "Training of the population network", training::body),
    ("twins", "Digital twins", twins::body),
    ("exclusions", "Who was left out", exclusions::body),
    ("provenance", "How to reproduce this", provenance::body),
];

/// The whole document.
pub(crate) fn page(inputs: &Inputs) -> Result<String, ReportError> {
    let title = verdict::title(inputs);
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
    for (id, heading, _) in SECTIONS {
        html.literal("<li><a href=\"#").literal(id).literal("\">").text(heading);
        html.literal("</a></li>");
    }
    html.literal("</ul>\n</nav>\n");
    for (id, heading, body) in SECTIONS {
        html.push(&Html::section(id, heading, &body(inputs)?));
    }
    html.literal("</main>\n<footer>\n<p class=\"disclaimer\">").text(DISCLAIMER);
    html.literal("</p>\n</footer>\n</body>\n</html>\n");
    Ok(html.into_string())
}
