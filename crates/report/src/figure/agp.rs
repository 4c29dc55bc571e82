//! Ambulatory glucose profile: the twin's percentiles over the measured ones.

use super::Drawn;
use super::canvas::{WIDTH, draw};
use super::palette::{BLUE, GREY, Key, MEASURED, SHADE, Stroke, TWIN, dashed};
use super::panel::{Axis, Panel};
use crate::ReportError;
use contract::GlucoseProfile;
use contract::agp::Percentiles;

/// Quartiles of the twin.
const TWIN_QUARTILES: Stroke = dashed(BLUE, 3, 5, 8);

/// Draws the profile, or `None` where it has no time of day.
pub(crate) fn agp(agp: &GlucoseProfile) -> Result<Option<Drawn>, ReportError> {
    if agp.hour.is_empty() {
        return Ok(None);
    }
    let extremes =
        |p: &Percentiles| -> Vec<f64> { p.p05.iter().chain(&p.p95).flatten().copied().collect() };
    let mut levels = extremes(&agp.observed);
    levels.extend(extremes(&agp.twin));
    levels.extend([70.0, 180.0]);
    let panel = Panel {
        left: 110,
        right: WIDTH - 50,
        top: 60,
        bottom: 480,
        x: Axis::clock(agp.hour[0].min(0.0), 24.0),
        y: Axis::over(levels, 5),
    };

    let svg = draw("Glucose percentiles by time of day, measured and twin", 590, |canvas| {
        let observed = &agp.observed;
        let hours = || agp.hour.iter().copied();
        let between = |low: &[Option<f64>], high: &[Option<f64>]| -> Vec<_> {
            hours().zip(low).zip(high).map(|((x, low), high)| (x, *low, *high)).collect()
        };
        panel.band(canvas, between(&observed.p05, &observed.p95), SHADE, 1.0)?;
        panel.band(canvas, between(&observed.p25, &observed.p75), GREY, 0.45)?;
        panel.frame(canvas, "Time of day", "Glucose (mg/dL)")?;
        let target = dashed(GREY, 3, 10, 10);
        for edge in [70.0, 180.0] {
            let ends = [(panel.x.range.0, Some(edge)), (panel.x.range.1, Some(edge))];
            panel.line(canvas, ends, target)?;
        }
        let line = |values: &[Option<f64>], stroke| {
            panel.line(canvas, hours().zip(values.iter().copied()), stroke)
        };
        line(&observed.p50, MEASURED)?;
        line(&agp.twin.p25, TWIN_QUARTILES)?;
        line(&agp.twin.p75, TWIN_QUARTILES)?;
        line(&agp.twin.p50, TWIN)
    })?;

    let keys = vec![
        Key::line("Sensor, median", MEASURED),
        Key::area("Sensor, 25th\u{2013}75th percentile", GREY, 0.45),
        Key::area("Sensor, 5th\u{2013}95th percentile", SHADE, 1.0),
        Key::line("Twin, median", TWIN),
        Key::line("Twin, 25th and 75th percentile", TWIN_QUARTILES),
        Key::line("70 and 180 mg/dL", dashed(GREY, 3, 10, 10)),
    ];
    Ok(Some((svg, keys)))
}
