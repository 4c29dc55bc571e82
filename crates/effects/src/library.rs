//! Every effect that is tried unless the user says otherwise.

mod alcohol;
mod carb_miscount;
mod circadian_sensitivity;
mod compression_lows;
#[cfg(test)]
mod contract;
mod counter_regulation;
mod dawn;
mod exercise;
mod insulin_absorption;
mod missed_meals;
mod post_exercise_sensitivity;
mod renal_threshold;
mod sensor_drift;
mod sensor_lag;
mod set_ageing;
mod set_failure;
mod sleep_loss;
mod slow_meals;
mod unlogged_rescue_carbs;

use crate::effect::Effect;

/// What the files of the library are written with.
mod prelude {
    pub(super) use crate::activity;
    pub(super) use crate::card::{Card, Channel, Prior};
    pub(super) use crate::course::{Course, STEP_MINUTES, recorded, value_at};
    pub(super) use crate::effect::{Effect, EventShape, Form, RandomUnit};
    pub(super) use crate::effect_id::EffectId;
    pub(super) use crate::meals;
    pub(super) use crate::modulation::{Field, Modulation};
    pub(super) use crate::port::Port;
    pub(super) use crate::relations::{Allowance, Relations, ShownBy, Structure};
    pub(super) use crate::slot_centring::centre_within_clock_slots;
}

/// The effects of the library, in a fixed order.
#[must_use]
pub fn library() -> Vec<Box<dyn Effect>> {
    vec![
        Box::new(exercise::Exercise),
        Box::new(post_exercise_sensitivity::PostExerciseSensitivity),
        Box::new(dawn::Dawn),
        Box::new(circadian_sensitivity::CircadianSensitivity),
        Box::new(sleep_loss::SleepLoss),
        Box::new(slow_meals::SlowMeals),
        Box::new(carb_miscount::CarbMiscount),
        Box::new(missed_meals::MissedMeals),
        Box::new(unlogged_rescue_carbs::UnloggedRescueCarbs),
        Box::new(set_ageing::SetAgeing),
        Box::new(set_failure::SetFailure),
        Box::new(insulin_absorption::InsulinAbsorption),
        Box::new(counter_regulation::CounterRegulation),
        Box::new(alcohol::Alcohol),
        Box::new(renal_threshold::RenalThreshold),
        Box::new(sensor_lag::SensorLag),
        Box::new(sensor_drift::SensorDrift),
        Box::new(compression_lows::CompressionLows),
    ]
}

/// Names of the effects of the library, in its order.
#[must_use]
pub fn names() -> Vec<&'static str> {
    library().iter().map(|effect| effect.card().id.name()).collect()
}

/// The effect of that name.
#[must_use]
pub fn find(name: &str) -> Option<Box<dyn Effect>> {
    library().into_iter().find(|effect| effect.card().id.name() == name)
}
