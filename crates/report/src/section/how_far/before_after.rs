//! Held-out error at each horizon, before and after the effects are added.

use contract::diagnosis::HorizonChange;
use plotters::style::text_anchor::{HPos, VPos};

use super::{floor, name};
use crate::figure::palette::{BLUE, GREY, Key, Stroke, VERMILLION, solid};
use crate::figure::{Axis, Drawn, Panel, WIDTH, draw};
use crate::number::fixed;

/// Thickness of a bar and distance between bars, canvas units.
const BAR: i32 = 34;
/// Height that one horizon takes, canvas units.
const GROUP: i32 = 110;
/// The error of a perfect model.
const FLOOR: Stroke = solid(VERMILLION, 7);

/// Draws two bars a row, or `None` without a row.
pub(super) fn figure(rows: &[HorizonChange]) -> Option<Drawn> {
    if rows.is_empty() {
        return None;
    }
    let errors =
        rows.iter().flat_map(|row| [row.mae_before, row.mae_after].into_iter().chain(floor(row)));
    let x = Axis::over(errors.chain([0.0]), 5);
    // Room at the right for the number behind the longest bar.
    let panel = Panel::rows((160, WIDTH - 110), x, rows.len(), GROUP);
    let mut keys = vec![
        Key::area(
            "Before: the recalibrated model, in bars with * with the effects that need no events (upper bar)",
            GREY,
            1.0,
        ),
        Key::area("After: with the effects (lower bar)", BLUE, 1.0),
    ];
    if rows.iter().any(|row| floor(row).is_some()) {
        keys.push(Key::line("What a perfect model would leave (a bound)", FLOOR));
    }
    let label = "Held-out error before and after by horizon";
    Some(draw(label, panel.bottom + 110, keys, |canvas| {
        panel.frame(canvas, "Mean absolute error (mg/dL)", "");
        for (index, row) in rows.iter().enumerate() {
            let middle = panel.top + GROUP * index as i32 + GROUP / 2;
            let name = name(row);
            panel.label(canvas, &name, middle);
            let (before, after) = (row.mae_before, row.mae_after);
            let bars = [(before, GREY, middle - BAR - 4), (after, BLUE, middle + 4)];
            for (value, colour, top) in bars {
                let (end, _) = panel.at(value, 0.0);
                canvas.rectangle((panel.left, top), (end, top + BAR), colour, 1.0);
                let place = (end + 10, top + BAR / 2);
                canvas.text(&fixed(value, 1), place, (HPos::Left, VPos::Center));
            }
            let (before, after) = (fixed(before, 1), fixed(after, 1));
            let mut words = format!("{name}: before {before}, after {after}");
            if let Some(floor) = floor(row) {
                let (x, _) = panel.at(floor, 0.0);
                canvas.path([(x, middle - BAR - 12), (x, middle + BAR + 12)], FLOOR);
                words += &format!(", a perfect model {}", fixed(floor, 1));
            }
            canvas.hover((0, middle - GROUP / 2), (WIDTH, middle + GROUP / 2), &(words + " mg/dL"));
        }
    }))
}
