//! Estimates with their intervals, a line each, around zero.

use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{WIDTH, draw};
use super::palette::{BLUE, GREY, Key, Marker, VERMILLION, dashed, solid};
use super::panel::{Axis, Panel};
use super::{Drawn, Stroke};
use crate::ReportError;
use crate::view::WithInterval;

/// Height of a row, canvas units.
const ROW: i32 = 52;
/// Longest label that the margin has room for, characters.
const LABEL: usize = 22;

/// One line of the figure.
pub(crate) struct ForestRow {
    /// Its name.
    pub(crate) label: String,
    /// Estimate and interval, in the unit of the figure.
    pub(crate) value: WithInterval,
    /// Whether it stands out from zero.
    pub(crate) stands_out: bool,
}

/// Draws the rows in their order; `unit` is the title of the axis.
pub(crate) fn forest(
    label: &str,
    axis_title: &str,
    rows: &[ForestRow],
) -> Result<Option<Drawn>, ReportError> {
    if rows.is_empty() {
        return Ok(None);
    }
    let longest = rows.iter().map(|row| row.label.chars().count().min(LABEL)).max().unwrap_or(0);
    let ends = rows.iter().flat_map(|row| [row.value.lower, row.value.upper, row.value.value]);
    let height = ROW * i32::try_from(rows.len()).unwrap_or(i32::MAX / ROW);
    let panel = Panel {
        left: 40 + 16 * longest as i32,
        right: WIDTH - 30,
        top: 20,
        bottom: 20 + height,
        x: Axis::over(ends.chain([0.0]), 5),
        y: Axis::bare(0.0, rows.len() as f64),
    };
    let strokes: [Stroke; 2] = [solid(GREY, 4), solid(VERMILLION, 6)];

    let svg = draw(label, panel.bottom + 110, |canvas| {
        panel.frame(canvas, axis_title, "")?;
        let zero = [(0.0, Some(0.0)), (0.0, Some(rows.len() as f64))];
        panel.line(canvas, zero, dashed(BLUE, 3, 8, 8))?;
        for (index, row) in rows.iter().enumerate() {
            let y = rows.len() as f64 - index as f64 - 0.5;
            let [from, to, at] =
                [row.value.lower, row.value.upper, row.value.value].map(|x| panel.at(x, y));
            canvas.text(
                &shortened(&row.label),
                (panel.left - 14, at.1),
                (HPos::Right, VPos::Center),
            )?;
            let stroke = strokes[usize::from(row.stands_out)];
            canvas.path(vec![from, to], stroke)?;
            let marker = if row.stands_out { Marker::Disc } else { Marker::Ring };
            canvas.marker(at, marker, stroke.colour)?;
        }
        Ok(())
    })?;
    let keys = vec![
        Key::marker("Differs from zero", strokes[1], Marker::Disc),
        Key::marker("Cannot be told from zero", strokes[0], Marker::Ring),
    ];
    Ok(Some((svg, keys)))
}

/// The label, or its beginning.
fn shortened(label: &str) -> String {
    if label.chars().count() <= LABEL {
        return label.to_owned();
    }
    label.chars().take(LABEL - 1).chain(['\u{2026}']).collect()
}
