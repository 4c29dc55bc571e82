//! Rows of conformance as text: of a population model, and of a person's twin.

use std::fmt::Write as _;
use std::time::Duration;

use conformance::{Proofs, Row, Verdict};

/// How many rows are decided, and in what time their certificates were checked.
pub(crate) fn counted(rows: &[Row], proofs: &Proofs, took: Duration) -> String {
    let count = |verdict| rows.iter().filter(|row| row.verdict == verdict).count();
    format!(
        "{} proved ({} certificates checked in {:.1} s), {} violated, {} undecided of {} rows",
        count(Verdict::Proved),
        proofs.accepted,
        took.as_secs_f64(),
        count(Verdict::Violated),
        count(Verdict::Undecided),
        rows.len()
    )
}

/// A table of the rows. The columns of networks and inputs have these widths; the titles are that of the networks and
/// those of two columns of the caller's; `cells` gives a row's cells in those two, and its seconds.
pub(crate) fn table(
    rows: &[Row],
    [network, input]: [usize; 2],
    [title, first, second]: [&str; 3],
    cells: impl Fn(&Row) -> [String; 3],
) -> String {
    let mut text = format!(
        "{title:<network$} {:<input$} {:<11} {:<10} {:>14} {:>14} {first:>9} {second:>9}  seconds\n",
        "input", "property", "verdict", "M at least", "M at most"
    );
    for row in rows {
        let property = format!("{:?}", row.property).to_lowercase();
        let verdict = format!("{:?}", row.verdict).to_lowercase();
        let [first, second, seconds] = cells(row);
        let _ = writeln!(
            text,
            "{:<network$} {:<input$} {property:<11} {verdict:<10} {:>14.7} {:>14.7} {first:>9} \
             {second:>9}  {seconds}",
            row.network, row.input, row.m_lower, row.m_upper
        );
    }
    text
}

/// A share, 0 to 1, as a cell.
pub(crate) fn percent(share: Option<f64>) -> String {
    share.map_or("-".to_owned(), |share| format!("{:.3}%", 100.0 * share))
}
