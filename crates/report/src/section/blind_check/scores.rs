//! False alarms, wrong names, effects outside the library, pairs, and diagnoses without an answer.

use crate::html::{Column, Html};
use crate::number::{count, ends, optional, share};
use contract::BlindCheck;

pub(in super::super) fn body(html: &mut Html, check: &BlindCheck) {
    let (unknown, pairs) = (&check.unknown, &check.pairs);
    let shares = [
        ("Nothing acts, and something was found (false alarms)", check.false_alarms),
        ("One effect acts, and an unrelated one was named", check.wrong_names),
        ("An effect outside the library was called unknown", unknown.recalled),
        ("Of those, placed where it enters", unknown.right_port),
        (
            "Of those, placed there or at a place that cannot be told from it",
            unknown.right_port_or_in_set,
        ),
        ("Two effects act: of the names given, those that act (precision)", pairs.precision),
        ("Two effects act: of those, named (recall)", pairs.recall),
        ("Two effects act: both and nothing else named", pairs.both),
        ("The diagnosis ended without an answer", check.failed),
    ];
    let mut rows: Vec<(String, String)> =
        shares.into_iter().map(|(what, counted)| (what.to_owned(), share(&counted))).collect();
    if pairs.f1.is_some() {
        let limits = pairs.f1_lower.zip(pairs.f1_upper);
        let ends = limits.map_or_else(String::new, |(lower, upper)| ends(lower, upper, 2));
        let worlds = count(pairs.worlds, "world", "worlds");
        let what = format!("F1 of the names over {worlds} with two effects");
        rows.push((what, format!("{}{ends}", optional(pairs.f1, 2))));
    }
    html.rows(
        "Counted worlds, with 95 % intervals",
        &rows,
        &[
            ("What", Column::Text, &|(what, _)| what.clone()),
            ("How many", Column::Number, &|(_, many)| many.clone()),
        ],
    );
}
