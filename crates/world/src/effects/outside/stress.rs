//! Stress: hours with more endogenous glucose, at any time of the day.

use rand::Rng;

use super::super::Condition;
use super::event::{Event, on_some_days};
use crate::behaviour::Life;

/// Rise of the production, as a share: stress raised glucose after a meal by 27 mg/dL within two
/// hours (Wiesli et al., Diabetes Care 2005;28:1910), and adrenaline at levels of stress raises the
/// production by up to twice for an hour and by less later (Rizza et al., J Clin Invest
/// 1980;65:682).
const RISE: f64 = 0.35;

/// Six to ten hours that begin between 7:00 and 22:00, three days in ten (assumed).
pub(super) fn events(life: &Life, rng: &mut (impl Rng + ?Sized)) -> Vec<Event> {
    on_some_days(life, 0.3, (7.0, 22.0), (6.0, 10.0), 0.75, rng)
}

/// Raises the production.
pub(super) fn act(condition: &mut Condition, strength: f64) {
    condition.production *= 1.0 + RISE * strength;
}
