//! Error of every person with one model against the error with another.

use super::Drawn;
use super::canvas::{WIDTH, draw};
use super::palette::{BLUE, GREY, Key, Marker, dashed, solid};
use super::panel::{Axis, Panel};
use crate::ReportError;
use crate::number::fixed;

/// A person's errors with both models, mg/dL.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ErrorPair<'a> {
    /// The person.
    pub(crate) person: &'a str,
    /// Error with the first model, on the horizontal axis.
    pub(crate) first: f64,
    /// Error with the second.
    pub(crate) second: f64,
}

/// Half the side of the box around a mark in which its values show, canvas units.
const REACH: i32 = 20;

/// Draws one point per person, or `None` without a point. The titles are of the figure, of the
/// horizontal axis and of the vertical axis; `words` name the two models where a pointer rests.
pub(crate) fn error_pairs(
    titles: [&str; 3],
    words: [&str; 2],
    points: &[ErrorPair<'_>],
) -> Result<Option<Drawn>, ReportError> {
    if points.is_empty() {
        return Ok(None);
    }
    // The same range on both axes, so that the diagonal means "no change".
    let axis = Axis::over(points.iter().flat_map(|point| [point.first, point.second]), 5);
    let panel = Panel::new((110, WIDTH - 30), (60, 640), axis.clone(), axis.clone());
    let diagonal = dashed(GREY, 3, 10, 8);
    let [name, x_title, y_title] = titles;
    let svg = draw(name, 750, |canvas| {
        panel.frame(canvas, x_title, y_title)?;
        let (low, high) = axis.range;
        panel.line(canvas, [(low, Some(low)), (high, Some(high))], diagonal)?;
        for point in points {
            let (x, y) = panel.at(point.first, point.second);
            canvas.marker((x, y), Marker::Disc, BLUE)?;
            let says = format!(
                "{}: {} {}, {} {} mg/dL",
                point.person,
                words[0],
                fixed(point.first, 1),
                words[1],
                fixed(point.second, 1)
            );
            canvas.hover((x - REACH, y - REACH), (x + REACH, y + REACH), &says);
        }
        Ok(())
    })?;
    let keys = vec![
        Key::marker("One person", solid(BLUE, 3), Marker::Disc),
        Key::line("No change", diagonal),
    ];
    Ok(Some((svg, keys)))
}
