//! Error of every person with one model against the error with another.

use super::palette::{BLUE, GREY, Key, Marker, dashed, solid};
use super::{Axis, Drawn, Panel, WIDTH, draw};
use crate::number::fixed;

/// A person, and the person's errors with both models, mg/dL.
pub(crate) type ErrorPair<'a> = (&'a str, f64, f64);

/// Half the side of the box around a mark in which its values show, canvas units.
const REACH: i32 = 20;

/// Draws one point per person, or `None` without a point; the first model is on the horizontal axis.
/// The titles are of the figure, of the horizontal axis and of the vertical axis; `words` name the two
/// models where a pointer rests.
pub(crate) fn error_pairs(
    [name, x_title, y_title]: [&str; 3],
    words: [&str; 2],
    points: &[ErrorPair<'_>],
) -> Option<Drawn> {
    if points.is_empty() {
        return None;
    }
    // The same range on both axes, so that the diagonal means "no change".
    let axis = Axis::over(points.iter().flat_map(|(_, first, second)| [*first, *second]), 5);
    let (low, high) = axis.range;
    let panel = Panel::new((110, WIDTH - 30), (60, 640), axis.clone(), axis);
    let diagonal = dashed(GREY, 3, 10, 8);
    let keys = vec![
        Key::marker("One person", solid(BLUE, 3), Marker::Disc),
        Key::line("No change", diagonal),
    ];
    Some(draw(name, 750, keys, |canvas| {
        panel.frame(canvas, x_title, y_title);
        canvas.path([panel.at(low, low), panel.at(high, high)], diagonal);
        for (person, first, second) in points {
            let (x, y) = panel.at(*first, *second);
            canvas.marker((x, y), Marker::Disc, BLUE);
            let says = format!(
                "{person}: {} {}, {} {} mg/dL",
                words[0],
                fixed(*first, 1),
                words[1],
                fixed(*second, 1)
            );
            canvas.hover((x - REACH, y - REACH), (x + REACH, y + REACH), &says);
        }
    }))
}
