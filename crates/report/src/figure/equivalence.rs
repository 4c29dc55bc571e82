//! Differences of all methods and outcomes in units of their margin.

use contract::outcomes::{MethodRows, OutcomeRow};

use super::palette::{BLACK, COLOURS, Key, Marker, SHADE, dashed, solid};
use super::{Axis, Drawn, Panel, WIDTH, draw};
use crate::distinct::distinct;

/// Height that one method takes within an outcome, canvas units, and with many methods.
const LANE: i32 = 34;
const NARROW_LANE: i32 = 27;
/// From this number of methods on there are many.
const MANY: usize = 5;
/// Intervals reach at most this many margins; longer ones are cut and marked in the caption.
const REACH: f64 = 4.0;

/// Draws one group per outcome and one line per method, or `None` where there is nothing to draw.
pub(crate) fn equivalence(methods: &[MethodRows]) -> Option<Drawn> {
    let rows = || methods.iter().flat_map(|method| &method.rows);
    let metrics = distinct(rows().map(|row| row.metric.as_str()));
    if metrics.is_empty() {
        return None;
    }
    let lanes = methods.len() as f64 + 1.0;
    let lane = if methods.len() < MANY { LANE } else { NARROW_LANE };
    let height = (f64::from(lane) * lanes * metrics.len() as f64) as i32;
    let scaled = |row: &OutcomeRow| {
        let d = row.difference_t;
        [d.lower, d.upper, d.value].map(|x| (x / row.margin).clamp(-REACH, REACH))
    };
    let x = Axis::over(rows().flat_map(scaled).chain([-1.5, 1.5]), 6);
    let y = Axis::bare(0.0, lanes * metrics.len() as f64);
    let panel = Panel::new((130, WIDTH - 30), (20, 20 + height), x, y);
    // When the colours repeat, the markers move on by one, so no two methods look the same.
    let style = |index: usize| {
        let (round, place) = (index / COLOURS.len(), index % COLOURS.len());
        (solid(COLOURS[place], 5), Marker::CYCLE[(place + round) % Marker::CYCLE.len()])
    };

    let mut keys = Vec::new();
    for (index, method) in methods.iter().enumerate() {
        let (stroke, marker) = style(index);
        keys.push(Key::marker(&method.label, stroke, marker));
    }
    keys.push(Key::area("Within the margin", SHADE, 1.0));
    let label = "Difference of every outcome in units of its margin";
    Some(draw(label, panel.bottom + 110, keys, |canvas| {
        let ends = [-1.0, 1.0].map(|edge| panel.at(edge, 0.0).0);
        canvas.rectangle((ends[0], panel.top), (ends[1], panel.bottom), SHADE, 1.0);
        panel.frame(canvas, "(simulated \u{2212} recorded) / margin", "");
        for edge in ends {
            canvas.path([(edge, panel.bottom), (edge, panel.top)], dashed(BLACK, 3, 10, 8));
        }
        for (group, metric) in metrics.iter().enumerate() {
            let top = panel.y.range.1 - group as f64 * lanes;
            let (_, middle) = panel.at(0.0, top - lanes / 2.0);
            panel.label(canvas, &metric.to_uppercase(), middle);
            for (index, method) in methods.iter().enumerate() {
                let Some(row) = method.rows.iter().find(|row| row.metric == *metric) else {
                    continue;
                };
                let [from, to, at] = scaled(row).map(|x| panel.at(x, top - 1.0 - index as f64));
                let (stroke, marker) = style(index);
                canvas.path([from, to], stroke);
                canvas.marker(at, marker, stroke.colour);
            }
        }
    }))
}
