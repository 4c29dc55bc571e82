//! How often an effect is found, by the shift of glucose that it causes.

use super::super::words::{effect, sentence};
use crate::distinct::distinct;
use crate::figure::palette::{BLUE, GREEN, Key, Marker, Stroke, VERMILLION, dashed, solid};
use crate::figure::{Axis, Drawn, Panel, WIDTH, draw};
use crate::html::{Column, Heat, HeatCell, Html};
use crate::number::{compact, optional, share};
use contract::BlindCheck;
use contract::blind_check::{PowerRow, Share};

/// One line of the figure: its name, what it counts, stroke, marker, and its offset, so that
/// intervals do not cover each other.
type Line = (&'static str, fn(&PowerRow) -> &Share, Stroke, Marker, i32);

const LINES: [Line; 3] = [
    ("Something was found", |row| &row.detected, dashed(GREEN, 4, 6, 8), Marker::Square, -12),
    (
        "Named, or in the set that cannot be told apart",
        |row| &row.named_or_in_set,
        dashed(VERMILLION, 4, 20, 8),
        Marker::Triangle,
        0,
    ),
    ("Named, and no other", |row| &row.named, solid(BLUE, 5), Marker::Disc, 12),
];

pub(in super::super) fn body(html: &mut Html, check: &BlindCheck) {
    if check.power.is_empty() {
        html.absent("No world with a single effect was answered.");
        return;
    }
    let (together, single): (Vec<&PowerRow>, Vec<&PowerRow>) =
        check.power.iter().partition(|row| row.effect.is_none());
    html.figure(
        by_shift(&together),
        "Share of worlds with a single effect in which it was found, by the mean shift of \
         glucose that it causes, with 95 % intervals. The lines should rise to the right.",
    );
    html.rows(
        "All effects together: worlds, and share with its 95 % interval",
        &together,
        &[
            ("Shift, mg/dL", Column::Text, &|row| bin(row)),
            ("Mean shift, mg/dL", Column::Number, &|row| optional(row.mean_shift_mg_dl, 1)),
            ("Named, and no other", Column::Number, &|row| share(&row.named)),
            ("Named or in set", Column::Number, &|row| share(&row.named_or_in_set)),
            ("Something found", Column::Number, &|row| share(&row.detected)),
        ],
    );
    by_effect(html, &single);
}

/// Draws the rows of all effects together, or `None` without one.
fn by_shift(rows: &[&PowerRow]) -> Option<Drawn> {
    if rows.is_empty() {
        return None;
    }
    let x = Axis::over(rows.iter().map(|row| row.mean_shift_mg_dl).chain([0.0]), 6);
    let y = Axis::over([0.0, 100.0], 5);
    let panel = Panel::new((110, WIDTH - 50), (60, 480), x, y);
    let keys = LINES.map(|(name, _, stroke, marker, _)| Key::marker(name, stroke, marker));
    let label = "Share of effects found by the shift that they cause";
    Some(draw(label, 590, keys.to_vec(), |canvas| {
        panel.frame(canvas, "Mean shift of glucose (mg/dL)", "Found (% of worlds)");
        for (_, share, stroke, marker, aside) in LINES {
            let at = |row: &PowerRow, value: f64| {
                let (x, y) = panel.at(row.mean_shift_mg_dl, 100.0 * value.clamp(0.0, 1.0));
                (x + aside, y)
            };
            let points = rows.iter().filter_map(|row| share(row).value.map(|v| at(row, v)));
            let points: Vec<_> = points.collect();
            if points.len() > 1 {
                canvas.path(points.clone(), stroke);
            }
            for row in rows {
                let interval = [at(row, share(row).lower), at(row, share(row).upper)];
                canvas.path(interval, solid(stroke.colour, 3));
            }
            for point in points {
                canvas.marker(point, marker, stroke.colour);
            }
        }
    }))
}

fn by_effect(html: &mut Html, rows: &[&PowerRow]) {
    let names = distinct(rows.iter().map(|row| row.effect.as_deref().unwrap_or_default()));
    if names.is_empty() {
        return;
    }
    let mut bins = rows.to_vec();
    bins.sort_by(|a, b| a.from_mg_dl.total_cmp(&b.from_mg_dl));
    bins.dedup_by_key(|bin| bin.from_mg_dl);
    let cell = |name: &str, bin: &PowerRow| {
        let row = rows
            .iter()
            .find(|row| row.effect.as_deref() == Some(name) && row.from_mg_dl == bin.from_mg_dl);
        row.map_or_else(HeatCell::default, |row| {
            let named = &row.named;
            let mut text = format!("{}/{}", named.count, named.of);
            if row.named_or_in_set.count > named.count {
                text.push_str(&format!(" +{}", row.named_or_in_set.count - named.count));
            }
            HeatCell { text, shade: named.value.unwrap_or(0.0), ..HeatCell::default() }
        })
    };
    let cells = |name| bins.iter().map(|bin| cell(name, bin)).collect::<Vec<_>>();
    let rows = names.into_iter().map(|name| (sentence(&effect(name)), cells(name))).collect();
    let columns = bins.iter().map(|row| bin(row)).collect();
    html.heat(
        "Worlds in which the effect was named and no other, of how many, by effect and shift (mg/dL); \
         \u{201c}+1\u{201d}: one more has it in the set that cannot be told apart",
        &Heat { corner: "Effect".to_owned(), columns, rows, ..Heat::default() },
    );
}

/// The bin, mg/dL.
fn bin(row: &PowerRow) -> String {
    let from = compact(row.from_mg_dl);
    match row.to_mg_dl {
        Some(to) if row.from_mg_dl == 0.0 => format!("<{}", compact(to)),
        Some(to) => format!("{from}\u{2013}{}", compact(to)),
        None => format!("\u{2265}{from}"),
    }
}
