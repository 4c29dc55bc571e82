//! The course of the body's multipliers that is fixed before the simulation.

use physiology::STEPS_PER_HOUR;

use super::variability::Variability;
use super::{Amplitudes, Effect, alcohol, dawn, set_ageing, sleep_loss, slow_meals};
use crate::behaviour::{Habits, Life};

/// Multipliers on the body through one step; 1 is the body as drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Condition {
    /// On endogenous glucose production.
    pub production: f64,
    /// On insulin action in the periphery (S_f1, S_f2).
    pub action: f64,
    /// On insulin action in the liver (S_f3).
    pub liver_action: f64,
    /// On the time to the maximal insulin absorption.
    pub insulin_time: f64,
    /// On the time to the maximal meal absorption.
    pub gut_time: f64,
    /// On the insulin delivered.
    pub bioavailability: f64,
}

/// The multipliers of each step of a life.
///
/// What depends on glucose or on exercise is not part of it.
#[must_use]
pub fn conditions(
    habits: &Habits,
    life: &Life,
    days: &Variability,
    amplitudes: &Amplitudes,
) -> Vec<Condition> {
    let awake_action = after_nights(life, amplitudes.of(Effect::SleepLoss));
    (0..life.calendar.steps())
        .map(|step| {
            let dawn = dawn::production_factor(
                life.calendar.hour(step),
                habits.wake_hour,
                amplitudes.of(Effect::Dawn),
            );
            let alcohol: f64 = life
                .evenings
                .iter()
                .map(|e| {
                    let hours = hours_between(e.step, step);
                    alcohol::production_factor(hours, e.dose, amplitudes.of(Effect::Alcohol))
                })
                .product();
            let slow = life
                .meals
                .iter()
                .filter(|m| m.richness > 0.0)
                .map(|m| {
                    let hours = hours_between(m.step, step);
                    slow_meals::gut_time_factor(m, hours, amplitudes.of(Effect::SlowMeals))
                })
                .fold(1.0, f64::max);
            let action = days.action[step].exp();
            Condition {
                production: dawn * alcohol,
                action: action * awake_action[step],
                liver_action: action,
                insulin_time: (amplitudes.of(Effect::InsulinAbsorption) * days.insulin_time[step])
                    .exp(),
                gut_time: days.gut_time[step].exp() * slow,
                bioavailability: set_ageing::bioavailability(
                    life.sets.age_days(step),
                    amplitudes.of(Effect::SetAgeing),
                ),
            }
        })
        .collect()
}

/// Hours from one step to another.
fn hours_between(from: usize, to: usize) -> f64 {
    (to as f64 - from as f64) / STEPS_PER_HOUR as f64
}

/// Factor of sleep loss on each step: that of the last night from waking to the next sleep.
fn after_nights(life: &Life, amplitude: f64) -> Vec<f64> {
    let mut factors = vec![1.0; life.calendar.steps()];
    for (night, following) in life.nights.iter().zip(life.nights.iter().skip(1)) {
        let factor = sleep_loss::action_factor(night, amplitude);
        for step in night.wake.max(0)..following.onset {
            if let Some(slot) = usize::try_from(step).ok().and_then(|s| factors.get_mut(s)) {
                *slot = factor;
            }
        }
    }
    factors
}
