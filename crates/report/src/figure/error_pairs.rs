//! Error of every person with one model against the error with another.

use super::Drawn;
use super::canvas::{WIDTH, draw};
use super::palette::{BLUE, GREY, Key, Marker, dashed, solid};
use super::panel::{Axis, Panel};
use crate::ReportError;

/// Draws one point per person, or `None` without a point. The titles are of the figure, of the
/// horizontal axis and of the vertical axis.
pub(crate) fn error_pairs(
    titles: [&str; 3],
    points: &[(f64, f64)],
) -> Result<Option<Drawn>, ReportError> {
    if points.is_empty() {
        return Ok(None);
    }
    // The same range on both axes, so that the diagonal means "no change".
    let axis = Axis::over(points.iter().flat_map(|(x, y)| [*x, *y]), 5);
    let panel = Panel {
        left: 110,
        right: WIDTH - 30,
        top: 60,
        bottom: 640,
        x: axis.clone(),
        y: axis.clone(),
    };
    let diagonal = dashed(GREY, 3, 10, 8);
    let [name, x_title, y_title] = titles;
    let svg = draw(name, 750, |canvas| {
        panel.frame(canvas, x_title, y_title)?;
        let (low, high) = axis.range;
        panel.line(canvas, [(low, Some(low)), (high, Some(high))], diagonal)?;
        points.iter().try_for_each(|(x, y)| canvas.marker(panel.at(*x, *y), Marker::Disc, BLUE))
    })?;
    let keys = vec![
        Key::marker("One person", solid(BLUE, 3), Marker::Disc),
        Key::line("No change", diagonal),
    ];
    Ok(Some((svg, keys)))
}
