//! Where networks violate physiology: their outputs along the tested input.

use contract::conformance::{Direction, Row, Slice};
use plotters::style::text_anchor::{HPos, VPos};

use super::Drawn;
use super::canvas::{WIDTH, draw};
use super::palette::{BLUE, Key, Marker, VERMILLION, solid};
use super::panel::{Axis, Panel};
use crate::ReportError;

/// Panels in a row.
const COLUMNS: i32 = 2;
/// Height of a panel with its titles, canvas units.
const HEIGHT: i32 = 330;

/// Draws a panel for each row with a slice and a counterexample, or `None` without one.
pub(crate) fn slices(rows: &[&Row]) -> Result<Option<Drawn>, ReportError> {
    let shown: Vec<(&Row, &Slice)> =
        rows.iter()
            .filter_map(|row| {
                let slice = row.slice.as_ref().filter(|slice| {
                    slice.input.len() == slice.output.len() && slice.input.len() > 1
                });
                row.witness.as_ref().and(slice).map(|slice| (*row, slice))
            })
            .collect();
    if shown.is_empty() {
        return Ok(None);
    }
    let lines = (shown.len() as i32 + COLUMNS - 1) / COLUMNS;
    let svg = draw("Outputs along the tested input", lines * HEIGHT + 20, |canvas| {
        for (number, (row, slice)) in shown.iter().enumerate() {
            let (line, column) = (number as i32 / COLUMNS, number as i32 % COLUMNS);
            let width = WIDTH / COLUMNS;
            let across = (column * width + 120, (column + 1) * width - 25);
            let down = (line * HEIGHT + 60, line * HEIGHT + HEIGHT - 90);
            let x = Axis::over(slice.input.iter().copied(), 3);
            let y = Axis::over(slice.output.iter().copied(), 3);
            let panel = Panel::new(across, down, x, y);
            let asked = if row.property == Direction::Increasing { "rise" } else { "fall" };
            panel.frame(canvas, &row.input, "")?;
            let title = format!("{} has to {asked}", row.network);
            canvas.text(&title, (panel.left, panel.top - 12), (HPos::Left, VPos::Bottom))?;
            let points = slice.input.iter().zip(&slice.output);
            panel.line(canvas, points.clone().map(|(x, y)| (*x, Some(*y))), solid(BLUE, 4))?;
            if let Some(witness) = &row.witness {
                let mut within = points.filter(|(x, _)| **x >= witness.from);
                if let Some((x, y)) = within.next() {
                    canvas.marker(panel.at(*x, *y), Marker::Disc, VERMILLION)?;
                }
            }
        }
        Ok(())
    })?;
    let keys = vec![
        Key::line("Output, scaled per minute", solid(BLUE, 4)),
        Key::marker("Counterexample", solid(VERMILLION, 4), Marker::Disc),
    ];
    Ok(Some((svg, keys)))
}
