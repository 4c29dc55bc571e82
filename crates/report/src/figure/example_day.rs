//! A day or a few in three panels: glucose; insulin and carbohydrate; heart rate and sleep.

use contract::ExampleDay;
use plotters::style::text_anchor::{HPos, VPos};

use super::Drawn;
use super::canvas::{Canvas, WIDTH, draw};
use super::palette::{
    BLUE, CLOSEST, GREY, Key, MEASURED, ODE, ORANGE, POPULATION, SHADE, SKY, Stroke, TWIN,
    VERMILLION, solid,
};
use super::panel::{Axis, Panel};
use crate::ReportError;
use crate::number::fixed;

/// Edges that all panels share.
const LEFT: i32 = 110;
const RIGHT: i32 = WIDTH - 50;
/// Insulin rate.
const INSULIN: Stroke = solid(BLUE, 4);
/// Heart rate.
const HEART_RATE: Stroke = solid(VERMILLION, 3);

/// Whether there are too many days to show single hours.
fn is_long(from: f64, to: f64) -> bool {
    to - from > 30.0
}

/// Draws the days, or `None` where it has no sample.
pub(crate) fn example_day(day: &ExampleDay) -> Result<Option<Drawn>, ReportError> {
    let hours: Vec<f64> = (0..day.time.len()).map(|k| hour_of(day, k)).collect();
    let (Some(first), Some(last)) = (hours.first(), hours.last()) else {
        return Ok(None);
    };
    let glucose = [
        (&day.cgm[..], MEASURED, "Sensor (CGM)"),
        (&day.twin, TWIN, "Digital twin"),
        (day.closest.as_deref().unwrap_or_default(), CLOSEST, "ODE, closest virtual patient"),
        (&day.population, POPULATION, "Population network"),
        (&day.ode, ODE, "ODE, population parameters"),
    ];
    let shown: Vec<_> = glucose.into_iter().filter(|(values, ..)| has_value(values)).collect();
    if shown.is_empty() {
        return Ok(None);
    }

    let clock = Axis::clock(*first, *last);
    let panel = |top: i32, height: i32, y: Axis| Panel {
        left: LEFT,
        right: RIGHT,
        top,
        bottom: top + height,
        x: clock.clone(),
        y,
    };
    let levels = shown.iter().flat_map(|(values, ..)| values.iter().flatten().copied());
    let upper = panel(60, 380, Axis::over(levels.chain([70.0, 180.0]), 9));
    // Insulin keeps to the lower half of its panel, so that meals can hang from the top.
    let most_insulin = day.insulin_u_h.iter().copied().fold(0.0, f64::max);
    let doses_axis = Axis::over([0.0, 1.0, 1.8 * most_insulin], 4);
    let middle = panel(525, 260, doses_axis);
    let lower = panel(870, 210, Axis::over(present(&day.heart_rate_over_baseline).chain([1.0]), 4));

    let label = if is_long(*first, *last) {
        "Glucose, insulin, carbohydrate, heart rate and sleep over several days"
    } else {
        "Glucose, insulin, carbohydrate, heart rate and sleep over one day"
    };
    let svg = draw(label, 1180, |canvas| {
        let (from, to) = (upper.at(*first, 180.0), upper.at(*last, 70.0));
        canvas.rectangle((LEFT, from.1), (RIGHT, to.1), SHADE, 1.0)?;
        upper.frame(canvas, "", "Glucose (mg/dL)")?;
        midnights(canvas, &upper)?;
        // The sensor last, so that no line hides it.
        for (values, stroke, _) in shown.iter().rev() {
            upper.line(canvas, hours.iter().copied().zip(values.iter().copied()), *stroke)?;
        }
        doses(canvas, &middle, day, &hours)?;
        activity(canvas, &lower, day, &hours)
    })?;

    let mut keys: Vec<Key> =
        shown.iter().map(|(_, stroke, name)| Key::line(name, *stroke)).collect();
    keys.push(Key::area("Target range, 70\u{2013}180 mg/dL", SHADE, 1.0));
    if !day.insulin_u_h.is_empty() {
        keys.push(Key::line("Insulin (U/h)", INSULIN));
    }
    if day.carbs_g.iter().any(|g| *g > 0.0) {
        keys.push(Key::area("Carbohydrate (g, from above)", ORANGE, 1.0));
    }
    if has_value(&day.heart_rate_over_baseline) {
        keys.push(Key::line("Heart rate over baseline", HEART_RATE));
    }
    if has_value(&day.sleep_efficiency) {
        keys.push(Key::area("Asleep (height = share of the step)", SKY, 0.55));
    }
    Ok(Some((svg, keys)))
}

/// An upright line where one day ends and another begins.
fn midnights(canvas: &Canvas<'_>, panel: &Panel) -> Result<(), ReportError> {
    let (from, to) = panel.x.range;
    let mut midnight = 24.0 * (from / 24.0).floor() + 24.0;
    while is_long(from, to) && midnight < to {
        let (x, _) = panel.at(midnight, panel.y.range.0);
        canvas.path(vec![(x, panel.top), (x, panel.bottom)], solid(GREY, 3))?;
        midnight += 24.0;
    }
    Ok(())
}

/// Insulin as a line from below, meals as bars from above with their grams.
fn doses(
    canvas: &Canvas<'_>,
    panel: &Panel,
    day: &ExampleDay,
    hours: &[f64],
) -> Result<(), ReportError> {
    panel.frame(canvas, "", "Insulin (U/h), carbohydrate (g)")?;
    midnights(canvas, panel)?;
    let half = if is_long(panel.x.range.0, panel.x.range.1) { 4 } else { 7 };
    let most = day.carbs_g.iter().copied().fold(0.0, f64::max);
    let mut free_from = i32::MIN;
    for (hour, grams) in hours.iter().zip(&day.carbs_g).filter(|(_, grams)| **grams > 0.0) {
        let (x, _) = panel.at(*hour, panel.y.range.0);
        // Divided first: the product of a large number would overflow.
        let height = f64::from(panel.bottom - panel.top) * 0.3 * (grams / most);
        let end = panel.top + height.round() as i32;
        canvas.rectangle((x - half, panel.top), (x + half, end), ORANGE, 1.0)?;
        // A meal logged over several steps is labelled once, and so are meals close together.
        if x >= free_from {
            canvas.text(&fixed(*grams, 0), (x, end + 6), (HPos::Center, VPos::Top))?;
            free_from = x + 50;
        }
    }
    let rate = day.insulin_u_h.iter().map(|rate| Some(*rate));
    panel.line(canvas, hours.iter().copied().zip(rate), INSULIN)
}

/// Sleep as shaded steps, heart rate as a line.
fn activity(
    canvas: &Canvas<'_>,
    panel: &Panel,
    day: &ExampleDay,
    hours: &[f64],
) -> Result<(), ReportError> {
    let height = f64::from(panel.bottom - panel.top);
    let mut start = 0;
    for run in day.sleep_efficiency.chunk_by(|a, b| a == b) {
        let end = start + run.len();
        if let Some(share) = run[0].filter(|share| *share > 0.0) {
            let (from, _) = panel.at(hours[start], panel.y.range.0);
            let to = hours.get(end).map_or(panel.right, |h| panel.at(*h, panel.y.range.0).0);
            let top = panel.bottom - (height * share.min(1.0)).round() as i32;
            canvas.rectangle((from, top), (to, panel.bottom), SKY, 0.55)?;
        }
        start = end;
    }
    panel.frame(canvas, "Time of day", "Heart rate over baseline (1/min), sleep")?;
    if !has_value(&day.heart_rate_over_baseline) && !has_value(&day.sleep_efficiency) {
        return note(canvas, panel, "not recorded");
    }
    midnights(canvas, panel)?;
    let values = day.heart_rate_over_baseline.iter().copied();
    panel.line(canvas, hours.iter().copied().zip(values), HEART_RATE)
}

/// Words in place of data.
fn note(canvas: &Canvas<'_>, panel: &Panel, text: &str) -> Result<(), ReportError> {
    let middle = ((panel.left + panel.right) / 2, (panel.top + panel.bottom) / 2);
    canvas.text(text, middle, (HPos::Center, VPos::Center))
}

/// Hours since midnight of the first day: the clock of the first step, and five minutes a step.
fn hour_of(day: &ExampleDay, index: usize) -> f64 {
    let read = |text: &String| -> Option<f64> {
        let (hours, minutes) = text.split_once(':')?;
        let minutes = minutes.get(..2)?;
        Some(f64::from(hours.parse::<u32>().ok()?) + f64::from(minutes.parse::<u32>().ok()?) / 60.0)
    };
    day.time.first().and_then(read).unwrap_or(0.0) + index as f64 / 12.0
}

fn present(values: &[Option<f64>]) -> impl Iterator<Item = f64> + '_ {
    values.iter().flatten().copied()
}

fn has_value(values: &[Option<f64>]) -> bool {
    values.iter().any(Option::is_some)
}
