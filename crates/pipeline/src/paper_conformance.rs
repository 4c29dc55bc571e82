//! The paper's table of conformance beside a run of ours, row by row.
//!
//! Values from the appendix "Conformance verification results" of the paper: critical errors in physical units, `None` for a
//! check mark. The paper's two rows of C2 have their arrows swapped against its own equations (and ours): they are kept as
//! printed.

use std::fmt::Write as _;

use conformance::Direction::{Decreasing, Increasing};
use conformance::{Direction, PropertyKind, Row, Verdict};
use contract::conformance::StepBracket;

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
    let mut text = format!(
        "Beside the paper's appendix ({}); z in physical units per minute for a step of ten times the smallest\n\
         change of the input. 'conformant' is the paper's rule: z below the smallest change of the output.\n\
         net  input      property    paper training generalisation        our z, certified  smallest verdict    what follows\n",
        if widened { "generalisation region" } else { "training region" }
    );
    for (network, input, direction, training, general) in TABLE {
        let found = rows
            .iter()
            .find(|row| row.network == network && row.input == input && row.property == direction);
        let told = |z: Option<f64>| z.map_or("ok".to_owned(), |z| format!("{z:.0e}"));
        let (in_training, beyond) = (told(training), told(general));
        let theirs = if widened { general } else { training };
        let Some(row) = found else { continue };
        let step = row.physical_step;
        let z = step.map(|step| format!("{:.1e} to {:.1e}", step.z_lower, step.z_upper));
        let least = step.and(row.smallest_change).map(|least| format!("{least:.0e}"));
        let [z, least] = [z, least].map(|told| told.unwrap_or("-".to_owned()));
        let _ = writeln!(
            text,
            "{network:<4} {input:<10} {:<11} {in_training:>14} {beyond:>14}  {z:>22}  {least:>8} {:<10} {}{}",
            format!("{direction:?}").to_lowercase(),
            format!("{:?}", row.verdict).to_lowercase(),
            follows(row, theirs.is_none()),
            match row.kind {
                PropertyKind::Physical => "",
                PropertyKind::OppositeInformational => " (the opposite sign of the equations)",
            },
        );
    }
    text
}

/// What a row says beside the paper's.
fn follows(row: &Row, conformant: bool) -> &'static str {
    let (surely_below, perhaps_below) = match (&row.physical_step, row.smallest_change) {
        (Some(step), Some(least)) => (step.z_upper < least, step.z_lower < least),
        _ => (false, false),
    };
    match (row.verdict, conformant) {
        (Verdict::Undecided, _) => "open",
        (Verdict::Proved, true) => "confirmed: proved",
        (Verdict::Proved, false) => "holds here: proved",
        (Verdict::Violated, false) => "confirmed: fails",
        (Verdict::Violated, true) if surely_below => "fails, by less than their rule sees",
        (Verdict::Violated, true) if perhaps_below => "fails, perhaps by less than their rule sees",
        (Verdict::Violated, true) => "contradicted by a counterexample",
    }
}

/// The paper's summary: for each network the largest z of its physical rows, in physical units per minute.
pub(crate) fn summary(rows: &[Row]) -> String {
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
        let open: Vec<&Row> = physical.filter(|row| row.verdict != Verdict::Proved).collect();
        let steps: Option<Vec<(&Row, StepBracket)>> =
            open.iter().map(|row| Some((*row, row.physical_step?))).collect();
        let by_upper =
            |a: &(&Row, StepBracket), b: &(&Row, StepBracket)| a.1.z_upper.total_cmp(&b.1.z_upper);
        let largest = steps.as_ref().map(|steps| steps.iter().copied().max_by(by_upper));
        let attained = steps.iter().flatten().map(|(_, step)| step.z_lower).fold(0.0, f64::max);
        let told = match largest {
            Some(None) => "proved for every input".to_owned(),
            Some(Some((row, step))) => {
                format!("{attained:.1e} to {:.1e} against {}", step.z_upper, row.input)
            }
            None => "open".to_owned(),
        };
        let paper = papers_largest(&row.network)
            .map_or_else(|| "conformant".to_owned(), |error| format!("{error:.0e}"));
        let _ = writeln!(text, "{:<4} {told:<32} {paper}", row.network);
    }
    text
}

/// The paper's summary of a network: the largest of its critical errors in either region; `None` for a
/// check mark.
fn papers_largest(network: &str) -> Option<f64> {
    let rows = TABLE.iter().filter(|row| row.0 == network);
    rows.flat_map(|row| [row.3, row.4]).flatten().max_by(f64::total_cmp)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use conformance::{Limits, OneHiddenLayer, Property, Region, verify};

    use super::*;

    /// A row of C2 with a bracket of z, where the paper's rule sees 1.
    fn row(verdict: Verdict, z: Option<[f64; 2]>) -> Row {
        let names = vec!["C1".to_owned()];
        let network = OneHiddenLayer::new("C2", names, vec![1.0], vec![0.0], vec![1.0], 0.0);
        let property = Property {
            network: "C2".to_owned(),
            input: "C1".to_owned(),
            direction: Increasing,
            kind: PropertyKind::Physical,
        };
        let limits = Limits {
            relative_gap: 0.0,
            nodes: 10,
            time: Duration::from_secs(60),
            cross_check: None,
        };
        let region = Region::scaled([("C1", [0.0, 1.0])]).expect("a box");
        let still = || Duration::ZERO;
        let found = verify(&network.expect("shapes fit"), &property, &region, &limits, &still);
        let step = |[z_lower, z_upper]: [f64; 2]| StepBracket { delta: 0.1, z_lower, z_upper };
        Row {
            verdict,
            physical_step: z.map(step),
            smallest_change: Some(1.0),
            ..found.expect("decided")
        }
    }

    #[test]
    fn what_the_papers_rule_sees_is_said_where_the_bound_says_it() {
        let of = |z: [f64; 2]| follows(&row(Verdict::Violated, Some(z)), true);
        assert_eq!(of([0.1, 0.2]), "fails, by less than their rule sees");
        assert_eq!(of([0.1, 2.0]), "fails, perhaps by less than their rule sees");
        assert_eq!(of([1.5, 2.0]), "contradicted by a counterexample");
    }

    #[test]
    fn the_summary_brackets_the_largest_movement_of_all_rows_that_are_not_proved() {
        let told = |rows: &[Row]| summary(rows).lines().nth(2).unwrap_or_default().to_owned();
        let proved = || row(Verdict::Proved, Some([0.0, 0.0]));
        let undecided = || row(Verdict::Undecided, Some([0.0, 3.0]));
        let violated = || row(Verdict::Violated, Some([0.5, 0.6]));
        assert!(told(&[proved(), proved()]).starts_with("C2   proved for every input"));
        let both = told(&[undecided(), violated(), proved()]);
        assert!(both.starts_with("C2   5.0e-1 to 3.0e0 against C1"), "{both}");
        assert!(told(&[violated(), row(Verdict::Undecided, None)]).starts_with("C2   open"));
    }

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
