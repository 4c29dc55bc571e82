//! What the check had to reach, and whether it does.

use super::super::words::{sentence, target as name};
use crate::figure::palette::{BLACK, BLUE, Key, Marker, SHADE, VERMILLION, solid};
use crate::figure::{Axis, Drawn, Panel, WIDTH, draw, shortened};
use crate::html::{Column, Html};
use crate::number::{ends, optional};
use contract::BlindCheck;
use contract::blind_check::{Bound, Target};

/// Height of a row, canvas units.
const ROW: i32 = 60;

pub(in super::super) fn body(html: &mut Html, check: &BlindCheck) {
    html.paragraph(
        "Worlds were made with effects that the diagnosis could not know: a hash of every label was \
         written before the data, the diagnosis saw the data alone, and the labels were opened when \
         all answers were in. A figure that falls short is printed as such.",
    );
    if check.targets.is_empty() {
        html.absent("No target was set.");
        return;
    }
    let verdict = |target: &Target| match target.met {
        Some(true) => "\u{2713}\u{a0}met",
        Some(false) => "\u{2717}\u{a0}missed",
        None => "not\u{a0}tested",
    };
    let limit = |target: &Target| {
        let sign = if target.bound == Bound::AtLeast { '\u{2265}' } else { '\u{2264}' };
        format!("{sign} {}", optional(target.target, 2))
    };
    let measured = |target: &Target| {
        let limits = target.lower.zip(target.upper);
        let ends = limits.map_or_else(String::new, |(lower, upper)| ends(lower, upper, 3));
        format!("{}{ends}", optional(target.value, 3))
    };
    html.marked_rows(
        "Targets; bold: missed",
        &check.targets,
        |target| target.met == Some(false),
        &[
            ("Target", Column::Text, &|target| sentence(&name(&target.name))),
            ("Verdict", Column::Text, &|target| verdict(target).to_owned()),
            ("Limit", Column::Number, &limit),
            ("Measured (95 % interval)", Column::Number, &measured),
            ("Counting sets", Column::Number, &|t| optional(t.value_counting_sets, 3)),
            ("Of", Column::Number, &|target| target.of.to_string()),
            ("What is counted", Column::Text, &|target| sentence(&target.says)),
        ],
    );
    html.paragraph_of(
        "note",
        "Verdicts compare the measured value with its limit. \u{201c}Counting sets\u{201d}: an answer \
         also counts if the truth stands in the set of effects that it says it cannot tell apart.",
    );
    html.figure(
        promised_and_measured(&check.targets),
        "Every target: the mark should lie in the shaded part of its line. An interval that \
         reaches across the limit says that more worlds would be needed to be sure.",
    );
}

/// Draws one line a target, or `None` where none was measured.
fn promised_and_measured(targets: &[Target]) -> Option<Drawn> {
    if targets.iter().all(|target| target.value.is_none()) {
        return None;
    }
    let names: Vec<String> = targets.iter().map(|t| shortened(&name(&t.name))).collect();
    let longest = names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
    let across = (40 + 19 * longest as i32, WIDTH - 50);
    let panel = Panel::rows(across, Axis::over([0.0, 1.0], 5), targets.len(), ROW);
    let (met, missed) = (solid(BLUE, 5), solid(VERMILLION, 5));
    let keys = vec![
        Key::marker("Met, with its 95 % interval", met, Marker::Disc),
        Key::marker("Missed, with its 95 % interval", missed, Marker::Cross),
        Key::area("Where the target is met; the line across it is its limit", SHADE, 1.0),
    ];
    Some(draw("Every target with what was measured", panel.bottom + 110, keys, |canvas| {
        panel.frame(canvas, "Measured (share, F1 or error)", "");
        for (index, (name, target)) in names.iter().zip(targets).enumerate() {
            let y = targets.len() as f64 - index as f64 - 0.5;
            let at = |x: f64| panel.at(x.clamp(0.0, 1.0), y);
            let end = if target.bound == Bound::AtMost { 0.0 } else { 1.0 };
            let ((from, middle), (to, _)) = (at(target.target), at(end));
            let (top, bottom) = (middle - ROW / 3, middle + ROW / 3);
            canvas.rectangle((from.min(to), top), (from.max(to), bottom), SHADE, 1.0);
            canvas.path([(from, top), (from, bottom)], solid(BLACK, 4));
            panel.label(canvas, name, middle);
            let Some(value) = target.value else { continue };
            let (stroke, marker) = match target.met {
                Some(true) => (met, Marker::Disc),
                _ => (missed, Marker::Cross),
            };
            if let (Some(lower), Some(upper)) = (target.lower, target.upper) {
                canvas.path([at(lower), at(upper)], stroke);
            }
            canvas.marker(at(value), marker, stroke.colour);
        }
    }))
}
