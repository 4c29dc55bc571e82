//! Basal rates on the steps of a record.

use super::steps::{STEP, Span, step_of};
use crate::person::Therapy;
use crate::record::{Channel, Record};

/// Seconds of a step that rates must cover for the step to be recorded.
pub(super) const COVERED: i64 = 240;
/// From this number of rate changes a day, a controller sets them, not a person.
const CHANGES_OF_A_CONTROLLER: f64 = 48.0;

/// A rate, U/h, from a second to another.
pub(super) type Held = (i64, i64, f64);

/// What rates leave in a record.
pub(super) struct Laid {
    /// U of the source.
    pub(super) source: f64,
    /// U in the record.
    pub(super) kept: f64,
    /// Steps that are not recorded.
    pub(super) silent: usize,
    /// Recorded steps that the rates do not cover wholly.
    pub(super) partly: usize,
}

/// Puts the mean rate of each step that rates cover for `least` seconds into the record of `span`. `source` are U to
/// which those of the rates are added.
pub(super) fn lay(
    rates: impl IntoIterator<Item = Held>,
    span: Span,
    least: i64,
    source: f64,
    record: &mut Record,
) -> Laid {
    let mut laid = Laid { source, kept: 0.0, silent: 0, partly: 0 };
    // U and covered seconds of each step.
    let mut steps = vec![(0.0, 0_i64); record.len()];
    for (from, to, u_h) in rates {
        laid.source += u_h * (to - from) as f64 / 3600.0;
        let (mut at, end) = (from.max(span.first * STEP), to.min(span.end * STEP));
        while at < end {
            let until = end.min((step_of(at) + 1) * STEP);
            let cell = &mut steps[span.index(step_of(at)).expect("within the span")];
            cell.0 += u_h * (until - at) as f64 / 3600.0;
            cell.1 += until - at;
            at = until;
        }
    }
    for (cell, (amount, covered)) in record.channel_mut(Channel::Basal).iter_mut().zip(steps) {
        if covered >= least {
            *cell = Some(amount * 12.0);
            laid.kept += amount;
            laid.partly += usize::from(covered < STEP);
        } else {
            laid.silent += 1;
        }
    }
    laid
}

/// An amount; 0 where sums of `source` in another order leave no less.
pub(super) fn unless_rounding(amount: f64, source: f64) -> f64 {
    if amount.abs() <= 1e-9 * source.max(1.0) { 0.0 } else { amount }
}

/// The therapy that so many changes of the rate a day indicate, and what to say of it.
pub(super) fn therapy_of_changes(a_day: f64) -> (Therapy, &'static str) {
    if a_day >= CHANGES_OF_A_CONTROLLER {
        (Therapy::Aid, "therapy aid: a controller sets the rate")
    } else {
        (Therapy::OpenLoopPump, "therapy open_loop_pump: a programmed profile")
    }
}

/// The same of rates, with the evidence; `None` without a rate.
pub(super) fn therapy_of(rates: &[Held]) -> Option<(Therapy, &'static str, String)> {
    // At least the length of a step.
    let days = (rates.last()?.1 - rates.first()?.0).max(STEP) as f64 / 86_400.0;
    let changes = rates.windows(2).filter(|pair| pair[0].2 != pair[1].2).count() as f64 / days;
    let evidence = format!("{changes:.1} changes of the rate a day over {days:.1} days");
    let (therapy, conclusion) = therapy_of_changes(changes);
    Some((therapy, conclusion, evidence))
}
