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

/// The sections, in reading order.
#[derive(Default)]
struct Sections {
    /// A link to each that the folder holds something for.
    contents: Html,
    /// Those.
    shown: Html,
    /// The headings of the others.
    left_out: Vec<&'static str>,
}

impl Sections {
    /// Adds the section on `part`, where there is one; `id` is its anchor, `body` writes it.
    fn add<T>(
        &mut self,
        id: &'static str,
        heading: &'static str,
        part: Option<T>,
        body: impl FnOnce(&mut Html, T),
    ) {
        let Some(part) = part else {
            self.left_out.push(heading);
            return;
        };
        self.contents.literal("<li><a href=\"#").literal(id).literal("\">").text(heading);
        self.contents.literal("</a></li>");
        self.shown.literal("<section id=\"").literal(id).literal("\">\n").element("h2", heading);
        body(&mut self.shown, part);
        self.shown.literal("</section>\n");
    }
}

/// Every section below the verdict.
fn sections(inputs: &Inputs) -> Sections {
    let (diagnosis, check) = (inputs.diagnosis.as_ref(), inputs.blind_check.as_ref());
    let absorbed = diagnosis.and_then(|diagnosis| diagnosis.absorbed.as_ref());
    let checked =
        diagnosis.is_some() || inputs.import_report.is_some() || inputs.data_in_use.is_some();
    let judged = inputs.outcomes.is_some() || inputs.exclusions.is_some();
    let used = inputs.data_in_use.is_some() || diagnosis.is_some() || inputs.twins.is_some();
    let asked = inputs.what_if.is_some() || inputs.what_if_constrained.is_some();

    let mut all = Sections::default();
    all.add("where", "Where the gap lies", diagnosis, location::body);
    all.add("which", "Which effect explains the gap", diagnosis, effects::body);
    all.add("truth", "Truth beside answer", diagnosis.zip(inputs.truth.as_ref()), truth::body);
    all.add("how-far", "How far the gap shrinks", diagnosis, how_far::body);
    all.add("tried", candidates::HEADING, diagnosis, candidates::body);
    all.add("absorbed", "What the residual networks have absorbed", absorbed, absorbed::body);
    all.add("ports", "At which place in the model", diagnosis, ports::body);
    all.add("data-quality", "Data checks by person", checked.then_some(inputs), data_quality::body);
    let glucose = inputs.glucose_by_person.as_ref().map(|glucose| (glucose, inputs));
    all.add("people", "Every person", glucose, people::body);
    all.add("targets", "Blind check: targets", check, blind_check::targets::body);
    all.add("confusion", "Blind check: truth and answer", check, blind_check::confusion::body);
    all.add("power", "Blind check: how small an effect is found", check, blind_check::power::body);
    let ceiling = check.and_then(|check| check.ceiling.as_ref());
    let heading = "Blind check: what exact courses would name";
    all.add("ceiling", heading, ceiling, blind_check::ceiling::body);
    let heading = "Blind check: do probabilities come true";
    all.add("reliability", heading, check, blind_check::reliability::body);
    let heading = "Blind check: false alarms and other counts";
    all.add("scores", heading, check, blind_check::scores::body);
    let worlds = check.map(|check| (check, inputs.seal.as_ref()));
    all.add("worlds", "Blind check: every world", worlds, blind_check::worlds::body);
    all.add("outcomes", "Glucose outcomes", inputs.outcomes.as_ref(), outcomes::body);
    all.add("agp", "Ambulatory glucose profile", inputs.agp.as_ref(), agp::body);
    all.add("example-day", "Example days", inputs.example_day.as_ref(), example_day::body);
    all.add("what-if", "Meals under other doses", asked.then_some(inputs), what_if::body);
    let conformance = inputs.conformance.as_ref();
    all.add("conformance", "Physiological conformance", conformance, conformance::body);
    let training = inputs.training.as_ref();
    all.add("training", "Training of the population network", training, training::body);
    all.add("twins", "Digital twins", inputs.twins.as_ref(), twins::body);
    all.add("exclusions", "Who was left out", (used || judged).then_some(inputs), exclusions::body);
    let next = diagnosis.map(|diagnosis| (diagnosis, inputs.data_in_use.as_ref()));
    all.add("next", "What to do next", next, next_steps::body);
    let words = (!inputs.is_empty()).then_some(());
    all.add("glossary", "Glossary", words, |html, ()| glossary::body(html));
    all.add("provenance", "How to reproduce this", Some(&inputs.manifests[..]), provenance::body);
    all
}

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
/// None so far: what cannot be used is found where it is read.
pub fn render(inputs: &Inputs) -> Result<String, ReportError> {
    let title = verdict::title(inputs);
    let Sections { contents, shown, left_out } = sections(inputs);
    let mut html = Html::default();
    html.literal("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
    html.literal("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n");
    html.element("title", &title);
    html.literal("<style>\n").literal(include_str!("style.css")).literal("</style>\n");
    html.literal("</head>\n<body>\n<header>\n");
    html.element("h1", &title);
    html.paragraph_of("disclaimer", DISCLAIMER).literal("</header>\n");
    html.literal("<main>\n<section id=\"verdict\">\n");
    verdict::body(&mut html, inputs);
    html.literal("</section>\n<nav aria-label=\"Contents\">\n<ul>").push(&contents);
    html.literal("</ul>\n</nav>\n").push(&shown);
    if !left_out.is_empty() {
        html.literal("<p class=\"absent\" id=\"left-out\">");
        html.text("This folder holds nothing for: ").text(&left_out.join("; "));
        html.literal(".</p>\n");
    }
    html.literal("</main>\n<footer>\n").paragraph_of("disclaimer", DISCLAIMER);
    html.literal("</footer>\n</body>\n</html>\n");
    Ok(html.into_string())
}
