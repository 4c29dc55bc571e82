//! Error of every twin against the error of the population model.

use super::Drawn;
use super::canvas::{WIDTH, draw};
use super::palette::{BLUE, GREY, Key, Marker, dashed, solid};
use super::panel::{Axis, Panel};
use crate::ReportError;
use crate::view::Twins;

/// Draws one point a person, or `None` where nobody has both errors.
pub(crate) fn twins(twins: &Twins) -> Result<Option<Drawn>, ReportError> {
    let points: Vec<(f64, f64)> =
        twins.people.iter().filter_map(|p| Some((p.rmse_population?, p.rmse_twin?))).collect();
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
    let svg = draw("Error of each twin against the population model", 750, |canvas| {
        panel.frame(
            canvas,
            "RMSE of the population network (mg/dL)",
            "RMSE of the twin (mg/dL)",
        )?;
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
