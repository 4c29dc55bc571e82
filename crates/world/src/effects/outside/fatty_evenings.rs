//! After evenings rich in fat insulin acts less on the liver.

use rand::Rng;

use super::super::Condition;
use super::event::{Event, on_some_days};
use crate::behaviour::Life;

/// Fall of the action on the liver, as a logarithm: 40 %. Fatty acids keep insulin from suppressing
/// the production (Boden et al., Am J Physiol Endocrinol Metab 2002;283:E12), and fat dinners asked
/// for 42 % more insulin (Wolpert et al., Diabetes Care 2013;36:810).
const FALL: f64 = 0.51;

/// Eight to thirteen hours from between 20:00 and 22:30 on, 35 % of evenings (assumed).
pub(super) fn events(life: &Life, rng: &mut (impl Rng + ?Sized)) -> Vec<Event> {
    on_some_days(life, 0.35, (20.0, 22.5), (8.0, 13.0), 1.5, rng)
}

/// Lowers the action in the liver.
pub(super) fn act(condition: &mut Condition, strength: f64) {
    condition.liver_action *= (-FALL * strength).exp();
}
