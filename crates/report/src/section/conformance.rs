//! Which physiological properties of the networks are proved.

use contract::conformance::{Direction, Grounds, Row, Verdict};

use crate::html::{Column, Html};
use crate::number::significant;
use crate::{Inputs, ReportError, figure};

pub(super) fn body(inputs: &Inputs) -> Result<Html, ReportError> {
    let mut html = Html::default();
    let Some(conformance) = &inputs.conformance else {
        html.absent("There is no conformance table in this folder, so nothing was proved.");
        return Ok(html);
    };
    html.paragraph(
        "M is the largest slope against the property anywhere in the region (scaled output per \
         minute per scaled input). The upper end of its bracket is certified and the lower end is \
         attained: proved where the upper end is not above zero, violated where the lower end is \
         above zero, undecided in between.",
    );
    let (physical, opposite): (Vec<&Row>, Vec<&Row>) =
        conformance.rows.iter().partition(|row| row.is_physical());
    for (caption, rows) in [
        ("Physiological properties; bold: not proved", physical),
        ("Opposite sign, for comparison only: these are expected to be violated", opposite),
    ] {
        if rows.is_empty() {
            continue;
        }
        let cells: Vec<(bool, Vec<String>)> = rows
            .into_iter()
            .map(|row| {
                let verdict = match (row.verdict, row.grounds) {
                    (Verdict::Proved, Some(Grounds::Certificate)) => "proved, certified",
                    (Verdict::Proved, Some(Grounds::Construction)) => "proved by construction",
                    (Verdict::Proved, _) => "proved",
                    (Verdict::Violated, _) => "violated",
                    (Verdict::Undecided, _) => "undecided",
                };
                let bracket =
                    format!("{} to {}", significant(row.m_lower), significant(row.m_upper));
                let cells = vec![
                    row.network.clone(),
                    row.input.clone(),
                    match row.property {
                        Direction::Increasing => "increasing",
                        Direction::Decreasing => "decreasing",
                    }
                    .to_owned(),
                    verdict.to_owned(),
                    bracket,
                    significant(row.share_of_points.map(|share| 100.0 * share.value)),
                    significant(row.seconds),
                ];
                (row.is_physical() && row.verdict != Verdict::Proved, cells)
            })
            .collect();
        html.table(
            caption,
            &[
                ("Network", Column::Text),
                ("Input", Column::Text),
                ("Property", Column::Text),
                ("Verdict", Column::Text),
                ("Bracket of M", Column::Number),
                ("Fails at steps, %", Column::Number),
                ("Seconds", Column::Number),
            ],
            &cells,
        );
    }
    let violated: Vec<&Row> = conformance
        .rows
        .iter()
        .filter(|row| row.is_physical() && row.verdict == Verdict::Violated)
        .collect();
    if let Some((svg, keys)) = figure::slices(&violated)? {
        html.figure(
            &svg,
            &keys,
            "Counterexamples: each output along the tested input across the region, the other inputs as \
             they are where the slope against the property is largest. Scaled units.",
        );
    }
    Ok(html)
}
