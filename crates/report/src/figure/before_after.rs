//! Held-out error at each horizon, before and after the effects are added.

use plotters::style::text_anchor::{HPos, VPos};

use super::Drawn;
use super::canvas::{WIDTH, draw};
use super::palette::{BLUE, GREY, Key, Stroke, VERMILLION, solid};
use super::panel::{Axis, Panel};
use crate::ReportError;
use crate::number::fixed;

/// Thickness of a bar and distance between bars, canvas units.
const BAR: i32 = 34;
/// Height that one horizon takes, canvas units.
const GROUP: i32 = 110;
/// The error of a perfect model.
const FLOOR: Stroke = solid(VERMILLION, 7);

/// Errors at one horizon, mg/dL.
pub(crate) struct Bars {
    /// Its name.
    pub(crate) name: String,
    /// Error before.
    pub(crate) before: f64,
    /// Error after.
    pub(crate) after: f64,
    /// Error that a perfect model would have.
    pub(crate) floor: Option<f64>,
}

/// Draws two bars a row, or `None` without an error.
pub(crate) fn before_after(rows: &[Bars]) -> Result<Option<Drawn>, ReportError> {
    let errors =
        || rows.iter().flat_map(|row| [Some(row.before), Some(row.after), row.floor]).flatten();
    if errors().next().is_none() {
        return Ok(None);
    }
    let height = GROUP * i32::try_from(rows.len()).unwrap_or(i32::MAX / GROUP);
    let (x, y) = (Axis::over(errors().chain([0.0]), 5), Axis::bare(0.0, 1.0));
    // Room at the right for the number behind the longest bar.
    let panel = Panel::new((160, WIDTH - 110), (20, 20 + height), x, y);
    let svg = draw("Held-out error before and after by horizon", panel.bottom + 110, |canvas| {
        panel.frame(canvas, "Mean absolute error (mg/dL)", "")?;
        for (index, Bars { name, before, after, floor }) in rows.iter().enumerate() {
            let middle = panel.top + GROUP * index as i32 + GROUP / 2;
            canvas.text(name, (panel.left - 14, middle), (HPos::Right, VPos::Center))?;
            let bars = [(before, GREY, middle - BAR - 4), (after, BLUE, middle + 4)];
            for (value, colour, top) in bars {
                let (end, _) = panel.at(*value, 0.0);
                canvas.rectangle((panel.left, top), (end, top + BAR), colour, 1.0)?;
                let place = (end + 10, top + BAR / 2);
                canvas.text(&fixed(*value, 1), place, (HPos::Left, VPos::Center))?;
            }
            let bound = floor
                .map_or_else(String::new, |floor| format!(", a perfect model {}", fixed(floor, 1)));
            let words = format!(
                "{name}: before {}, after {}{bound} mg/dL",
                fixed(*before, 1),
                fixed(*after, 1)
            );
            canvas.hover((0, middle - GROUP / 2), (WIDTH, middle + GROUP / 2), &words);
            if let Some(floor) = *floor {
                let (x, _) = panel.at(floor, 0.0);
                canvas.path(vec![(x, middle - BAR - 12), (x, middle + BAR + 12)], FLOOR)?;
            }
        }
        Ok(())
    })?;
    let mut keys = vec![
        Key::area("Before: the recalibrated model (upper bar)", GREY, 1.0),
        Key::area("After: with the effects (lower bar)", BLUE, 1.0),
    ];
    if rows.iter().any(|row| row.floor.is_some()) {
        keys.push(Key::line("What a perfect model would leave (a bound)", FLOOR));
    }
    Ok(Some((svg, keys)))
}
