//! What adding the effects does to the error, as the verdict says it.

use crate::number::{fixed, interval};
use crate::section::words::ahead;
use contract::Diagnosis;
use contract::diagnosis::HorizonChange;

/// What the effects do to the error.
pub(super) enum Change<'a> {
    /// A forecast changes by more than chance: smaller, or larger.
    Certain(&'a HorizonChange),
    /// One error falls and another grows, both by more than chance.
    Both {
        /// The longest forecast whose error falls.
        falls: &'a HorizonChange,
        /// The longest forecast whose error grows.
        grows: &'a HorizonChange,
    },
    /// No forecast changes by more than chance; this is the longest.
    Open(&'a HorizonChange),
    /// The effects cannot be forecast. This is the error were they known.
    Known(&'a HorizonChange),
    /// Nothing was compared.
    Untested,
}

/// What the effects of a diagnosis do to the error; `None` where it names none.
pub(super) fn change(diagnosis: &Diagnosis) -> Option<Change<'_>> {
    if diagnosis.effects.is_empty() {
        return None;
    }
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
    let open = || of(false).max_by_key(|h| h.minutes).map(Change::Open);
    // A reconstruction is no prediction, and stands only where there is no prediction. The one that is
    // shown is of the usual five hours, or the longest.
    let usual = || of(true).find(|h| h.minutes == 300);
    let known = || usual().or_else(|| of(true).max_by_key(|h| h.minutes)).map(Change::Known);
    Some(match (longest(true), longest(false)) {
        (Some(falls), Some(grows)) => Change::Both { falls, grows },
        (Some(certain), None) | (None, Some(certain)) => Change::Certain(certain),
        (None, None) => open().or_else(known).unwrap_or(Change::Untested),
    })
}

impl Change<'_> {
    /// A clause of the sentence about so many effects.
    pub(super) fn clause(&self, effects: usize) -> String {
        let (them, were) = if effects == 1 { ("it", "it were") } else { ("them", "they were") };
        match self {
            Self::Certain(h) => format!("with {them} {}", moves(h, " on held-out days")),
            Self::Both { falls, grows } => format!(
                "with {them} {}, and {}",
                moves(falls, " on held-out days"),
                moves(grows, "")
            ),
            Self::Open(h) => format!(
                "with {them} no error on held-out days shrinks beyond chance ({} to {} mg/dL {} ahead)",
                fixed(h.mae_before, 1),
                fixed(h.mae_after, 1),
                ahead(h.minutes)
            ),
            Self::Known(h) => format!(
                "no forecast improves, since the record does not announce {them}; if {were} known, the error {} \
                 ahead would be {} in place of {} mg/dL",
                ahead(h.minutes),
                fixed(h.mae_after, 1),
                fixed(h.mae_before, 1)
            ),
            Self::Untested => format!("whether the error shrinks with {them} was not measured"),
        }
    }

    /// The short answer, and what it is.
    pub(super) fn tile(&self) -> (String, String) {
        let arrow = |h: &HorizonChange| {
            format!("{} \u{2192} {} mg/dL", fixed(h.mae_before, 1), fixed(h.mae_after, 1))
        };
        let difference = |h: &HorizonChange| interval(h.difference, 1);
        match self {
            Self::Certain(h) => (
                arrow(h),
                format!(
                    "Mean absolute error {} ahead on held-out days; change {}",
                    ahead(h.minutes),
                    difference(h)
                ),
            ),
            Self::Both { falls, grows } => (
                "Smaller and larger".to_owned(),
                format!(
                    "Mean absolute error on held-out days: {} {} ahead, change {}; {} {} ahead, change {}",
                    arrow(falls),
                    ahead(falls.minutes),
                    difference(falls),
                    arrow(grows),
                    ahead(grows.minutes),
                    difference(grows)
                ),
            ),
            Self::Open(h) => (
                "No certain change".to_owned(),
                format!(
                    "{} {} ahead on held-out days; change {}",
                    arrow(h),
                    ahead(h.minutes),
                    difference(h)
                ),
            ),
            Self::Known(h) => (
                "No better forecast".to_owned(),
                format!(
                    "The record does not announce what is missing. {} {} ahead if it were known",
                    arrow(h),
                    ahead(h.minutes)
                ),
            ),
            Self::Untested => (
                "Not measured".to_owned(),
                "No held-out day could be compared with the effects and without them".to_owned(),
            ),
        }
    }
}

/// How the error of a forecast moves; `on` says on which days.
fn moves(h: &HorizonChange, on: &str) -> String {
    let (verb, by) = if h.difference.upper < 0.0 { ("falls", -1.0) } else { ("grows", 1.0) };
    let (before, after) = (fixed(h.mae_before, 1), fixed(h.mae_after, 1));
    let ahead = ahead(h.minutes);
    let share = share(by * (h.mae_after - h.mae_before) / h.mae_before);
    format!("the error {ahead} ahead{on} {verb} from {before} to {after} mg/dL, by {share}")
}

/// A share in per cent; below one with a decimal, so that it is not called nothing.
fn share(share: f64) -> String {
    let percent = 100.0 * share;
    let digits = usize::from(percent < 9.95);
    format!("{}\u{a0}%", fixed(percent, digits))
}
