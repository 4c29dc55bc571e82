//! Ambulatory glucose profile: measured percentiles, with the twin's over them where there is one.

use super::palette::{BLUE, GREY, Key, MEASURED, SHADE, Stroke, TWIN, dashed};
use super::{Axis, Drawn, Panel, WIDTH, draw};
use crate::number::{clock, fixed};
use contract::agp::Percentiles;

/// Quartiles of the twin.
const TWIN_QUARTILES: Stroke = dashed(BLUE, 3, 5, 8);
/// Edges of the target range.
const TARGET: Stroke = dashed(GREY, 3, 10, 10);

/// Draws the profile of `label`, or `None` where it has no time of day.
pub(crate) fn agp(
    label: &str,
    hour: &[f64],
    observed: &Percentiles,
    twin: Option<&Percentiles>,
) -> Option<Drawn> {
    let x = Axis::clock(hour.first()?.min(0.0), 24.0);
    let both = std::iter::once(observed).chain(twin);
    let extremes = both.flat_map(|of| of.p05.iter().chain(&of.p95)).flatten().copied();
    let y = Axis::over(extremes.chain([70.0, 180.0]), 5);
    let panel = Panel::new((110, WIDTH - 50), (60, 480), x, y);

    let mut keys = vec![
        Key::line("Sensor, median", MEASURED),
        Key::area("Sensor, 25th\u{2013}75th percentile", GREY, 0.45),
        Key::area("Sensor, 5th\u{2013}95th percentile", SHADE, 1.0),
    ];
    if twin.is_some() {
        keys.push(Key::line("Twin, median", TWIN));
        keys.push(Key::line("Twin, 25th and 75th percentile", TWIN_QUARTILES));
    }
    keys.push(Key::line("70 and 180 mg/dL", TARGET));
    Some(draw(label, 590, keys, |canvas| {
        let hours = || hour.iter().copied();
        let between = |low: &[Option<f64>], high: &[Option<f64>]| -> Vec<_> {
            hours().zip(low).zip(high).map(|((x, low), high)| (x, *low, *high)).collect()
        };
        panel.band(canvas, between(&observed.p05, &observed.p95), SHADE, 1.0);
        panel.band(canvas, between(&observed.p25, &observed.p75), GREY, 0.45);
        panel.frame(canvas, "Time of day", "Glucose (mg/dL)");
        for edge in [70.0, 180.0] {
            let (from, to) = panel.x.range;
            canvas.path([panel.at(from, edge), panel.at(to, edge)], TARGET);
        }
        let line = |values: &[Option<f64>], stroke| {
            panel.line(canvas, hours().zip(values.iter().copied()), stroke);
        };
        line(&observed.p50, MEASURED);
        if let Some(twin) = twin {
            line(&twin.p25, TWIN_QUARTILES);
            line(&twin.p75, TWIN_QUARTILES);
            line(&twin.p50, TWIN);
        }
        let half = (panel.right - panel.left) / (2 * hour.len() as i32).max(2);
        for (slot, hour) in hour.iter().enumerate() {
            let at = |series: &[Option<f64>]| series.get(slot).copied().flatten();
            let (Some(median), Some(low), Some(high)) =
                (at(&observed.p50), at(&observed.p25), at(&observed.p75))
            else {
                continue;
            };
            let mut words = format!(
                "{}: median {}, middle half {} to {} mg/dL",
                clock(60.0 * *hour),
                fixed(median, 0),
                fixed(low, 0),
                fixed(high, 0)
            );
            if let Some(twin) = twin.and_then(|twin| at(&twin.p50)) {
                words.push_str(&format!("; twin {}", fixed(twin, 0)));
            }
            let (x, _) = panel.at(*hour, median);
            canvas.hover((x - half, panel.top), (x + half, panel.bottom), &words);
        }
    }))
}
