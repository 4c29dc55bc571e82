//! Maps of the gap through the day: by situation, and a strip a person.

use crate::html::{Heat, HeatCell, Html};
use crate::number::{count, fixed};
use crate::section::words::{ahead, context, sentence};
use contract::diagnosis::{HourlyCell, HourlyGap, HourlyRow};

/// People whose strips stand on the page; those of the others are folded away.
const SHOWN: usize = 30;
/// Ends that the scale may have, mg/dL.
const ENDS: [f64; 8] = [5.0, 10.0, 15.0, 20.0, 30.0, 40.0, 60.0, 100.0];
/// Share of the cells that the scale holds; a few extremes must not make all others pale.
const HELD: f64 = 0.95;

/// Both maps with one scale.
pub(super) fn maps(html: &mut Html, gap: &HourlyGap) {
    let end = end(gap);
    let when = ahead(gap.horizon_minutes);
    if !gap.situations.is_empty() {
        html.element("h3", "Hour of the day by situation");
        html.paragraph(&says(gap));
        let caption = format!(
            "Observed \u{2212} predicted glucose {when} ahead, mg/dL, by hour of the day and situation"
        );
        html.heat(&caption, &table(gap, &gap.situations, "Situation", situation, end));
        html.shades(end);
        html.paragraph_of("note", READING);
    }
    if !gap.people.is_empty() {
        html.element("h3", "Hour of the day by person");
        strips(html, gap, &when, end);
    }
}

/// How a map is read.
const READING: &str = "Read along a row for the hours, down a column for the situations. A plus (blue): glucose is \
    higher than the model says; a minus (orange): it is lower; the deeper, the more, and the deepest holds all beyond. A \
    frame: the interval leaves 0 out, however many cells are looked at. A dash: too few runs. Exact values and intervals show under a pointer. \
    A situation whose row looks like the first row makes no difference of its own.";

/// Strips of all people; the largest errors first where they do not all fit.
fn strips(html: &mut Html, gap: &HourlyGap, when: &str, end: f64) {
    let all = gap.people.len();
    let mut rows: Vec<&HourlyRow> = gap.people.iter().collect();
    if all > SHOWN {
        rows.sort_by(|a, b| size(b).total_cmp(&size(a)));
    }
    let (shown, others) = rows.split_at(all.min(SHOWN));
    html.paragraph(&alike(gap));
    let map = |html: &mut Html, which: &str, rows: &[&HourlyRow]| {
        let rows = rows.iter().copied();
        html.heat(
            &format!(
                "Observed \u{2212} predicted glucose {when} ahead, mg/dL, by hour of the day, {which}"
            ),
            &table(gap, rows, "Person", |row| row.name.clone(), end),
        );
    };
    let which = match others.len() {
        0 => "one row a person".to_owned(),
        _ => format!("the {SHOWN} of {all} people whom the model misses most"),
    };
    map(html, &which, shown);
    html.shades(end);
    if !others.is_empty() {
        let people = count(others.len(), "person", "people");
        html.folded(&format!("The other {people}"), |html| {
            map(html, "the other people, largest errors first", others);
        });
    }
    html.paragraph_of(
        "note",
        "Colours, signs and frames as above; a frame holds for all people together. Columns of one colour: the model \
         misses the same in everybody. Rows that differ: people differ.",
    );
}

fn table<'a>(
    gap: &HourlyGap,
    rows: impl IntoIterator<Item = &'a HourlyRow>,
    corner: &str,
    name: impl Fn(&HourlyRow) -> String,
    end: f64,
) -> Heat {
    let rows = rows.into_iter().map(|row| {
        let name = name(row);
        let cells = gap.parts.iter().zip(&row.cells);
        let cells = cells.map(|(part, cell)| shown(&name, part, cell.as_ref(), end)).collect();
        (name, cells)
    });
    // A narrow column may break after the dash.
    let columns = gap.parts.iter().map(|part| hours(part).replace('\u{2013}', "\u{2013}\u{200b}"));
    let (rows, columns) = (rows.collect(), columns.collect());
    Heat { corner: corner.to_owned(), columns, rows, narrow: true }
}

fn shown(name: &str, part: &str, cell: Option<&HourlyCell>, end: f64) -> HeatCell {
    let place = format!("{name}, {} h", hours(part));
    let Some(cell) = cell else {
        let hover = format!("{place}: too few runs");
        return HeatCell { text: "\u{2013}".to_owned(), hover, ..HeatCell::default() };
    };
    let whom = match cell.people {
        1 => String::new(),
        n => format!(" of {n} people"),
    };
    let text = signed(cell.mean_error_mg_dl, 0);
    // What is printed as nothing has no colour.
    let shade = if text == "0" { 0.0 } else { cell.mean_error_mg_dl / end };
    HeatCell {
        text,
        shade,
        framed: cell.is_certain(),
        hover: format!(
            "{place}: {} mg/dL (interval {} to {}), {} runs{whom}",
            signed(cell.mean_error_mg_dl, 1),
            signed(cell.lower, 1),
            signed(cell.upper, 1),
            cell.runs
        ),
    }
}

/// A number with its sign, also where that is a plus.
fn signed(value: f64, digits: usize) -> String {
    let text = fixed(value, digits);
    let is_zero = text.bytes().all(|b| b == b'0' || b == b'.');
    if value > 0.0 && !is_zero { format!("+{text}") } else { text }
}

/// `03-06` becomes `3–6`.
fn hours(part: &str) -> String {
    let short = |hour: &str| hour.strip_prefix('0').unwrap_or(hour).to_owned();
    match part.split_once('-') {
        Some((from, to)) => format!("{}\u{2013}{}", short(from), short(to)),
        None => part.to_owned(),
    }
}

fn situation(row: &HourlyRow) -> String {
    match row.name.as_str() {
        "all" => "All runs".to_owned(),
        name => sentence(&context(name)),
    }
}

/// Where most is missing, in words.
fn says(gap: &HourlyGap) -> String {
    let cells = gap.situations.iter().flat_map(|row| {
        let cells = gap.parts.iter().zip(&row.cells);
        cells.filter_map(move |(part, cell)| Some((row, part, cell.as_ref()?)))
    });
    let most = cells
        .filter(|(_, _, cell)| cell.is_certain())
        .max_by(|a, b| a.2.mean_error_mg_dl.abs().total_cmp(&b.2.mean_error_mg_dl.abs()));
    match most {
        Some((row, part, cell)) => {
            let direction = if cell.mean_error_mg_dl > 0.0 { "under" } else { "over" };
            let among = match row.name.as_str() {
                "all" => "over all situations".to_owned(),
                _ => format!("in the row \u{201c}{}\u{201d}", situation(row)),
            };
            format!(
                "The largest error that stands out is from {} h {among}: glucose is {direction}-predicted \
                 by {} mg/dL.",
                hours(part).replace('\u{2013}', " to "),
                fixed(cell.mean_error_mg_dl.abs(), 0)
            )
        }
        None => "No cell stands out: every interval holds 0.".to_owned(),
    }
}

/// The part of the day in which most people are missed on the same side.
fn alike(gap: &HourlyGap) -> String {
    let of = gap.people.len();
    let sides = gap.parts.iter().enumerate().flat_map(|(index, part)| {
        [("under", 1.0), ("over", -1.0)].map(|(word, side)| {
            let certain = gap.people.iter().filter(|row| {
                let cell = row.cells.get(index).copied().flatten();
                cell.is_some_and(|c| c.is_certain() && side * c.mean_error_mg_dl > 0.0)
            });
            (certain.count(), word, part)
        })
    });
    let most = sides.max_by_key(|(people, _, _)| *people);
    match most.filter(|(people, _, _)| *people > 0) {
        Some((people, word, part)) => format!(
            "From {} h glucose is {word}-predicted in {people} of {}; in no other part of the day are there more.",
            hours(part).replace('\u{2013}', " to "),
            count(of, "person", "people")
        ),
        None => "In nobody does a part of the day stand out by itself.".to_owned(),
    }
}

/// Root mean square of a person's cells.
fn size(row: &HourlyRow) -> f64 {
    let values: Vec<f64> = row.cells.iter().flatten().map(|cell| cell.mean_error_mg_dl).collect();
    let squares: f64 = values.iter().map(|value| value * value).sum();
    (squares / values.len().max(1) as f64).sqrt()
}

/// The end of the scale, mg/dL.
fn end(gap: &HourlyGap) -> f64 {
    let held = |rows: &[HourlyRow]| -> f64 {
        let cells = rows.iter().flat_map(|row| row.cells.iter().flatten());
        let mut sizes: Vec<f64> = cells.map(|cell| cell.mean_error_mg_dl.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let held = (HELD * sizes.len() as f64).ceil() as usize;
        held.checked_sub(1).and_then(|index| sizes.get(index)).copied().unwrap_or_default()
    };
    let largest = held(&gap.situations).max(held(&gap.people));
    ENDS.into_iter().find(|end| *end >= largest).unwrap_or(ENDS[ENDS.len() - 1])
}
