//! Meals under several insulin-to-carbohydrate ratios: one panel a meal, one line a ratio.

use std::fmt::Write as _;

use contract::WhatIf;
use contract::what_if::WhatIfCurve;
use plotters::style::text_anchor::{HPos, VPos};

use super::Drawn;
use super::canvas::{Canvas, WIDTH, draw};
use super::palette::{BLUE, GREEN, Key, PURPLE, SHADE, Stroke, VERMILLION, dashed, solid};
use super::panel::{Axis, Panel};
use crate::ReportError;
use crate::number::{compact, ends, fixed};

/// Panels in a row.
const COLUMNS: usize = 3;
/// Edges of the outer panels, and the gap between two.
const LEFT: i32 = 125;
const RIGHT: i32 = WIDTH - 15;
const GAP: i32 = 30;
/// Height of a row of panels with its titles, canvas units.
const HEIGHT: i32 = 550;
/// Opacity of the quartiles.
const VEIL: f64 = 0.22;
/// Strokes of the ratios, from the lowest on.
const RATIOS: [Stroke; 4] = [
    solid(BLUE, 6),
    dashed(VERMILLION, 6, 26, 9),
    dashed(GREEN, 6, 9, 8),
    dashed(PURPLE, 6, 40, 14),
];

/// Draws one panel a meal under the name `label`, or `None` without a curve. All panels share one
/// vertical axis.
pub(crate) fn what_if(answers: &WhatIf, label: &str) -> Result<Option<Drawn>, ReportError> {
    let curves: Vec<&WhatIfCurve> = answers.curves.iter().collect();
    let meals = in_order(&curves, |curve| curve.carbs_g);
    let ratios = in_order(&curves, |curve| curve.ratio_g_per_u);
    if curves.is_empty() {
        return Ok(None);
    }
    let stroke = |ratio: f64| {
        let index = ratios.iter().position(|known| *known == ratio).unwrap_or(0);
        RATIOS[index % RATIOS.len()]
    };
    let series = |curve: &WhatIfCurve| -> Vec<f64> {
        let all = [&curve.lower, &curve.median, &curve.upper];
        all.into_iter().flatten().copied().collect()
    };
    let levels = curves.iter().flat_map(|curve| series(curve));
    let y = Axis::over(levels.chain([70.0, 180.0]), 6);
    let last = curves.iter().flat_map(|curve| curve.minutes.iter().copied()).fold(0.0, f64::max);
    let columns = meals.len().min(COLUMNS) as i32;
    let width = (RIGHT - LEFT - GAP * (columns - 1)) / columns;
    let rows = meals.len().div_ceil(COLUMNS) as i32;

    let svg = draw(label, rows * HEIGHT, |canvas| {
        for (number, carbs) in meals.iter().enumerate() {
            let (row, column) = ((number / COLUMNS) as i32, (number % COLUMNS) as i32);
            let left = LEFT + column * (width + GAP);
            let down = (row * HEIGHT + 90, row * HEIGHT + HEIGHT - 105);
            let y = if column == 0 { y.clone() } else { y.unlabelled() };
            let panel = Panel::new((left, left + width), down, Axis::minutes(last), y);
            let (from, to) = (panel.at(0.0, 180.0), panel.at(0.0, 70.0));
            canvas.rectangle((panel.left, from.1), (panel.right, to.1), SHADE, 1.0)?;
            panel.frame(canvas, "Minutes", if column == 0 { "Glucose (mg/dL)" } else { "" })?;
            // Below the frame's title, which only the first panel of a row has.
            let title = format!("{} g", compact(*carbs));
            let middle = (panel.left + panel.right) / 2;
            canvas.text(&title, (middle, panel.top - 50), (HPos::Center, VPos::Bottom))?;
            let of_meal = || curves.iter().filter(|curve| curve.carbs_g == *carbs);
            for curve in of_meal() {
                let quartiles = curve.minutes.iter().zip(&curve.lower).zip(&curve.upper);
                let points = quartiles.map(|((x, low), high)| (*x, Some(*low), Some(*high)));
                panel.band(canvas, points, stroke(curve.ratio_g_per_u).colour, VEIL)?;
            }
            for curve in of_meal() {
                let points =
                    curve.minutes.iter().copied().zip(curve.median.iter().map(|x| Some(*x)));
                panel.line(canvas, points, stroke(curve.ratio_g_per_u))?;
            }
            let meal: Vec<&WhatIfCurve> = of_meal().copied().collect();
            values(canvas, &panel, &title, &meal);
        }
        Ok(())
    })?;
    let mut keys: Vec<Key> = ratios
        .iter()
        .map(|ratio| Key::line(&format!("{} g/U, median", compact(*ratio)), stroke(*ratio)))
        .collect();
    keys.push(Key::area("Middle half of the twins, in the line's colour", BLUE, VEIL));
    keys.push(Key::area("Target range, 70\u{2013}180 mg/dL", SHADE, 1.0));
    Ok(Some((svg, keys)))
}

/// Minutes from one place with values to the next.
const APART: f64 = 15.0;

/// Lets every ratio's median and middle half show where a pointer rests.
fn values(canvas: &Canvas<'_>, panel: &Panel, meal: &str, curves: &[&WhatIfCurve]) {
    let Some(first) = curves.first() else { return };
    for (index, minute) in first.minutes.iter().enumerate() {
        if minute.rem_euclid(APART) > 1e-9 {
            continue;
        }
        let mut words = format!("{meal}, after {} min", compact(*minute));
        for curve in curves {
            let at = |series: &[f64]| series.get(index).copied();
            let all = at(&curve.median).zip(at(&curve.lower)).zip(at(&curve.upper));
            if let Some(((median, lower), upper)) = all {
                let _ = write!(
                    words,
                    "; {} g/U: {}{} mg/dL",
                    compact(curve.ratio_g_per_u),
                    fixed(median, 0),
                    ends(lower, upper, 0)
                );
            }
        }
        let edge = |minutes: f64| panel.at(minutes.clamp(panel.x.range.0, panel.x.range.1), 0.0).0;
        let (left, right) = (edge(minute - APART / 2.0), edge(minute + APART / 2.0));
        canvas.hover((left, panel.top), (right, panel.bottom), &words);
    }
}

/// The different values of a quantity, ascending.
fn in_order(curves: &[&WhatIfCurve], of: fn(&WhatIfCurve) -> f64) -> Vec<f64> {
    let mut values: Vec<f64> = curves.iter().map(|curve| of(curve)).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}
