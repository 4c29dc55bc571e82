//! What the exact courses of the effects would let be named.

use crate::html::{Column, Html};
use crate::number::{ABSENT, ends, fixed, share};
use contract::blind_check::{Ceiling, CeilingAtBar, Share};

/// What is counted, what was answered, what is above the bar, and that at another bar.
type Row<'a> = (&'static str, &'a Share, &'a Share, fn(&CeilingAtBar) -> usize);

pub(in super::super) fn body(html: &mut Html, ceiling: &Ceiling) {
    let at_ends = ceiling.at_lower_bar.as_ref().zip(ceiling.at_upper_bar.as_ref());
    let interval =
        at_ends.map_or_else(String::new, |(lower, upper)| ends(lower.bar_nats, upper.bar_nats, 1));
    html.paragraph(&format!(
        "After all answers were in, the exact course of each effect went through the same tests. The \
         evidence of a course of an effect that acts is compared with a bar of {} nats{interval}: at \
         most one in fifty courses of effects that do not act is above it. Nobody knows the exact \
         courses in real people. An effect that is not named, and whose exact course is above the bar, \
         might be named with a better form of it. One whose exact course is below the bar does not stand out even so.",
        fixed(ceiling.bar_nats, 1)
    ));
    let what = "One effect acts and moves glucose by 5 mg/dL or more: it is named";
    let unknown = "An effect outside the library acts: it is called unknown";
    let rows: [Row<'_>; 3] = [
        (what, &ceiling.answered_at_5, &ceiling.named_at_5, |at| at.named_at_5),
        ("The same from 10 mg/dL", &ceiling.answered_at_10, &ceiling.named_at_10, |at| {
            at.named_at_10
        }),
        (unknown, &ceiling.answered_unknown, &ceiling.unknown, |at| at.unknown),
    ];
    let other = |count: fn(&CeilingAtBar) -> usize| {
        at_ends.map_or_else(
            || ABSENT.to_owned(),
            |(lower, upper)| format!("{} to {}", count(upper), count(lower)),
        )
    };
    html.rows(
        "Worlds that were answered rightly, and worlds whose exact course is above the bar",
        &rows,
        &[
            ("What", Column::Text, &|row| row.0.to_owned()),
            ("Answered (95 % interval)", Column::Number, &|row| share(row.1)),
            ("Exact course above the bar (95 % interval)", Column::Number, &|row| share(row.2)),
            ("Above the ends of the bar's interval", Column::Number, &|row| other(row.3)),
        ],
    );
    html.paragraph_of(
        "note",
        "The interval of the bar is a 95 % bootstrap interval over the worlds in which no effect acts.",
    );
}
