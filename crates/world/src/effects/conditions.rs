//! What acts on the body beyond its inputs: one [`Condition`] a step.

use physiology::{MgPerDl, Minutes, STEPS_PER_DAY, STEPS_PER_HOUR};

use super::counter_regulation::LowTrace;
use super::happenings::Happenings;
use super::outside;
use super::shapes::Shapes;
use super::{
    Amplitudes, Effect, alcohol, circadian_sensitivity, counter_regulation, dawn, renal_threshold,
    set_ageing, set_failure, sleep_loss, slow_meals,
};
use crate::behaviour::{Habits, Life};

/// What acts on the body through one step.
///
/// Every body applies all of it. Most fields are multipliers, 1 for the body as drawn; a body calls
/// [`at_glucose`](Self::at_glucose) first, which settles what depends on its own glucose.
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
    /// On the rate at which the kidneys clear glucose above their threshold.
    pub renal_slope: f64,
    /// On the glucose above which the kidneys clear glucose.
    pub renal_threshold: f64,
    /// Glucose that enters the accessible compartment besides meals and production, mmol/kg/min.
    pub glucose_flux: f64,
    /// Rise of the production, as a share, while counter-regulation is fully roused.
    pub low_response: f64,
    /// Time constant of counter-regulation.
    pub low_response_time: Minutes,
    /// Change of the logarithm of the gut time for each 100 mg/dL of glucose above 140 mg/dL.
    pub gut_time_per_glucose: f64,
}

impl Condition {
    /// The body as drawn.
    pub const AS_DRAWN: Self = Self {
        production: 1.0,
        action: 1.0,
        liver_action: 1.0,
        insulin_time: 1.0,
        gut_time: 1.0,
        bioavailability: 1.0,
        renal_slope: 1.0,
        renal_threshold: 1.0,
        glucose_flux: 0.0,
        low_response: 0.0,
        low_response_time: Minutes(15.0),
        gut_time_per_glucose: 0.0,
    };

    /// The condition of a body whose glucose is `glucose` and whose counter-regulation stands at
    /// `low`: production and gut time hold what depends on these, and nothing else does.
    #[must_use]
    pub fn at_glucose(&self, glucose: MgPerDl, low: &LowTrace) -> Self {
        let excess = ((glucose.0 - 140.0) / 100.0).clamp(0.0, 2.0);
        Self {
            production: self.production * low.production_factor(self.low_response),
            gut_time: self.gut_time * (self.gut_time_per_glucose * excess).exp(),
            low_response: 0.0,
            gut_time_per_glucose: 0.0,
            ..*self
        }
    }
}

/// The conditions of each step of a life.
#[must_use]
pub fn conditions(
    habits: &Habits,
    life: &Life,
    happenings: &Happenings,
    shapes: &Shapes,
    amplitudes: &Amplitudes,
) -> Vec<Condition> {
    let days = &happenings.variability;
    let awake_action = after_nights(life, amplitudes.of(Effect::SleepLoss));
    let clock =
        circadian_sensitivity::day(&shapes.circadian, amplitudes.of(Effect::CircadianSensitivity));
    let kidneys = amplitudes.of(Effect::RenalThreshold);
    let mut course: Vec<Condition> = (0..life.calendar.steps())
        .map(|step| {
            let hour = life.calendar.hour(step);
            let dawn = dawn::production_factor(
                hour,
                habits.wake_hour + shapes.dawn_shift,
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
            let (by_clock, liver_by_clock) = clock[step % STEPS_PER_DAY];
            let action = days.action[step].exp();
            let aged = set_ageing::bioavailability(
                life.sets.age_days(step),
                shapes.set_ageing_onset,
                amplitudes.of(Effect::SetAgeing),
            );
            let failed = set_failure::bioavailability(
                &happenings.set_failures,
                step,
                amplitudes.of(Effect::SetFailure),
            );
            Condition {
                production: dawn * alcohol,
                action: action * awake_action[step] * by_clock,
                liver_action: action * liver_by_clock,
                insulin_time: (amplitudes.of(Effect::InsulinAbsorption) * days.insulin_time[step])
                    .exp(),
                gut_time: days.gut_time[step].exp() * slow,
                bioavailability: aged * failed,
                renal_slope: renal_threshold::slope_factor(&shapes.renal, kidneys),
                renal_threshold: renal_threshold::threshold_factor(&shapes.renal, kidneys),
                low_response: counter_regulation::response(
                    shapes.counter_regulation,
                    amplitudes.of(Effect::CounterRegulation),
                ),
                low_response_time: shapes.counter_regulation_time,
                ..Condition::AS_DRAWN
            }
        })
        .collect();
    outside::act(&mut course, &happenings.outside, amplitudes);
    course
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
