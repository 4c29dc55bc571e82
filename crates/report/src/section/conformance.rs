//! Which physiological properties of the networks are proved, and where they are violated.

use contract::Conformance;
use contract::conformance::{Direction, Grounds, Row, Slice, Verdict, Witness};
use plotters::style::text_anchor::{HPos, VPos};

use crate::figure::palette::{BLUE, Key, Marker, VERMILLION, solid};
use crate::figure::{Axis, Drawn, Panel, WIDTH, draw};
use crate::html::{Column, ColumnOf, Html};
use crate::number::{ABSENT, significant};

/// Panels in a row.
const COLUMNS: i32 = 2;
/// Height of a panel with its titles, canvas units.
const HEIGHT: i32 = 330;

pub(super) fn body(html: &mut Html, conformance: &Conformance) {
    html.paragraph(
        "M is the largest slope against the property anywhere in the region (scaled output per \
         minute per scaled input). The upper end of its bracket is certified and the lower end is \
         attained: proved where the upper end is not above zero, violated where the lower end is \
         above zero, undecided in between.",
    );
    let (physical, opposite): (Vec<&Row>, Vec<&Row>) =
        conformance.rows.iter().partition(|row| row.is_physical());
    table(html, "Physiological properties; bold: not proved", &physical);
    let caption = "Opposite sign, for comparison only: these are expected to be violated";
    table(html, caption, &opposite);
    html.figure(
        slices(physical.into_iter().filter(|row| row.verdict == Verdict::Violated)),
        "Counterexamples: each output along the tested input across the region, the other inputs as \
         they are where the slope against the property is largest. Scaled units.",
    );
}

/// One row a property. Rows of twins begin with the person.
fn table(html: &mut Html, caption: &str, rows: &[&Row]) {
    let property = |row: &Row| match row.property {
        Direction::Increasing => "increasing",
        Direction::Decreasing => "decreasing",
    };
    let verdict = |row: &Row| match (row.verdict, row.grounds) {
        (Verdict::Proved, Some(Grounds::Certificate)) => "proved, certified",
        (Verdict::Proved, Some(Grounds::Construction)) => "proved by construction",
        (Verdict::Proved, Some(Grounds::Summands)) => "proved by its parts",
        (Verdict::Proved, _) => "proved",
        (Verdict::Violated, _) => "violated",
        (Verdict::Undecided, _) => "undecided",
    };
    // Of a twin it is the steps of the record, of a network those that were simulated.
    let fails = |row: &Row| row.share_of_steps.or(row.share_of_points.map(|share| share.value));
    let columns: [ColumnOf<'_, &Row>; 8] = [
        ("Person", Column::Text, &|row| row.person_id.clone().unwrap_or_else(|| ABSENT.to_owned())),
        ("Network", Column::Text, &|row| row.network.clone()),
        ("Input", Column::Text, &|row| row.input.clone()),
        ("Property", Column::Text, &|row| property(row).to_owned()),
        ("Verdict", Column::Text, &|row| verdict(row).to_owned()),
        ("Bracket of M", Column::Number, &|row| {
            format!("{} to {}", significant(row.m_lower), significant(row.m_upper))
        }),
        ("Fails at steps, %", Column::Number, &|row| {
            significant(fails(row).map(|share| 100.0 * share))
        }),
        ("Seconds", Column::Number, &|row| significant(row.seconds)),
    ];
    let of_twins = rows.iter().any(|row| row.person_id.is_some());
    let bold = |row: &&Row| row.is_physical() && row.verdict != Verdict::Proved;
    html.marked_rows(caption, rows, bold, &columns[usize::from(!of_twins)..]);
}

/// Draws a panel for each row with a slice and a counterexample, or `None` without one.
fn slices<'a>(rows: impl Iterator<Item = &'a Row>) -> Option<Drawn> {
    let shown = rows.filter_map(|row| Some((row, row.witness.as_ref()?, row.slice.as_ref()?)));
    let shown: Vec<(&Row, &Witness, &Slice)> = shown
        .filter(|(_, _, slice)| slice.input.len() == slice.output.len() && slice.input.len() > 1)
        .collect();
    if shown.is_empty() {
        return None;
    }
    let lines = (shown.len() as i32 + COLUMNS - 1) / COLUMNS;
    let keys = vec![
        Key::line("Output, scaled per minute", solid(BLUE, 4)),
        Key::marker("Counterexample", solid(VERMILLION, 4), Marker::Disc),
    ];
    Some(draw("Outputs along the tested input", lines * HEIGHT + 20, keys, |canvas| {
        for (number, (row, witness, slice)) in shown.into_iter().enumerate() {
            let (line, column) = (number as i32 / COLUMNS, number as i32 % COLUMNS);
            let width = WIDTH / COLUMNS;
            let across = (column * width + 120, (column + 1) * width - 25);
            let down = (line * HEIGHT + 60, line * HEIGHT + HEIGHT - 90);
            let x = Axis::over(slice.input.iter().copied(), 3);
            let y = Axis::over(slice.output.iter().copied(), 3);
            let panel = Panel::new(across, down, x, y);
            let asked = if row.property == Direction::Increasing { "rise" } else { "fall" };
            panel.frame(canvas, &row.input, "");
            let title = format!("{} has to {asked}", row.network);
            canvas.text(&title, (panel.left, panel.top - 12), (HPos::Left, VPos::Bottom));
            let mut points = slice.input.iter().zip(&slice.output);
            panel.line(canvas, points.clone().map(|(x, y)| (*x, Some(*y))), solid(BLUE, 4));
            if let Some((x, y)) = points.find(|(x, _)| **x >= witness.from) {
                canvas.marker(panel.at(*x, *y), Marker::Disc, VERMILLION);
            }
        }
    }))
}
