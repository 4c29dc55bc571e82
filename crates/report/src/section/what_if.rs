//! What twins predict for meals under other doses, and which of them keep the order.

use contract::WhatIf;
use contract::what_if::{WhatIfCurve, WhatIfOrder};
use plotters::style::text_anchor::{HPos, VPos};

use super::words::list;
use crate::Inputs;
use crate::figure::palette::{BLUE, GREEN, Key, PURPLE, SHADE, Stroke, VERMILLION, dashed, solid};
use crate::figure::{Axis, Canvas, Drawn, Panel, WIDTH, draw};
use crate::html::{Column, Html};
use crate::number::{compact, count, ends, fixed};

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
/// Minutes from one place of the pointer with values to the next.
const APART: f64 = 15.0;
/// Strokes of the ratios, from the lowest on.
const RATIOS: [Stroke; 4] = [
    solid(BLUE, 6),
    dashed(VERMILLION, 6, 26, 9),
    dashed(GREEN, 6, 9, 8),
    dashed(PURPLE, 6, 40, 14),
];
/// Glucose difference that the check of the order ignores, mg/dL: below what a sensor resolves.
pub(super) const SAME: f64 = WhatIfOrder::SAME_MG_DL;
/// What twins are called whose networks keep physiology's signs.
pub(super) const CONSTRAINED: [&str; 2] =
    ["twin that keeps physiology's signs", "twins that keep physiology's signs"];

pub(super) fn body(html: &mut Html, inputs: &Inputs) {
    if let Some(answers) = &inputs.what_if {
        let name = "Glucose after meals under several doses";
        courses(html, answers, name, ["twin", "twins"]);
        order(html, "Order of the answers", answers);
    }
    if let Some(answers) = &inputs.what_if_constrained {
        html.element("h3", "Twins that keep physiology's signs");
        let name = "Glucose after meals under several doses, with signs kept";
        courses(html, answers, name, CONSTRAINED);
        order(html, "Order of the answers of twins that keep physiology's signs", answers);
    }
}

/// The courses under the name of their figure; `one` and `many` are what the twins are called.
fn courses(html: &mut Html, answers: &WhatIf, name: &str, [one, many]: [&str; 2]) {
    let first = answers.plan.starts_mg_dl.first().zip(answers.plan.hours.first());
    let circumstances =
        first.map(|(start, hour)| format!(" at {} mg/dL and {hour}:00", compact(*start)));
    let caption = format!(
        "Glucose after meals of several sizes, from left to right, taken{} with the bolus that an \
         insulin-to-carbohydrate ratio (g/U) asks for: median (thick) and middle half (shaded) of {}. \
         A higher ratio means less insulin, so within a panel the line of a higher ratio has to lie \
         above that of a lower one, and from panel to panel the peak has to grow with the meal.",
        circumstances.unwrap_or_default(),
        count(answers.order.len(), one, many)
    );
    if !html.figure(figure(&answers.curves, name), &caption) {
        html.absent("There is no course of glucose to show.");
    }
}

/// For how many twins the order holds, and where it does not for the others.
fn order(html: &mut Html, heading: &str, answers: &WhatIf) {
    html.element("h3", heading);
    if answers.order.is_empty() {
        html.absent("The order of the answers was not checked.");
        return;
    }
    let of = count(answers.order.len(), "twin", "twins");
    let out: Vec<&WhatIfOrder> = answers.order.iter().filter(|twin| !twin.ordered).collect();
    let plan = &answers.plan;
    html.paragraph(&format!(
        "Less insulin never means less glucose (by more than {SAME} mg/dL), and mean glucose grows from \
         each ratio to the next, in {} of {of}, checked from {} mg/dL at {}.{}",
        answers.order.len() - out.len(),
        list(plan.starts_mg_dl.iter().map(|start| compact(*start))),
        list(plan.hours.iter().map(|hour| format!("{hour}:00"))),
        if out.is_empty() { "" } else { " The others are not to be used for what-ifs:" }
    ));
    html.rows(
        "Twins that are not to be used for what-ifs, and where more insulin did not mean less glucose",
        &out,
        &[
            ("Twin", Column::Text, &|twin| twin.person_id.clone()),
            ("Out of order by, mg/dL", Column::Number, &|twin| fixed(twin.worst_mg_dl, 1)),
            ("Worst at", Column::Text, &|twin| match twin.worst_mg_dl > SAME {
                true => twin.worst_at.clone(),
                false => "mean glucose does not grow with the ratio".to_owned(),
            }),
            ("Peak grows with the meal", Column::Text, &|twin| {
                let grows = if twin.peaks_grow_with_meals { "yes" } else { "no" };
                grows.to_owned()
            }),
        ],
    );
    let without = answers.order.iter().filter(|twin| !twin.peaks_grow_with_meals);
    let without: Vec<String> = without.map(|twin| twin.person_id.clone()).collect();
    let exceptions = match without.as_slice() {
        [] => String::new(),
        twins => {
            format!("; not in {}, where meals are not to be compared with each other", list(twins))
        }
    };
    let with = answers.order.len() - without.len();
    let text =
        format!("The peak grows with the meal at every ratio in {with} of {of}{exceptions}.");
    html.paragraph_of("note", &text);
}

/// Draws one panel a meal and one line a ratio under the name `label`, or `None` without a curve. All
/// panels share one vertical axis.
fn figure(curves: &[WhatIfCurve], label: &str) -> Option<Drawn> {
    if curves.is_empty() {
        return None;
    }
    let meals = in_order(curves, |curve| curve.carbs_g);
    let ratios = in_order(curves, |curve| curve.ratio_g_per_u);
    let stroke = |ratio: f64| {
        let index = ratios.iter().position(|known| *known == ratio).unwrap_or(0);
        RATIOS[index % RATIOS.len()]
    };
    let levels = curves.iter().flat_map(|curve| [&curve.lower, &curve.median, &curve.upper]);
    let y = Axis::over(levels.flatten().copied().chain([70.0, 180.0]), 6);
    let last = curves.iter().flat_map(|curve| curve.minutes.iter().copied()).fold(0.0, f64::max);
    let columns = meals.len().min(COLUMNS) as i32;
    let width = (RIGHT - LEFT - GAP * (columns - 1)) / columns;
    let rows = meals.len().div_ceil(COLUMNS) as i32;

    let named =
        |ratio: &f64| Key::line(&format!("{} g/U, median", compact(*ratio)), stroke(*ratio));
    let mut keys: Vec<Key> = ratios.iter().map(named).collect();
    keys.push(Key::area("Middle half of the twins, in the line's colour", BLUE, VEIL));
    keys.push(Key::area("Target range, 70\u{2013}180 mg/dL", SHADE, 1.0));
    Some(draw(label, rows * HEIGHT, keys, |canvas| {
        for (number, carbs) in meals.iter().enumerate() {
            let (row, column) = ((number / COLUMNS) as i32, (number % COLUMNS) as i32);
            let left = LEFT + column * (width + GAP);
            let down = (row * HEIGHT + 90, row * HEIGHT + HEIGHT - 105);
            let (y, y_title) = match column {
                0 => (y.clone(), "Glucose (mg/dL)"),
                _ => (y.unlabelled(), ""),
            };
            let panel = Panel::new((left, left + width), down, Axis::minutes(last), y);
            let (from, to) = (panel.at(0.0, 180.0), panel.at(0.0, 70.0));
            canvas.rectangle((panel.left, from.1), (panel.right, to.1), SHADE, 1.0);
            panel.frame(canvas, "Minutes", y_title);
            // Below the frame's title, which only the first panel of a row has.
            let title = format!("{} g", compact(*carbs));
            let middle = (panel.left + panel.right) / 2;
            canvas.text(&title, (middle, panel.top - 50), (HPos::Center, VPos::Bottom));
            let of_meal = curves.iter().filter(|curve| curve.carbs_g == *carbs);
            let of_meal: Vec<&WhatIfCurve> = of_meal.collect();
            for curve in &of_meal {
                let quartiles = curve.minutes.iter().zip(&curve.lower).zip(&curve.upper);
                let points = quartiles.map(|((x, low), high)| (*x, Some(*low), Some(*high)));
                panel.band(canvas, points, stroke(curve.ratio_g_per_u).colour, VEIL);
            }
            for curve in &of_meal {
                let points = curve.minutes.iter().zip(&curve.median).map(|(x, y)| (*x, Some(*y)));
                panel.line(canvas, points, stroke(curve.ratio_g_per_u));
            }
            values(canvas, &panel, &title, &of_meal);
        }
    }))
}

/// Lets every ratio's median and middle half show where a pointer rests.
fn values(canvas: &Canvas<'_>, panel: &Panel, meal: &str, curves: &[&WhatIfCurve]) {
    let Some(first) = curves.first() else { return };
    let shown = |(_, minute): &(usize, &f64)| minute.rem_euclid(APART) <= 1e-9;
    for (index, minute) in first.minutes.iter().enumerate().filter(shown) {
        let mut words = format!("{meal}, after {} min", compact(*minute));
        for curve in curves {
            let at = |series: &[f64]| series.get(index).copied();
            let all = at(&curve.median).zip(at(&curve.lower)).zip(at(&curve.upper));
            if let Some(((median, lower), upper)) = all {
                let ratio = compact(curve.ratio_g_per_u);
                let (median, ends) = (fixed(median, 0), ends(lower, upper, 0));
                words += &format!("; {ratio} g/U: {median}{ends} mg/dL");
            }
        }
        let edge = |minutes: f64| panel.at(minutes.clamp(panel.x.range.0, panel.x.range.1), 0.0).0;
        let (left, right) = (edge(minute - APART / 2.0), edge(minute + APART / 2.0));
        canvas.hover((left, panel.top), (right, panel.bottom), &words);
    }
}

/// The different values of a quantity, ascending.
fn in_order(curves: &[WhatIfCurve], of: fn(&WhatIfCurve) -> f64) -> Vec<f64> {
    let mut values: Vec<f64> = curves.iter().map(of).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}
