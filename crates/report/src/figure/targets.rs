//! What was promised and what was measured, one line each.

use contract::blind_check::{Bound, Target};

use super::Drawn;
use super::canvas::{WIDTH, draw};
use super::forest::shortened;
use super::palette::{BLACK, BLUE, Key, Marker, SHADE, VERMILLION, solid};
use super::panel::{Axis, Panel};
use crate::ReportError;

/// Height of a row, canvas units.
const ROW: i32 = 60;

/// Draws the targets under the names given, or `None` where none was measured.
pub(crate) fn targets(rows: &[(String, &Target)]) -> Result<Option<Drawn>, ReportError> {
    if rows.iter().all(|(_, target)| target.value.is_none()) {
        return Ok(None);
    }
    let longest = rows.iter().map(|(name, _)| shortened(name).chars().count()).max().unwrap_or(0);
    let across = (40 + 19 * longest as i32, WIDTH - 50);
    let panel = Panel::rows(across, Axis::over([0.0, 1.0], 5), rows.len(), ROW);
    let (met, missed) = (solid(BLUE, 5), solid(VERMILLION, 5));
    let svg = draw("Every target with what was measured", panel.bottom + 110, |canvas| {
        panel.frame(canvas, "Measured (share, F1 or error)", "")?;
        for (index, (name, target)) in rows.iter().enumerate() {
            let y = rows.len() as f64 - index as f64 - 0.5;
            let at = |x: f64| panel.at(x.clamp(0.0, 1.0), y);
            let (_, middle) = at(0.0);
            let end = if target.bound == Bound::AtMost { 0.0 } else { 1.0 };
            let (from, to) = (at(target.target), at(end));
            let corner = (from.0.min(to.0), middle - ROW / 3);
            canvas.rectangle(corner, (from.0.max(to.0), middle + ROW / 3), SHADE, 1.0)?;
            let tick = vec![(from.0, middle - ROW / 3), (from.0, middle + ROW / 3)];
            canvas.path(tick, solid(BLACK, 4))?;
            panel.label(canvas, &shortened(name), middle)?;
            let Some(value) = target.value else { continue };
            let is_met = target.met == Some(true);
            let stroke = if is_met { met } else { missed };
            if let (Some(lower), Some(upper)) = (target.lower, target.upper) {
                canvas.path(vec![at(lower), at(upper)], stroke)?;
            }
            let marker = if is_met { Marker::Disc } else { Marker::Cross };
            canvas.marker(at(value), marker, stroke.colour)?;
        }
        Ok(())
    })?;
    let keys = vec![
        Key::marker("Met, with its 95 % interval", met, Marker::Disc),
        Key::marker("Missed, with its 95 % interval", missed, Marker::Cross),
        Key::area("Where the target is met; the line across it is its limit", SHADE, 1.0),
    ];
    Ok(Some((svg, keys)))
}
