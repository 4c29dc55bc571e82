//! Truth against answer.

use super::super::words::{effect, sentence, short_effect};
use crate::html::{Heat, HeatCell, Html};
use contract::BlindCheck;

pub(in super::super) fn body(html: &mut Html, check: &BlindCheck) {
    let confusion = &check.confusion;
    if confusion.rows.is_empty() {
        html.absent("No world with one truth was answered.");
        return;
    }
    let rows = confusion.rows.iter().map(|row| {
        let all: usize = row.counts.iter().sum();
        // Right is the effect itself, or "unknown" for one that the library does not hold.
        let right = if row.truth.starts_with("outside:") { "unknown" } else { &row.truth };
        let cells = row.counts.iter().zip(&confusion.answers).map(|(count, answer)| {
            let share = *count as f64 / all.max(1) as f64;
            let framed = answer == right;
            HeatCell {
                text: if *count == 0 { "\u{b7}".to_owned() } else { count.to_string() },
                shade: if framed { share } else { -share },
                framed,
                ..HeatCell::default()
            }
        });
        (format!("{} ({all})", sentence(&effect(&row.truth))), cells.collect())
    });
    let rows = rows.collect();
    let columns = confusion.answers.iter().map(|answer| short_effect(answer)).collect();
    html.heat(
        "Worlds by truth (row, with their number) and answer (column)",
        &Heat { corner: "Truth".to_owned(), columns, rows, ..Heat::default() },
    );
    html.paragraph_of(
        "note",
        "Framed cells are right, others are not; the deeper the colour, the larger their share of \
         the row. Where \
         several effects were named the first counts. Worlds with two effects are scored apart.",
    );
}
