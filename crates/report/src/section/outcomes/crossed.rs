//! Outcomes in rows, methods in columns, as in the paper's tables.

use contract::outcomes::OutcomeRow;

use super::Judged;
use crate::distinct::distinct;
use crate::html::{Crossed, CrossedCell, CrossedRow};
use crate::number::{ABSENT, compact, p_value, spread};

/// Mark beside p where equivalence is concluded.
pub(super) const EQUIVALENT: &str = "\u{2713}";
/// Mark beside p where so few people cannot show equivalence.
pub(super) const TOO_FEW: &str = "\u{2020}";

/// The table of some methods over the same windows, or `None` without a method.
pub(super) fn crossed(methods: &[Judged<'_>]) -> Option<Crossed> {
    if methods.is_empty() {
        return None;
    }
    let outcomes = methods.iter().flat_map(|method| method.rows);
    let metrics = distinct(outcomes.map(|row| row.metric.as_str()));
    let mut columns = vec!["Records".to_owned()];
    columns.extend(methods.iter().map(|method| method.label.to_owned()));
    let mut rows: Vec<CrossedRow> =
        metrics.into_iter().filter_map(|metric| row(methods, metric)).collect();
    let mut cells = vec![CrossedCell::default()];
    cells.extend(methods.iter().map(|method| {
        plain(method.rmse_5h.map_or_else(|| ABSENT.to_owned(), |rmse| spread(rmse, 1)))
    }));
    rows.push(CrossedRow { name: "RMSE".to_owned(), note: "mg/dL".to_owned(), cells });
    Some(Crossed { corner: "Outcome".to_owned(), columns, rows })
}

/// A value without a note.
fn plain(value: String) -> CrossedCell {
    CrossedCell { value, ..CrossedCell::default() }
}

/// One outcome of every method.
fn row(methods: &[Judged<'_>], metric: &str) -> Option<CrossedRow> {
    let of_method: Vec<Option<&OutcomeRow>> =
        methods.iter().map(|m| m.rows.iter().find(|row| row.metric == metric)).collect();
    let known = of_method.iter().copied().flatten().next()?;
    let digits = digits(known);
    let actual = spread(known.actual, digits);
    let mut cells = vec![plain(actual.clone())];
    for row in of_method {
        let Some(row) = row else {
            cells.push(plain(ABSENT.to_owned()));
            continue;
        };
        let mark = match (row.equivalent, row.cannot_be_shown()) {
            (true, _) => EQUIVALENT,
            (false, true) => TOO_FEW,
            (false, false) => "",
        };
        let p = match p_value(row.p) {
            p if p.starts_with('<') => format!("p {p}"),
            p => format!("p = {p}"),
        };
        let mut notes = vec![format!("{p} {mark}").trim_end().to_owned()];
        // A method that some people lack is compared with the others alone.
        let own = spread(row.actual, digits);
        if own != actual {
            notes.push(format!("records {own}"));
        }
        cells.push(CrossedCell {
            value: spread(row.simulated, digits),
            notes,
            marked: row.equivalent,
        });
    }
    let margin = format!("\u{b1}{} {}", compact(known.margin), known.unit).trim_end().to_owned();
    Some(CrossedRow { name: metric.to_uppercase(), note: margin, cells })
}

/// Digits after the point of an outcome.
pub(super) fn digits(row: &OutcomeRow) -> usize {
    if row.margin < 2.0 { 2 } else { 1 }
}
