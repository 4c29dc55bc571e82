//! Effects that act on free-living people beyond the equations of the plants under test.
//!
//! Each effect has its own file, in a form of this crate's own: the shapes here are not those that
//! a diagnosis fits; only the names are shared. An amplitude of 1 is the size of the source that
//! the file names. 0 switches the effect off and leaves everything else unchanged.

mod alcohol;
mod circadian_sensitivity;
mod compression_lows;
mod conditions;
mod counter_regulation;
mod dawn;
mod exercise_forms;
mod forms;
mod happenings;
mod insulin_absorption;
mod outside;
mod port;
mod renal_threshold;
mod sensing;
mod sensor_drift;
mod sensor_lag;
mod set_ageing;
mod set_failure;
mod shapes;
mod sleep_loss;
mod slow_meals;
mod variability;

pub use circadian_sensitivity::CircadianPattern;
pub use compression_lows::Compression;
pub use conditions::{Condition, conditions};
pub use counter_regulation::LowTrace;
pub use forms::{
    AbsorptionForm, AfterExerciseForm, AlcoholForm, CircadianForm, CompressionForm, DawnForm,
    DriftForm, ExerciseForm, Forms, LagForm, LowForm, MiscountForm, MissedForm, RenalForm,
    SetAgeingForm, SetFailureForm, SleepLossForm, SlowMealsForm, UnloggedForm,
};
pub use happenings::Happenings;
pub use outside::{Event, Events, OutsideEffect};
pub use port::Port;
pub use renal_threshold::Kidneys;
pub use sensing::{Sensing, sensing};
pub use sensor_drift::Drift;
pub use set_failure::SetFailure;
pub use shapes::Shapes;
pub use variability::{Spreads, Variability};

pub(crate) use sensor_lag::Lagged;

use self::port::effect_table;
use crate::stream::standard_normal;
use rand::Rng;
use serde::{Serialize, Serializer};

effect_table! {
    /// An effect that a diagnosis can name.
    Effect {
        /// More endogenous glucose before and after waking.
        Dawn: "dawn", Egp,
            "endogenous glucose production up to 22 % higher around waking";
        /// Glucose taken up by working muscle.
        Exercise: "exercise", GlucoseFlux,
            "uptake of 0.028 mmol/kg/min at full effort, within minutes";
        /// Higher insulin action for hours after exercise.
        PostExerciseSensitivity: "post_exercise_sensitivity", InsulinAction,
            "peripheral insulin action up to 30 % higher after 45 min at half effort, over 8 h";
        /// Lower insulin action on the day after a short night.
        SleepLoss: "sleep_loss", InsulinAction,
            "peripheral insulin action 4.5 % lower for each hour missed, until the next night";
        /// Slower absorption of rich dinners.
        SlowMeals: "slow_meals", GutAbsorption,
            "time of meal absorption up to 50 % longer for 6 h after rich meals";
        /// Less endogenous glucose in the night and morning after alcohol.
        Alcohol: "alcohol", Egp,
            "endogenous glucose production 30 % lower from 2 to 12 h after 0.75 g/kg";
        /// Less insulin from a set that has been worn for days.
        SetAgeing: "set_ageing", InsulinInput,
            "14 % of the insulin lost when a set is three days old";
        /// Insulin absorbed faster on some days than on others.
        InsulinAbsorption: "insulin_absorption", InsulinAbsorption,
            "time of insulin absorption varies by 15 % between days";
        /// Carbohydrate counted with a bias.
        CarbMiscount: "carb_miscount", CarbAmount,
            "counts 28 % below what is eaten, 34 % for large meals, with 12 % more spread";
        /// Meals that are neither logged nor covered by a bolus.
        MissedMeals: "missed_meals", CarbAmount,
            "7 % of meals and snacks neither logged nor covered by a bolus";
        /// Fast carbohydrate against a low that is not logged.
        UnloggedRescueCarbs: "unlogged_rescue_carbs", GlucoseFlux,
            "half of the carbohydrate taken against lows is not logged";
        /// Lower insulin action at some hours of the day.
        CircadianSensitivity: "circadian_sensitivity", InsulinAction,
            "insulin action 22 % lower at the hour of its trough than half a day later";
        /// Sets that fail before they are changed.
        SetFailure: "set_failure", InsulinInput,
            "3.3 % of sets give 0 to 30 % of the insulin for their last 4 to 14 h";
        /// More endogenous glucose in a low.
        CounterRegulation: "counter_regulation", Egp,
            "endogenous glucose production 50 to 100 % higher at 50 mg/dL, 10 to 20 min late";
        /// Kidneys that lose glucose from another concentration on.
        RenalThreshold: "renal_threshold", GlucoseFlux,
            "renal threshold and slope 30 % off, in opposite directions";
        /// A sensor that follows later.
        SensorLag: "sensor_lag", Sensor,
            "readings a further 4.5 to 9.5 min late";
        /// Sensors whose gain and offset drift.
        SensorDrift: "sensor_drift", Sensor,
            "gain 8 % lower late in a sensor's life, offset 5 mg/dL (SD) off after ten days";
        /// Readings that fall while the person lies on the sensor.
        CompressionLows: "compression_lows", Sensor,
            "readings 24 (10 to 48) mg/dL too low for 45 (30 to 70) min, 3 nights in 10";
    }
}

/// The amplitude of each effect in one person; 1 is the published size, 0 is off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Amplitudes {
    named: [f64; Effect::ALL.len()],
    outside: [f64; OutsideEffect::ALL.len()],
}

impl Amplitudes {
    /// No effect acts.
    pub const NONE: Self =
        Self { named: [0.0; Effect::ALL.len()], outside: [0.0; OutsideEffect::ALL.len()] };

    /// Draws log-normal amplitudes of every named effect with median 1 and spread 0.25 (assumed);
    /// none outside the library acts.
    #[must_use]
    pub fn sample(rng: &mut (impl Rng + ?Sized)) -> Self {
        let mut amplitude = || (0.25 * standard_normal(rng)).clamp(-0.6, 0.6).exp();
        Self { named: std::array::from_fn(|_| amplitude()), ..Self::NONE }
    }

    /// The amplitude of one effect.
    #[must_use]
    pub fn of(&self, effect: Effect) -> f64 {
        self.named[effect as usize]
    }

    /// The amplitude of an effect outside the library.
    #[must_use]
    pub fn of_outside(&self, effect: OutsideEffect) -> f64 {
        self.outside[effect as usize]
    }

    /// The same amplitudes, with that of one effect changed.
    #[must_use]
    pub fn with(mut self, effect: Effect, amplitude: f64) -> Self {
        self.named[effect as usize] = amplitude;
        self
    }

    /// The same amplitudes, with that of one effect outside the library changed.
    #[must_use]
    pub fn with_outside(mut self, effect: OutsideEffect, amplitude: f64) -> Self {
        self.outside[effect as usize] = amplitude;
        self
    }

    /// The same amplitudes with one effect switched off.
    #[must_use]
    pub fn without(self, effect: Effect) -> Self {
        self.with(effect, 0.0)
    }

    /// The same amplitudes of these effects; all others are off.
    #[must_use]
    pub fn only(&self, effects: &[Effect]) -> Self {
        effects.iter().fold(Self::NONE, |kept, effect| kept.with(*effect, self.of(*effect)))
    }

    /// The effects that act, by name and with their amplitudes.
    pub fn acting(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let named = Effect::ALL.map(|e| (e.name(), self.of(e)));
        let outside = OutsideEffect::ALL.map(|e| (e.name(), self.of_outside(e)));
        named.into_iter().chain(outside).filter(|(_, amplitude)| *amplitude != 0.0)
    }
}

impl Serialize for Amplitudes {
    /// A map of the effects that act.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.acting())
    }
}

/// A smooth step from 0 to 1 about `centre`, mostly within `centre` +- 3 `width`.
pub(crate) fn rise(x: f64, (centre, width): (f64, f64)) -> f64 {
    1.0 / (1.0 + (-(x - centre) / width).exp())
}

/// A bump of height 1 between two smooth steps.
fn between(x: f64, up: (f64, f64), down: (f64, f64)) -> f64 {
    rise(x, up) * (1.0 - rise(x, down))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amplitudes_are_kept_by_effect() {
        for (index, effect) in Effect::ALL.into_iter().enumerate() {
            assert_eq!(effect as usize, index);
            let amplitudes = Amplitudes::NONE.with(effect, 0.7);
            assert_eq!(amplitudes.of(effect), 0.7);
            assert_eq!(amplitudes.without(effect), Amplitudes::NONE);
            assert_eq!(amplitudes.acting().collect::<Vec<_>>(), [(effect.name(), 0.7)]);
        }
        for effect in OutsideEffect::ALL {
            let amplitudes = Amplitudes::NONE.with_outside(effect, 0.7);
            assert_eq!(amplitudes.of_outside(effect), 0.7);
            assert_eq!(amplitudes.with_outside(effect, 0.0), Amplitudes::NONE);
        }
    }
}
