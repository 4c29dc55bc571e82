//! What the check had to reach, and whether it does.

use super::super::words::{sentence, target as name};
use crate::html::{Column, Html};
use crate::number::{ends, optional};
use crate::{ReportError, figure};
use contract::BlindCheck;
use contract::blind_check::{Bound, Target};

pub(in super::super) fn body(check: &BlindCheck) -> Result<Html, ReportError> {
    let mut html = Html::default();
    html.paragraph(
        "Worlds were made with effects that the diagnosis could not know: a hash of every label was \
         written before the data, the diagnosis saw the data alone, and the labels were opened when \
         all answers were in. A figure that falls short is printed as such.",
    );
    if check.targets.is_empty() {
        html.absent("No target was set.");
        return Ok(html);
    }
    let verdict = |target: &Target| match target.met {
        Some(true) => "\u{2713}\u{a0}met",
        Some(false) => "\u{2717}\u{a0}missed",
        None => "not\u{a0}tested",
    };
    html.rows(
        "Targets; bold: missed",
        &check.targets,
        |target| target.met == Some(false),
        &[
            ("Target", Column::Text, &|target| sentence(&name(&target.name))),
            ("Verdict", Column::Text, &|target| verdict(target).to_owned()),
            ("Limit", Column::Number, &limit),
            ("Measured (95 % interval)", Column::Number, &measured),
            ("Counting sets", Column::Number, &|t| optional(t.value_counting_sets, 3)),
            ("Of", Column::Number, &|target| target.of.to_string()),
            ("What is counted", Column::Text, &|target| sentence(&target.says)),
        ],
    );
    html.paragraph_of(
        "note",
        "Verdicts compare the measured value with its limit. \u{201c}Counting sets\u{201d}: an answer \
         also counts if the truth stands in the set of effects that it says it cannot tell apart.",
    );
    let named: Vec<(String, &Target)> = check.targets.iter().map(|t| (name(&t.name), t)).collect();
    html.figure(
        figure::targets(&named)?,
        "Every target: the mark should lie in the shaded part of its line. An interval that \
         reaches across the limit says that more worlds would be needed to be sure.",
    );
    Ok(html)
}

fn limit(target: &Target) -> String {
    let sign = match target.bound {
        Bound::AtLeast => "\u{2265} ",
        Bound::AtMost => "\u{2264} ",
    };
    format!("{sign}{}", optional(target.target, 2))
}

fn measured(target: &Target) -> String {
    match (target.lower, target.upper) {
        (Some(lower), Some(upper)) => {
            format!("{}{}", optional(target.value, 3), ends(lower, upper, 3))
        }
        _ => optional(target.value, 3),
    }
}
