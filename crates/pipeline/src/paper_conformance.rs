//! The paper's table of conformance beside a run of ours, row by row.
//!
//! Values from the appendix "Conformance verification results" of the paper: critical errors in physical units, `None` for a
//! check mark. The paper's two rows of C2 have their arrows swapped against its own equations (and ours): they are kept as
//! printed.

use conformance::Direction::{Decreasing, Increasing};
use conformance::{Direction, PropertyKind, Row, Verdict};

/// A row of the paper: network, input, direction, training region, generalisation region.
type PaperRow = (&'static str, &'static str, Direction, Option<f64>, Option<f64>);

const TABLE: [PaperRow; 31] = [
    ("Q1", "X1", Decreasing, None, Some(1e-12)),
    ("Q1", "X1", Increasing, Some(2e-2), Some(5e-3)),
    ("Q1", "X3", Decreasing, Some(2e-4), None),
    ("Q1", "Q1", Decreasing, Some(8e-6), Some(2e-5)),
    ("Q1", "Q1", Increasing, Some(4e-5), None),
    ("Q1", "Q2", Increasing, Some(6e-13), None),
    ("Q1", "C2", Increasing, Some(1e-13), None),
    ("Q2", "X1", Increasing, Some(6e-6), None),
    ("Q2", "X1", Decreasing, Some(9e-6), Some(1e-5)),
    ("Q2", "X2", Decreasing, Some(1e-5), Some(2e-5)),
    ("Q2", "X2", Increasing, Some(2e-5), Some(2e-6)),
    ("Q2", "Q1", Increasing, None, None),
    ("Q2", "Q1", Decreasing, None, Some(2e-7)),
    ("Q2", "Q2", Decreasing, None, None),
    ("Q2", "Q2", Increasing, Some(3e-7), Some(4e-7)),
    ("S1", "S1", Decreasing, Some(1e-5), None),
    ("S1", "u_insulin", Increasing, Some(1e-2), None),
    ("S2", "S1", Increasing, None, Some(9e-6)),
    ("S2", "S2", Decreasing, None, None),
    ("I", "S2", Increasing, None, None),
    ("I", "I", Decreasing, None, Some(2e-5)),
    ("X1", "I", Increasing, Some(7e-19), None),
    ("X1", "X1", Decreasing, None, Some(5e-9)),
    ("X2", "I", Increasing, None, None),
    ("X2", "X2", Decreasing, None, None),
    ("X3", "I", Increasing, None, None),
    ("X3", "X3", Decreasing, Some(1e-7), Some(4e-7)),
    ("C2", "C1", Decreasing, None, Some(7e-12)),
    ("C2", "C2", Increasing, Some(9e-9), Some(2e-8)),
    ("C1", "C1", Decreasing, None, None),
    ("C1", "u_carbs", Increasing, None, None),
];

/// The table as text: theirs, ours, and what follows beside their training region, or their generalisation region if ours was
/// widened.
pub(crate) fn beside_the_paper(rows: &[Row], widened: bool) -> String {
    use std::fmt::Write as _;
    let mut text = format!(
        "Beside the paper's appendix ({}); z in physical units per minute for a step of ten times the smallest\n\
         change of the input. 'conformant' is the paper's rule: z below the smallest change of the output.\n\
         {:<4} {:<10} {:<11} {:>14} {:>14}  {:>22}  {:>8} {:<10} {}\n",
        if widened { "generalisation region" } else { "training region" },
        "net",
        "input",
        "property",
        "paper training",
        "generalisation",
        "our z, certified",
        "smallest",
        "verdict",
        "what follows"
    );
    for (network, input, direction, training, general) in &TABLE {
        let found = rows.iter().find(|row| {
            row.network == *network && row.input == *input && row.property == *direction
        });
        let told = |z: &Option<f64>| z.map_or("ok".to_owned(), |z| format!("{z:.0e}"));
        let (in_training, beyond) = (told(training), told(general));
        let theirs = if widened { general } else { training };
        let Some(row) = found else { continue };
        let (z, least) = match (&row.physical_step, row.smallest_change) {
            (Some(step), least) => (
                format!("{:.1e} to {:.1e}", step.z_lower, step.z_upper),
                least.map_or("-".to_owned(), |least| format!("{least:.0e}")),
            ),
            (None, _) => ("-".to_owned(), "-".to_owned()),
        };
        writeln!(
            text,
            "{network:<4} {input:<10} {:<11} {in_training:>14} {beyond:>14}  {z:>22}  {least:>8} {:<10} {}{}",
            format!("{direction:?}").to_lowercase(),
            format!("{:?}", row.verdict).to_lowercase(),
            follows(row, theirs.is_none()),
            match row.kind {
                PropertyKind::Physical => "",
                PropertyKind::OppositeInformational => " (the opposite sign of the equations)",
            },
        )
        .expect("writing to a String cannot fail");
    }
    text
}

/// What a row says beside the paper's.
fn follows(row: &Row, conformant: bool) -> &'static str {
    let by_their_rule = match (&row.physical_step, row.smallest_change) {
        (Some(step), Some(least)) => step.z_lower < least,
        _ => false,
    };
    match (row.verdict, conformant) {
        (Verdict::Undecided, _) => "open",
        (Verdict::Proved, true) => "confirmed: proved",
        (Verdict::Proved, false) => "holds here: proved",
        (Verdict::Violated, false) => "confirmed: fails",
        (Verdict::Violated, true) if by_their_rule => "fails, by less than their rule sees",
        (Verdict::Violated, true) => "contradicted by a counterexample",
    }
}

/// The paper's summary: for each network the largest z of its physical rows, in physical units per minute.
pub(crate) fn summary(rows: &[Row]) -> String {
    use std::fmt::Write as _;
    let mut text = format!(
        "Largest z of each network's physical rows, physical units per minute\n{:<4} {:<32} paper\n",
        "net", "ours"
    );
    let mut seen: Vec<&str> = Vec::new();
    for row in rows {
        if seen.contains(&row.network.as_str()) {
            continue;
        }
        seen.push(&row.network);
        let physical = rows
            .iter()
            .filter(|other| other.network == row.network && other.kind == PropertyKind::Physical);
        let worst = physical
            .clone()
            .max_by(|a, b| worst(a).total_cmp(&worst(b)))
            .filter(|row| row.verdict != Verdict::Proved);
        let all = physical.clone().all(|row| row.verdict == Verdict::Proved);
        let told = match worst {
            _ if all => "proved for every input".to_owned(),
            Some(row) => format!("{:.1e} against {}", self::worst(row), row.input),
            None => "open".to_owned(),
        };
        let paper = papers_largest(&row.network)
            .map_or_else(|| "conformant".to_owned(), |error| format!("{error:.0e}"));
        writeln!(text, "{:<4} {told:<32} {paper}", row.network)
            .expect("writing to a String cannot fail");
    }
    text
}

/// The paper's summary of a network: the largest of its critical errors in either region; `None` for a
/// check mark.
fn papers_largest(network: &str) -> Option<f64> {
    let rows = TABLE.iter().filter(|row| row.0 == network);
    rows.flat_map(|row| [row.3, row.4]).flatten().max_by(f64::total_cmp)
}

fn worst(row: &Row) -> f64 {
    row.physical_step.as_ref().map_or(0.0, |step| step.z_lower)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_appendix_gives_the_papers_summary() {
        // Table `conformance_summary` of the paper.
        let summary = [
            ("Q1", Some(2e-2)),
            ("Q2", Some(2e-5)),
            ("S1", Some(1e-2)),
            ("S2", Some(9e-6)),
            ("I", Some(2e-5)),
            ("X1", Some(5e-9)),
            ("X2", None),
            ("X3", Some(4e-7)),
            ("C1", None),
            ("C2", Some(2e-8)),
        ];
        for (network, error) in summary {
            assert_eq!(papers_largest(network), error, "{network}");
        }
    }
}
