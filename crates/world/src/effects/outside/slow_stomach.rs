//! High glucose slows the emptying of the stomach.

use super::super::Condition;
use super::event::{Event, always};
use crate::behaviour::Life;

/// Lengthening of the time of meal absorption per 100 mg/dL, as a logarithm: 35 %. At 290 to 360
/// mg/dL the stomach empties far more slowly than at 72 to 144 mg/dL (Fraser et al., Diabetologia
/// 1990;33:675), and at 144 mg/dL already by 17 % more slowly than at 72 (Schvarcz et al.,
/// Gastroenterology 1997;113:60).
const LONGER: f64 = 0.30;

/// At all times.
pub(super) fn events(life: &Life) -> Vec<Event> {
    vec![always(life)]
}

/// Makes the time of meal absorption depend on glucose.
pub(super) fn act(condition: &mut Condition, strength: f64) {
    condition.gut_time_per_glucose += LONGER * strength;
}
