//! Which physiological properties of the networks are proved.

use contract::Conformance;
use contract::conformance::{Direction, Grounds, Row, Verdict};

use crate::html::{Column, ColumnOf, Html};
use crate::number::{ABSENT, significant};
use crate::{ReportError, figure};

pub(super) fn body(conformance: &Conformance) -> Result<Html, ReportError> {
    let mut html = Html::default();
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
        table(&mut html, caption, &rows);
    }
    let violated: Vec<&Row> = conformance
        .rows
        .iter()
        .filter(|row| row.is_physical() && row.verdict == Verdict::Violated)
        .collect();
    html.figure(
        figure::slices(&violated)?,
        "Counterexamples: each output along the tested input across the region, the other inputs as \
         they are where the slope against the property is largest. Scaled units.",
    );
    Ok(html)
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
    html.rows(caption, rows, bold, &columns[usize::from(!of_twins)..]);
}
