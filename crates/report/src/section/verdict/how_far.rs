//! What adding the effects does to the error, as the verdict says it.

use crate::number::{fixed, interval};
use crate::section::words::ahead;
use contract::Diagnosis;
use contract::diagnosis::HorizonChange;

/// What the effects do to the error, in words.
pub(super) struct Change {
    /// A clause of the sentence.
    pub(super) clause: String,
    /// The short answer.
    pub(super) answer: String,
    /// What the short answer is.
    pub(super) detail: String,
}

/// What the effects of a diagnosis do to the error; `None` where it names none.
pub(super) fn change(diagnosis: &Diagnosis) -> Option<Change> {
    let (them, were) = match diagnosis.effects.len() {
        0 => return None,
        1 => ("it", "it were"),
        _ => ("them", "they were"),
    };
    let of = |reconstructed: bool| {
        diagnosis.how_far.horizons.iter().filter(move |h| h.reconstructed == reconstructed)
    };
    let longest = |smaller: bool| {
        let certain = move |h: &&HorizonChange| match smaller {
            true => h.difference.upper < 0.0,
            false => h.difference.lower > 0.0,
        };
        of(false).filter(certain).max_by_key(|h| h.minutes)
    };
    // A reconstruction is no prediction, and stands only where there is no prediction. The one that is
    // shown is of the usual five hours, or the longest.
    let usual = of(true).find(|h| h.minutes == 300);
    let known = usual.or_else(|| of(true).max_by_key(|h| h.minutes));
    let open = of(false).max_by_key(|h| h.minutes);

    let arrow = |h: &HorizonChange| {
        format!("{} \u{2192} {} mg/dL", fixed(h.mae_before, 1), fixed(h.mae_after, 1))
    };
    let at = |h: &HorizonChange| format!("{} {} ahead", arrow(h), ahead(h.minutes));
    let difference = |h: &HorizonChange| interval(h.difference, 1);
    Some(match (longest(true), longest(false)) {
        // One error falls and another grows, both by more than chance; of each the longest forecast.
        (Some(falls), Some(grows)) => Change {
            clause: format!(
                "with {them} {}, and {}",
                moves(falls, " on held-out days"),
                moves(grows, "")
            ),
            answer: "Smaller and larger".to_owned(),
            detail: format!(
                "Mean absolute error on held-out days: {}, change {}; {}, change {}",
                at(falls),
                difference(falls),
                at(grows),
                difference(grows)
            ),
        },
        // A forecast changes by more than chance: smaller, or larger.
        (Some(h), None) | (None, Some(h)) => Change {
            clause: format!("with {them} {}", moves(h, " on held-out days")),
            answer: arrow(h),
            detail: format!(
                "Mean absolute error {} ahead on held-out days; change {}",
                ahead(h.minutes),
                difference(h)
            ),
        },
        (None, None) => match (open, known) {
            // No forecast changes by more than chance; this is the longest.
            (Some(h), _) => Change {
                clause: format!(
                    "with {them} no error on held-out days shrinks beyond chance ({} to {} mg/dL {} ahead)",
                    fixed(h.mae_before, 1),
                    fixed(h.mae_after, 1),
                    ahead(h.minutes)
                ),
                answer: "No certain change".to_owned(),
                detail: format!("{} on held-out days; change {}", at(h), difference(h)),
            },
            // The effects cannot be forecast. This is the error were they known.
            (None, Some(h)) => Change {
                clause: format!(
                    "no forecast improves, since the record does not announce {them}; if {were} known, the error {} \
                     ahead would be {} in place of {} mg/dL",
                    ahead(h.minutes),
                    fixed(h.mae_after, 1),
                    fixed(h.mae_before, 1)
                ),
                answer: "No better forecast".to_owned(),
                detail: format!(
                    "The record does not announce what is missing. {} if it were known",
                    at(h)
                ),
            },
            (None, None) => Change {
                clause: format!("whether the error shrinks with {them} was not measured"),
                answer: "Not measured".to_owned(),
                detail: "No held-out day could be compared with the effects and without them"
                    .to_owned(),
            },
        },
    })
}

/// How the error of a forecast moves; `on` says on which days.
fn moves(h: &HorizonChange, on: &str) -> String {
    let (verb, by) = if h.difference.upper < 0.0 { ("falls", -1.0) } else { ("grows", 1.0) };
    let (before, after) = (fixed(h.mae_before, 1), fixed(h.mae_after, 1));
    let ahead = ahead(h.minutes);
    // Below ten per cent with a decimal, so that a change is not called nothing.
    let percent = 100.0 * (by * (h.mae_after - h.mae_before) / h.mae_before);
    let share = fixed(percent, usize::from(percent < 9.95));
    format!("the error {ahead} ahead{on} {verb} from {before} to {after} mg/dL, by {share}\u{a0}%")
}
