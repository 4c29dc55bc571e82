//! How often an effect is found, by the shift of glucose that it causes.

use super::super::words::{effect, sentence};
use crate::distinct::distinct;
use crate::html::{Column, Heat, HeatCell, Html};
use crate::number::{compact, optional, share};
use crate::{ReportError, figure};
use contract::BlindCheck;
use contract::blind_check::PowerRow;

pub(in super::super) fn body(check: &BlindCheck) -> Result<Html, ReportError> {
    let mut html = Html::default();
    if check.power.is_empty() {
        html.absent("No world with a single effect was answered.");
        return Ok(html);
    }
    let (together, single): (Vec<&PowerRow>, Vec<&PowerRow>) =
        check.power.iter().partition(|row| row.effect.is_none());
    html.figure(
        figure::power(&together)?,
        "Share of worlds with a single effect in which it was found, by the mean shift of \
         glucose that it causes, with 95 % intervals. The lines should rise to the right.",
    );
    html.rows(
        "All effects together: worlds, and share with its 95 % interval",
        &together,
        |_| false,
        &[
            ("Shift, mg/dL", Column::Text, &|row| bin(row)),
            ("Mean shift, mg/dL", Column::Number, &|row| optional(row.mean_shift_mg_dl, 1)),
            ("Named, and no other", Column::Number, &|row| share(&row.named)),
            ("Named or in set", Column::Number, &|row| share(&row.named_or_in_set)),
            ("Something found", Column::Number, &|row| share(&row.detected)),
        ],
    );
    by_effect(&mut html, &single);
    Ok(html)
}

fn by_effect(html: &mut Html, rows: &[&PowerRow]) {
    let mut bins: Vec<&PowerRow> = Vec::new();
    for row in rows {
        if bins.iter().all(|bin| bin.from_mg_dl != row.from_mg_dl) {
            bins.push(row);
        }
    }
    let names = distinct(rows.iter().map(|row| row.effect.as_deref().unwrap_or_default()));
    if names.is_empty() {
        return;
    }
    bins.sort_by(|a, b| a.from_mg_dl.total_cmp(&b.from_mg_dl));
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
    let cells = names
        .iter()
        .map(|name| {
            let cells = bins.iter().map(|bin| cell(name, bin)).collect();
            (sentence(&effect(name)), cells)
        })
        .collect();
    let columns = bins.iter().map(|row| bin(row)).collect();
    html.heat(
        "Worlds in which the effect was named and no other, of how many, by effect and shift (mg/dL); \
         \u{201c}+1\u{201d}: one more has it in the set that cannot be told apart",
        &Heat { corner: "Effect".to_owned(), columns, rows: cells, ..Heat::default() },
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
