//! Stated probability against the share that came true.

use super::Drawn;
use super::canvas::{WIDTH, draw};
use super::palette::{BLUE, GREY, Key, Marker, dashed, solid};
use super::panel::{Axis, Panel};
use crate::ReportError;
use contract::blind_check::ReliabilityBin;

/// Draws one point per bin, or `None` without one.
pub(crate) fn reliability(bins: &[ReliabilityBin]) -> Result<Option<Drawn>, ReportError> {
    let points: Vec<_> = bins
        .iter()
        .filter_map(|bin| Some((bin, bin.mean_probability, bin.came_true.value?)))
        .collect();
    if points.is_empty() {
        return Ok(None);
    }
    let axis = Axis::over([0.0, 100.0], 5);
    let panel = Panel::new((110, WIDTH - 50), (60, 640), axis.clone(), axis);
    let diagonal = dashed(GREY, 3, 10, 8);
    let stroke = solid(BLUE, 4);
    let svg = draw("Stated probability against the share that came true", 750, |canvas| {
        panel.frame(canvas, "Stated probability (%)", "Came true (%)")?;
        panel.line(canvas, [(0.0, Some(0.0)), (100.0, Some(100.0))], diagonal)?;
        let at = |x: f64, y: f64| panel.at(100.0 * x.clamp(0.0, 1.0), 100.0 * y.clamp(0.0, 1.0));
        let places: Vec<_> = points.iter().map(|(_, stated, true_)| at(*stated, *true_)).collect();
        if places.len() > 1 {
            canvas.path(places.clone(), dashed(BLUE, 3, 4, 6))?;
        }
        for (bin, stated, _) in &points {
            let ends = [bin.came_true.lower, bin.came_true.upper];
            canvas.path(ends.map(|end| at(*stated, end)).to_vec(), stroke)?;
        }
        places.into_iter().try_for_each(|place| canvas.marker(place, Marker::Disc, BLUE))
    })?;
    let keys = vec![
        Key::marker("Probabilities of about one size, with a 95 % interval", stroke, Marker::Disc),
        Key::line("As stated", diagonal),
    ];
    Ok(Some((svg, keys)))
}
