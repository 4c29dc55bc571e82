//! Protein of a large dinner becomes glucose hours later.

use physiology::STEPS_PER_HOUR;
use rand::{Rng, RngExt};

use super::super::Condition;
use super::event::Event;
use crate::behaviour::{Life, MealKind};

/// Glucose made of it, mmol/kg/min: over four hours this comes to 15 to 20 g in an adult. Protein
/// of 75 g beside a meal raised glucose from 150 to 300 min after it, by 5 mmol/L on average
/// (Paterson et al., Diabet Med 2017;34:851); these dinners hold about half of that.
const FLUX: f64 = 0.006;
/// Share of the dinners that are rich in protein (assumed).
const SHARE: f64 = 0.4;

/// From an hour and a half to five and a half after such dinners.
pub(super) fn events(life: &Life, rng: &mut (impl Rng + ?Sized)) -> Vec<Event> {
    let dinners = life.meals.iter().filter(|m| m.kind == MealKind::Dinner);
    dinners
        .filter_map(|dinner| {
            let (draw, size) = (rng.random::<f64>(), rng.random_range(0.75..1.25));
            let from = dinner.step as i64 + (1.5 * STEPS_PER_HOUR as f64) as i64;
            (draw < SHARE).then_some(Event { from, hours: 4.0, edge: 0.75, size })
        })
        .collect()
}

/// Adds glucose.
pub(super) fn act(condition: &mut Condition, strength: f64) {
    condition.glucose_flux += FLUX * strength;
}
