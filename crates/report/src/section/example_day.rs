//! Days of one person, measured and simulated, in four panels: glucose; insulin; carbohydrate; heart
//! rate and sleep.

use contract::ExampleDay;
use contract::example_day::TimeInRanges;
use plotters::style::RGBColor;
use plotters::style::text_anchor::{HPos, VPos};

use crate::figure::palette::{
    BLUE, CLOSEST, GREEN, GREY, Key, MEASURED, ODE, ORANGE, POPULATION, SHADE, SKY, Stroke, TWIN,
    VERMILLION, solid,
};
use crate::figure::{Axis, Canvas, Drawn, Panel, WIDTH, draw};
use crate::html::Html;
use crate::number::{clock, fixed, optional};

/// Edges that all panels share.
const LEFT: i32 = 110;
const RIGHT: i32 = WIDTH - 50;
/// Basal rate.
const BASAL: Stroke = solid(GREEN, 4);
/// Steps of which the glucose shows under one place of the pointer: a quarter of an hour.
const SHOWN: usize = 3;
/// Minutes of a day.
const MINUTES_A_DAY: f64 = 1440.0;
/// Heart rate.
const HEART_RATE: Stroke = solid(VERMILLION, 3);

pub(super) fn body(html: &mut Html, day: &ExampleDay) {
    if !html.figure(figure(day), &caption(day)) {
        html.absent("There is no example day in this folder.");
    }
}

fn caption(day: &ExampleDay) -> String {
    let mut text = format!(
        "Person {}, {}. Above, glucose: compare each broken line, which runs freely from the first \
         reading on, with the solid sensor line. Then boluses and basal insulin, and meals. Below, what \
         the twin knows besides: heart rate and sleep. Gaps are missing data; insulin and meals that nobody recorded count as none.",
        day.person_id, day.date
    );
    if day.days > 1 {
        text.push_str(" Upright lines stand at midnight.");
    }
    let outcomes = &day.outcomes;
    let named = [
        ("sensor", Some(outcomes.cgm)),
        ("digital twin", Some(outcomes.twin)),
        ("closest virtual patient", outcomes.closest),
        ("population network", Some(outcomes.population)),
        ("ODE with population parameters", Some(outcomes.ode)),
    ];
    let shares: Vec<String> = named
        .into_iter()
        .filter_map(|(name, shares)| {
            let TimeInRanges { tbr, tir, tar } = shares?;
            let [tbr, tir, tar] = [tbr, tir, tar].map(|share| fixed(share, 1));
            Some(format!("{name} {tbr}\u{a0}%, {tir}\u{a0}% and {tar}\u{a0}%"))
        })
        .collect();
    text.push_str(&format!(" TBR, TIR and TAR: {}. Chosen: {}.", shares.join("; "), day.chosen));
    text
}

/// Whether there are too many days to show single hours.
fn is_long((from, to): (f64, f64)) -> bool {
    to - from > 30.0
}

/// Draws the days, or `None` where they have no glucose.
fn figure(day: &ExampleDay) -> Option<Drawn> {
    let hours: Vec<f64> = (0..day.time.len()).map(|k| hour_of(day, k)).collect();
    let (first, last) = (*hours.first()?, *hours.last()?);
    let glucose = [
        (&day.cgm[..], MEASURED, "Sensor (CGM)"),
        (&day.twin, TWIN, "Digital twin"),
        (day.closest.as_deref().unwrap_or_default(), CLOSEST, "ODE, closest virtual patient"),
        (&day.population, POPULATION, "Population network"),
        (&day.ode, ODE, "ODE, population parameters"),
    ];
    let shown: Vec<_> = glucose.into_iter().filter(|(values, ..)| has_value(values)).collect();
    if shown.is_empty() {
        return None;
    }

    let x = Axis::clock(first, last);
    let panel = |top: i32, height: i32, y: Axis| {
        Panel::new((LEFT, RIGHT), (top, top + height), x.clone(), y)
    };
    let levels = shown.iter().flat_map(|(values, ..)| values.iter().flatten().copied());
    let upper = panel(60, 380, Axis::over(levels.chain([70.0, 180.0]), 9));
    // A bar of the largest amount leaves room for its number.
    let room = |amounts: &[f64], least: f64| {
        let most = amounts.iter().copied().fold(least, f64::max);
        Axis::over([0.0, 1.25 * most], 3)
    };
    let doses: Vec<f64> = day.bolus_u.iter().chain(&day.basal_u_h).copied().collect();
    let second = panel(525, 210, room(&doses, 1.0));
    let third = panel(820, 180, room(&day.carbs_g, 10.0));
    let rates = day.heart_rate_over_baseline.iter().flatten().copied();
    let lower = panel(1085, 210, Axis::over(rates.chain([1.0]), 4));

    let mut keys: Vec<Key> =
        shown.iter().map(|(_, stroke, name)| Key::line(name, *stroke)).collect();
    keys.push(Key::area("Target range, 70\u{2013}180 mg/dL", SHADE, 1.0));
    if day.bolus_u.iter().any(|units| *units > 0.0) {
        keys.push(Key::area("Bolus (U)", BLUE, 1.0));
    }
    if !day.basal_u_h.is_empty() {
        keys.push(Key::line("Basal (U/h)", BASAL));
    }
    if day.carbs_g.iter().any(|g| *g > 0.0) {
        keys.push(Key::area("Carbohydrate (g)", ORANGE, 1.0));
    }
    if has_value(&day.heart_rate_over_baseline) {
        keys.push(Key::line("Heart rate over baseline", HEART_RATE));
    }
    if has_value(&day.sleep_efficiency) {
        keys.push(Key::area("Asleep (height = share of the step)", SKY, 0.55));
    }
    let time = if is_long((first, last)) { "several days" } else { "one day" };
    let label = format!("Glucose, insulin, carbohydrate, heart rate and sleep over {time}");
    Some(draw(&label, 1395, keys, |canvas| {
        let (from, to) = (upper.at(first, 180.0), upper.at(last, 70.0));
        canvas.rectangle((LEFT, from.1), (RIGHT, to.1), SHADE, 1.0);
        upper.frame(canvas, "", "Glucose (mg/dL)");
        midnights(canvas, &upper);
        // The sensor last, so that no line hides it.
        for (values, stroke, _) in shown.iter().rev() {
            upper.line(canvas, hours.iter().copied().zip(values.iter().copied()), *stroke);
        }
        readings(canvas, &upper, day, &hours);

        // Basal as a line and boluses as bars, one axis for U/h and U.
        second.frame(canvas, "", "Boluses (U), basal (U/h)");
        midnights(canvas, &second);
        bars(canvas, &second, (&hours, &day.bolus_u), BLUE, 1, "U");
        let rate = day.basal_u_h.iter().map(|rate| Some(*rate));
        second.line(canvas, hours.iter().copied().zip(rate), BASAL);

        third.frame(canvas, "", "Carbohydrate (g)");
        midnights(canvas, &third);
        bars(canvas, &third, (&hours, &day.carbs_g), ORANGE, 0, "g");
        activity(canvas, &lower, day, &hours);
    }))
}

/// Where a step begins on the canvas; the right edge after the last.
fn start_of(panel: &Panel, hours: &[f64], step: usize) -> i32 {
    hours.get(step).map_or(panel.right, |hour| panel.at(*hour, panel.y.range.0).0)
}

/// The sensor's and the twin's glucose under the pointer.
fn readings(canvas: &Canvas<'_>, panel: &Panel, day: &ExampleDay, hours: &[f64]) {
    for index in (0..hours.len()).step_by(SHOWN) {
        let (from, to) = (start_of(panel, hours, index), start_of(panel, hours, index + SHOWN));
        let at = |series: &[Option<f64>]| optional(series.get(index).copied().flatten(), 0);
        let words =
            format!("{}: sensor {}, twin {} mg/dL", day.time[index], at(&day.cgm), at(&day.twin));
        canvas.hover((from, panel.top), (to, panel.bottom), &words);
    }
}

/// An upright line where one day ends and another begins.
fn midnights(canvas: &Canvas<'_>, panel: &Panel) {
    let (from, to) = panel.x.range;
    let mut midnight = 24.0 * (from / 24.0).floor() + 24.0;
    while is_long(panel.x.range) && midnight < to {
        let (x, _) = panel.at(midnight, panel.y.range.0);
        canvas.path([(x, panel.top), (x, panel.bottom)], solid(GREY, 3));
        midnight += 24.0;
    }
}

/// Amounts as bars from the bottom, with their numbers above where there is room.
fn bars(
    canvas: &Canvas<'_>,
    panel: &Panel,
    (hours, amounts): (&[f64], &[f64]),
    colour: RGBColor,
    digits: usize,
    unit: &str,
) {
    let half = if is_long(panel.x.range) { 4 } else { 7 };
    let mut free_from = i32::MIN;
    for (hour, amount) in hours.iter().zip(amounts).filter(|(_, amount)| **amount > 0.0) {
        let (x, top) = panel.at(*hour, *amount);
        canvas.rectangle((x - half, top), (x + half, panel.bottom), colour, 1.0);
        let words = fixed(*amount, digits);
        let time = clock((60.0 * *hour).round().rem_euclid(MINUTES_A_DAY));
        let says = format!("{time}: {words} {unit}");
        canvas.hover((x - 2 * half, top), (x + 2 * half, panel.bottom), &says);
        // A meal logged over several steps is labelled once, and so are meals close together; small
        // doses of an automated pump are not.
        let stands_out = panel.bottom - top > (panel.bottom - panel.top) / 6;
        if x >= free_from && stands_out {
            canvas.text(&words, (x, top - 6), (HPos::Center, VPos::Bottom));
            free_from = x + 64;
        }
    }
}

/// Sleep as shaded steps, heart rate as a line.
fn activity(canvas: &Canvas<'_>, panel: &Panel, day: &ExampleDay, hours: &[f64]) {
    let height = f64::from(panel.bottom - panel.top);
    let mut start = 0;
    for run in day.sleep_efficiency.chunk_by(|a, b| a == b) {
        let end = start + run.len();
        if let Some(share) = run[0].filter(|share| *share > 0.0) {
            let (from, to) = (start_of(panel, hours, start), start_of(panel, hours, end));
            let top = panel.bottom - (height * share.min(1.0)).round() as i32;
            canvas.rectangle((from, top), (to, panel.bottom), SKY, 0.55);
        }
        start = end;
    }
    panel.frame(canvas, "Time of day", "Heart rate over baseline (1/min), sleep");
    if !has_value(&day.heart_rate_over_baseline) && !has_value(&day.sleep_efficiency) {
        let middle = ((panel.left + panel.right) / 2, (panel.top + panel.bottom) / 2);
        canvas.text("not recorded", middle, (HPos::Center, VPos::Center));
        return;
    }
    midnights(canvas, panel);
    let values = day.heart_rate_over_baseline.iter().copied();
    panel.line(canvas, hours.iter().copied().zip(values), HEART_RATE);
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

fn has_value(values: &[Option<f64>]) -> bool {
    values.iter().any(Option::is_some)
}
