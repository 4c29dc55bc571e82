//! Rich dinners are absorbed more slowly.

use crate::behaviour::Meal;

/// Lengthening of the time to the maximal appearance for the richest meal, as a share. Fat and
/// protein delay and flatten the rise (Wolpert et al., Diabetes Care 2013;36:810); 0.4 to 0.6 is of
/// that order.
const LENGTHENING: f64 = 0.5;
/// Hours for which a rich meal rules the gut.
const HOURS: f64 = 6.0;

/// Factor on the time to the maximal appearance, `hours` after the start of `meal`; 1 outside
/// the six hours that follow it.
#[must_use]
pub(super) fn gut_time_factor(meal: &Meal, hours: f64, amplitude: f64) -> f64 {
    let ruling = (0.0..HOURS).contains(&hours);
    if ruling { 1.0 + amplitude * LENGTHENING * meal.richness } else { 1.0 }
}
