//! What the model lacks at a port through the day.

use super::Drawn;
use super::canvas::{WIDTH, draw};
use super::palette::{BLUE, GREY, Key, SHADE, solid};
use super::panel::{Axis, Panel};
use crate::ReportError;
use contract::diagnosis::CoursePart;

/// Draws a course, or `None` where no part of it has a time of day.
pub(crate) fn port_course(
    parts: &[CoursePart],
    label: &str,
    axis: &str,
) -> Result<Option<Drawn>, ReportError> {
    let placed: Vec<(f64, f64, &CoursePart)> = parts
        .iter()
        .filter_map(|part| part.ends().map(|(from, to)| (f64::from(from), f64::from(to), part)))
        .collect();
    if placed.is_empty() {
        return Ok(None);
    }
    let ends = parts.iter().flat_map(|part| [part.lower, part.upper, 0.0]);
    let (x, y) = (Axis::clock(0.0, 24.0), Axis::over(ends, 5));
    let panel = Panel::new((130, WIDTH - 50), (60, 360), x, y);
    let svg = draw(label, 470, |canvas| {
        for (from, to, part) in &placed {
            let corners = (panel.at(*from, part.upper), panel.at(*to, part.lower));
            canvas.rectangle(corners.0, corners.1, SHADE, 1.0)?;
        }
        panel.frame(canvas, "Time of day", axis)?;
        canvas.path(vec![panel.at(0.0, 0.0), panel.at(24.0, 0.0)], solid(GREY, 3))?;
        for (from, to, part) in &placed {
            let line = vec![panel.at(*from, part.value), panel.at(*to, part.value)];
            canvas.path(line, solid(BLUE, 6))?;
        }
        Ok(())
    })?;
    let keys = vec![
        Key::line("Estimate", solid(BLUE, 6)),
        Key::area("95 % interval, all parts of the day together", SHADE, 1.0),
    ];
    Ok(Some((svg, keys)))
}
