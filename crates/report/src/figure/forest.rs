//! Estimates with their intervals, one line each, around zero or another reference.

use contract::WithInterval;

use super::palette::{BLUE, GREEN, GREY, Key, Marker, Stroke, VERMILLION, dashed, solid};
use super::{Axis, Drawn, Panel, WIDTH, draw};
use crate::number::interval;

/// Height of a row, canvas units.
const ROW: i32 = 52;
/// Longest label that fits in the margin, characters.
const LABEL: usize = 22;

/// One line of the figure.
pub(crate) struct ForestRow {
    /// Its name.
    pub(crate) label: String,
    /// Estimate and interval, in the unit of the figure.
    pub(crate) value: WithInterval,
    /// Whether it differs clearly from zero.
    pub(crate) stands_out: bool,
}

/// The reference of the rows of a figure.
pub(crate) struct ForestFrame<'a> {
    /// Name of the figure.
    pub(crate) label: &'a str,
    /// Title of the axis, with its unit.
    pub(crate) axis: &'a str,
    /// The unit, as it stands behind a number.
    pub(crate) unit: &'a str,
    /// References for comparison; rows stand out from the first.
    pub(crate) references: &'a [(f64, &'a str)],
    /// Key for rows that stand out and for those that do not.
    pub(crate) keys: [&'a str; 2],
}

impl<'a> ForestFrame<'a> {
    /// Differences around zero, mg/dL.
    pub(crate) const fn around_zero(label: &'a str, axis: &'a str) -> Self {
        let keys = ["Differs from zero", "May be zero"];
        Self { label, axis, unit: "mg/dL", references: &[(0.0, "")], keys }
    }
}

/// Dashes of the references, in their order.
const REFERENCES: [Stroke; 2] = [dashed(BLUE, 3, 8, 8), dashed(GREEN, 4, 20, 8)];

/// Draws the rows in their order, or `None` without one.
pub(crate) fn forest(frame: &ForestFrame<'_>, rows: &[ForestRow]) -> Option<Drawn> {
    let longest = rows.iter().map(|row| row.label.chars().count().min(LABEL)).max()?;
    let ends = rows.iter().flat_map(|row| [row.value.lower, row.value.upper, row.value.value]);
    let places = || frame.references.iter().map(|(place, _)| *place);
    let across = (40 + 18 * longest as i32, WIDTH - 30);
    let panel = Panel::rows(across, Axis::over(ends.chain(places()), 5), rows.len(), ROW);
    let strokes: [Stroke; 2] = [solid(GREY, 4), solid(VERMILLION, 6)];

    let mut keys = vec![
        Key::marker(frame.keys[0], strokes[1], Marker::Disc),
        Key::marker(frame.keys[1], strokes[0], Marker::Ring),
    ];
    let named = frame.references.iter().zip(REFERENCES).filter(|((_, name), _)| !name.is_empty());
    keys.extend(named.map(|((_, name), stroke)| Key::line(name, stroke)));
    Some(draw(frame.label, panel.bottom + 110, keys, |canvas| {
        panel.frame(canvas, frame.axis, "");
        for (place, stroke) in places().zip(REFERENCES) {
            let (x, _) = panel.at(place, 0.0);
            canvas.path([(x, panel.bottom), (x, panel.top)], stroke);
        }
        for (index, row) in rows.iter().enumerate() {
            let y = rows.len() as f64 - index as f64 - 0.5;
            let [from, to, at] =
                [row.value.lower, row.value.upper, row.value.value].map(|x| panel.at(x, y));
            panel.label(canvas, &shortened(&row.label), at.1);
            let stroke = strokes[usize::from(row.stands_out)];
            canvas.path([from, to], stroke);
            let marker = if row.stands_out { Marker::Disc } else { Marker::Ring };
            canvas.marker(at, marker, stroke.colour);
            let words = format!("{}: {} {}", row.label, interval(row.value, 2), frame.unit);
            canvas.hover((0, at.1 - ROW / 2), (WIDTH, at.1 + ROW / 2), &words);
        }
    }))
}

/// The label, or its beginning.
pub(crate) fn shortened(label: &str) -> String {
    if label.chars().count() <= LABEL {
        return label.to_owned();
    }
    label.chars().take(LABEL - 1).chain(['\u{2026}']).collect()
}
