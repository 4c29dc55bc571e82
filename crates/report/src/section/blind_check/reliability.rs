//! Whether stated probabilities come true.

use crate::figure::palette::{BLUE, GREY, Key, Marker, dashed, solid};
use crate::figure::{Axis, Drawn, Panel, WIDTH, draw};
use crate::html::{Column, Html};
use crate::number::{optional, percent, share};
use contract::BlindCheck;
use contract::blind_check::ReliabilityBin;

pub(in super::super) fn body(html: &mut Html, check: &BlindCheck) {
    let reliability = &check.reliability;
    if reliability.bins.is_empty() {
        html.absent("No probability was stated.");
        return;
    }
    let error = optional(reliability.expected_calibration_error, 3);
    let interval = match (reliability.lower, reliability.upper) {
        (lower @ Some(_), upper @ Some(_)) => {
            format!(" (95 % interval {} to {})", optional(lower, 3), optional(upper, 3))
        }
        _ => String::new(),
    };
    html.paragraph(&format!(
        "Expected calibration error {error}{interval}, over {} stated probabilities. As many that come true \
         as often as they say would have {} in the mean.",
        reliability.probabilities,
        optional(reliability.error_if_calibrated, 3)
    ));
    html.figure(
        stated_against_true(&reliability.bins),
        "Stated probability against the share that came true. On the dashed line, \u{201c}80 \
         %\u{201d} is true four times in five; below it the diagnosis is too sure of itself.",
    );
    html.rows(
        "Probabilities of about one size",
        &reliability.bins,
        &[
            ("Stated, mean", Column::Number, &|bin| percent(bin.mean_probability)),
            ("Came true (95 % interval)", Column::Number, &|bin| share(&bin.came_true)),
        ],
    );
}

/// Draws one point per bin, or `None` without one.
fn stated_against_true(bins: &[ReliabilityBin]) -> Option<Drawn> {
    let axis = Axis::over([0.0, 100.0], 5);
    let panel = Panel::new((110, WIDTH - 50), (60, 640), axis.clone(), axis);
    let at = |x: f64, y: f64| panel.at(100.0 * x.clamp(0.0, 1.0), 100.0 * y.clamp(0.0, 1.0));
    let scored = bins.iter().filter(|bin| bin.came_true.value.is_some());
    let points = bins.iter().filter_map(|b| Some(at(b.mean_probability, b.came_true.value?)));
    let points: Vec<_> = points.collect();
    if points.is_empty() {
        return None;
    }
    let diagonal = dashed(GREY, 3, 10, 8);
    let stroke = solid(BLUE, 4);
    let keys = vec![
        Key::marker("Probabilities of about one size, with a 95 % interval", stroke, Marker::Disc),
        Key::line("As stated", diagonal),
    ];
    Some(draw("Stated probability against the share that came true", 750, keys, |canvas| {
        panel.frame(canvas, "Stated probability (%)", "Came true (%)");
        canvas.path([at(0.0, 0.0), at(1.0, 1.0)], diagonal);
        if points.len() > 1 {
            canvas.path(points.clone(), dashed(BLUE, 3, 4, 6));
        }
        for bin in scored {
            let ends = [bin.came_true.lower, bin.came_true.upper];
            canvas.path(ends.map(|end| at(bin.mean_probability, end)), stroke);
        }
        for point in points {
            canvas.marker(point, Marker::Disc, BLUE);
        }
    }))
}
