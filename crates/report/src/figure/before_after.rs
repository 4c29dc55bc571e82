//! Held-out error at each horizon, before and after the effects are added.

use contract::diagnosis::HorizonChange;
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

/// The name of a horizon, its errors, and the error that a perfect model would have.
pub(crate) type Bars<'a> = (String, &'a HorizonChange, Option<f64>);

/// Draws two bars a row, or `None` without a row.
pub(crate) fn before_after(rows: &[Bars<'_>]) -> Result<Option<Drawn>, ReportError> {
    if rows.is_empty() {
        return Ok(None);
    }
    let errors = rows
        .iter()
        .flat_map(|(_, row, floor)| [row.mae_before, row.mae_after].into_iter().chain(*floor));
    let x = Axis::over(errors.chain([0.0]), 5);
    // Room at the right for the number behind the longest bar.
    let panel = Panel::rows((160, WIDTH - 110), x, rows.len(), GROUP);
    let svg = draw("Held-out error before and after by horizon", panel.bottom + 110, |canvas| {
        panel.frame(canvas, "Mean absolute error (mg/dL)", "")?;
        for (index, (name, row, floor)) in rows.iter().enumerate() {
            let middle = panel.top + GROUP * index as i32 + GROUP / 2;
            panel.label(canvas, name, middle)?;
            let (before, after) = (row.mae_before, row.mae_after);
            let bars = [(before, GREY, middle - BAR - 4), (after, BLUE, middle + 4)];
            for (value, colour, top) in bars {
                let (end, _) = panel.at(value, 0.0);
                canvas.rectangle((panel.left, top), (end, top + BAR), colour, 1.0)?;
                let place = (end + 10, top + BAR / 2);
                canvas.text(&fixed(value, 1), place, (HPos::Left, VPos::Center))?;
            }
            let bound = floor
                .map_or_else(String::new, |floor| format!(", a perfect model {}", fixed(floor, 1)));
            let words = format!(
                "{name}: before {}, after {}{bound} mg/dL",
                fixed(before, 1),
                fixed(after, 1)
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
        Key::area(
            "Before: the recalibrated model, in bars with * with the effects that need no events (upper bar)",
            GREY,
            1.0,
        ),
        Key::area("After: with the effects (lower bar)", BLUE, 1.0),
    ];
    if rows.iter().any(|(_, _, floor)| floor.is_some()) {
        keys.push(Key::line("What a perfect model would leave (a bound)", FLOOR));
    }
    Ok(Some((svg, keys)))
}
