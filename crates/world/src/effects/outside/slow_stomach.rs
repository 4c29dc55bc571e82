//! High glucose slows the emptying of the stomach.

use super::super::Condition;
use super::event::{Event, always};
use crate::behaviour::Life;

/// Lengthening of the time of meal absorption per 100 mg/dL, as a logarithm: 35 %. With type 1
/// diabetes half of a liquid meal had left the stomach after 41 min at 144 mg/dL and after 29 min
/// at 72 mg/dL (Schvarcz et al., Gastroenterology 1997;113:60); higher glucose slows it further
/// (Fraser et al., Diabetologia 1990;33:675).
const LONGER: f64 = 0.30;

/// At all times.
pub(super) fn events(life: &Life) -> Vec<Event> {
    vec![always(life)]
}

/// Makes the time of meal absorption depend on glucose.
pub(super) fn act(condition: &mut Condition, strength: f64) {
    condition.gut_time_per_glucose += LONGER * strength;
}
