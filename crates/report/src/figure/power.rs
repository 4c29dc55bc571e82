//! How often an effect is found, by the shift of glucose that it causes.

use super::Drawn;
use super::canvas::{Canvas, WIDTH, draw};
use super::palette::{BLUE, GREEN, Key, Marker, Stroke, VERMILLION, dashed, solid};
use super::panel::{Axis, Panel};
use crate::ReportError;
use contract::blind_check::{PowerRow, Share};

/// One line of the figure: its name, what it counts, stroke, marker, and its offset, so that
/// intervals do not cover each other.
type Line = (&'static str, fn(&PowerRow) -> &Share, Stroke, Marker, i32);

const LINES: [Line; 3] = [
    ("Something was found", |row| &row.detected, dashed(GREEN, 4, 6, 8), Marker::Square, -12),
    (
        "Named, or in the set that cannot be told apart",
        |row| &row.named_or_in_set,
        dashed(VERMILLION, 4, 20, 8),
        Marker::Triangle,
        0,
    ),
    ("Named, and no other", |row| &row.named, solid(BLUE, 5), Marker::Disc, 12),
];

/// Draws the rows of all effects together, or `None` without one.
pub(crate) fn power(rows: &[&PowerRow]) -> Result<Option<Drawn>, ReportError> {
    if rows.is_empty() {
        return Ok(None);
    }
    let x = Axis::over(rows.iter().map(|row| place(row)).chain([0.0]), 6);
    let y = Axis::over([0.0, 100.0], 5);
    let panel = Panel::new((110, WIDTH - 50), (60, 480), x, y);
    let svg = draw("Share of effects found by the shift that they cause", 590, |canvas| {
        panel.frame(canvas, "Mean shift of glucose (mg/dL)", "Found (% of worlds)")?;
        for (_, share, stroke, marker, aside) in LINES {
            line(canvas, &panel, rows, share, (stroke, marker, aside))?;
        }
        Ok(())
    })?;
    let keys = LINES.map(|(name, _, stroke, marker, _)| Key::marker(name, stroke, marker));
    Ok(Some((svg, keys.to_vec())))
}

/// Position of a row on the axis.
fn place(row: &PowerRow) -> f64 {
    row.mean_shift_mg_dl
}

fn line(
    canvas: &Canvas<'_>,
    panel: &Panel,
    rows: &[&PowerRow],
    share: fn(&PowerRow) -> &Share,
    (stroke, marker, aside): (Stroke, Marker, i32),
) -> Result<(), ReportError> {
    let at = |row: &PowerRow, value: f64| {
        let (x, y) = panel.at(place(row), 100.0 * value.clamp(0.0, 1.0));
        (x + aside, y)
    };
    let points: Vec<_> =
        rows.iter().filter_map(|row| share(row).value.map(|v| at(row, v))).collect();
    if points.len() > 1 {
        canvas.path(points.clone(), stroke)?;
    }
    for row in rows {
        let interval = vec![at(row, share(row).lower), at(row, share(row).upper)];
        canvas.path(interval, solid(stroke.colour, 3))?;
    }
    points.into_iter().try_for_each(|point| canvas.marker(point, marker, stroke.colour))
}
