//! A hot bath: insulin is absorbed faster while the skin is warm.

use rand::Rng;

use super::super::Condition;
use super::event::{Event, on_some_days};
use crate::behaviour::Life;

/// Shortening of the time of insulin absorption, as a logarithm: by 45 %. A sauna raised the
/// disappearance of insulin from its site by 110 % (Koivisto, Br Med J 1980;280:1411), a hot bath
/// nearly as much (Berger et al., Diabetes Care 1982;5:77).
const SHORTER: f64 = 0.6;

/// One to two hours from between 18:30 and 22:30 on, six evenings in ten (assumed).
pub(super) fn events(life: &Life, rng: &mut (impl Rng + ?Sized)) -> Vec<Event> {
    on_some_days(life, 0.6, (18.5, 22.5), (1.0, 2.0), 0.25, rng)
}

/// Shortens the time of insulin absorption, to a fifth at most.
pub(super) fn act(condition: &mut Condition, strength: f64) {
    condition.insulin_time *= (-SHORTER * strength).max(-1.6).exp();
}
