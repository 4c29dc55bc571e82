//! Reading made-up JSON and checking what holds for every page.

use report::{DISCLAIMER, Inputs, Part, render};
use serde_json::Value;

use crate::made_up::completed;

/// Anchors of all sections, in reading order.
pub(crate) const SECTIONS: [&str; 28] = [
    "verdict",
    "where",
    "which",
    "truth",
    "how-far",
    "tried",
    "absorbed",
    "ports",
    "data-quality",
    "people",
    "targets",
    "confusion",
    "power",
    "ceiling",
    "reliability",
    "scores",
    "worlds",
    "outcomes",
    "agp",
    "example-day",
    "what-if",
    "conformance",
    "training",
    "twins",
    "exclusions",
    "next",
    "glossary",
    "provenance",
];

pub(crate) fn read(parts: &[(Part, Value)]) -> Inputs {
    let mut inputs = Inputs::default();
    for (part, value) in parts {
        let value = completed(*part, value.clone());
        inputs.read(*part, value.to_string().as_bytes()).expect("the made-up JSON fits");
    }
    inputs
}

pub(crate) fn page(parts: &[(Part, Value)]) -> String {
    render(&read(parts)).expect("figures can be drawn")
}

/// Replaces the value at `pointer` of one part.
pub(crate) fn with(
    mut parts: Vec<(Part, Value)>,
    part: Part,
    pointer: &str,
    value: Value,
) -> Vec<(Part, Value)> {
    let (_, json) = parts.iter_mut().find(|(p, _)| *p == part).expect("a part of the made-up run");
    *json.pointer_mut(pointer).expect("a place in the made-up run") = value;
    parts
}

/// Checks what holds for every page: sections in order, balanced tags, no address, no script, no
/// "NaN", the disclaimer.
pub(crate) fn check_structure(html: &str) {
    assert!(html.starts_with("<!DOCTYPE html>\n<html lang=\"en\">"));
    let places: Vec<usize> =
        SECTIONS.iter().filter_map(|id| html.find(&format!("<section id=\"{id}\">"))).collect();
    assert!(places.is_sorted() && places.len() == html.matches("<section").count(), "{places:?}");
    assert!(html.contains(DISCLAIMER));

    let mut open: Vec<String> = Vec::new();
    for tag in html.split('<').skip(1) {
        let (tag, _) = tag.split_once('>').expect("every tag is closed by >");
        let name: String =
            tag.trim_start_matches('/').chars().take_while(char::is_ascii_alphanumeric).collect();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "closing tag without its opening one");
        } else if !tag.starts_with('!') && !tag.ends_with('/') && name != "meta" {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "left open: {open:?}");

    for (index, _) in html.match_indices("http") {
        assert!(
            html[index..].starts_with("http://www.w3.org/2000/svg\""),
            "an address in the page"
        );
    }
    for forbidden in ["NaN", "inf ", "null", "<script", "<link", "@import", "url(", "src="] {
        assert!(!html.contains(forbidden), "'{forbidden}' in the page");
    }
}

/// The text of a section.
pub(crate) fn section<'a>(html: &'a str, id: &str) -> &'a str {
    let (_, from) = html.split_once(&format!("<section id=\"{id}\">")).expect("the section");
    from.split_once("</section>").expect("its end").0
}
