//! What acts on free-living people beyond the equations of the plants under test.
//!
//! Each effect stands in its own file, in a form of this crate's own: shapes here are not those
//! that a diagnosis fits, only the names are shared. An amplitude of 1 is the size of the source
//! that the file names; 0 switches the effect off and leaves everything else as it was.

mod alcohol;
mod conditions;
mod dawn;
mod exercise;
mod set_ageing;
mod sleep_loss;
mod slow_meals;
mod variability;

pub use conditions::{Condition, conditions};
pub use exercise::ExerciseTrace;
pub use variability::Variability;

use rand::Rng;
use serde::{Serialize, Serializer, ser::SerializeMap};

use crate::behaviour::standard_normal;

/// An effect that can be switched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Effect {
    /// More endogenous glucose before and after waking.
    Dawn,
    /// Glucose taken up by working muscle.
    Exercise,
    /// Higher insulin action for hours after exercise.
    PostExerciseSensitivity,
    /// Lower insulin action on the day after a short night.
    SleepLoss,
    /// Slower absorption of rich dinners.
    SlowMeals,
    /// Less endogenous glucose in the night and morning after alcohol.
    Alcohol,
    /// Less insulin from a set that has been worn for days.
    SetAgeing,
    /// Insulin absorbed faster on some days than on others.
    InsulinAbsorption,
    /// Carbohydrate counted is not carbohydrate eaten.
    CarbMiscount,
    /// Meals that are neither logged nor covered by a bolus.
    MissedMeals,
    /// Fast carbohydrate against a low that is not logged.
    UnloggedRescueCarbs,
}

impl Effect {
    /// Every effect.
    pub const ALL: [Self; 11] = [
        Self::Dawn,
        Self::Exercise,
        Self::PostExerciseSensitivity,
        Self::SleepLoss,
        Self::SlowMeals,
        Self::Alcohol,
        Self::SetAgeing,
        Self::InsulinAbsorption,
        Self::CarbMiscount,
        Self::MissedMeals,
        Self::UnloggedRescueCarbs,
    ];

    /// The name that files use.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Dawn => "dawn",
            Self::Exercise => "exercise",
            Self::PostExerciseSensitivity => "post_exercise_sensitivity",
            Self::SleepLoss => "sleep_loss",
            Self::SlowMeals => "slow_meals",
            Self::Alcohol => "alcohol",
            Self::SetAgeing => "set_ageing",
            Self::InsulinAbsorption => "insulin_absorption",
            Self::CarbMiscount => "carb_miscount",
            Self::MissedMeals => "missed_meals",
            Self::UnloggedRescueCarbs => "unlogged_rescue_carbs",
        }
    }
}

impl Effect {
    /// What an amplitude of 1 does, in one line for the labels of a world.
    #[must_use]
    pub const fn size_at_one(self) -> &'static str {
        match self {
            Self::Dawn => "endogenous glucose production up to 22 % higher around waking",
            Self::Exercise => "uptake of 0.028 mmol/kg/min at full effort, within minutes",
            Self::PostExerciseSensitivity => {
                "peripheral insulin action up to 30 % higher after 45 min at half effort, over 8 h"
            }
            Self::SleepLoss => {
                "peripheral insulin action 4.5 % lower for each hour missed, until the next night"
            }
            Self::SlowMeals => "time of meal absorption up to 50 % longer for 6 h after rich meals",
            Self::Alcohol => {
                "endogenous glucose production 30 % lower from 2 to 12 h after 0.75 g/kg"
            }
            Self::SetAgeing => "14 % of the insulin lost when a set is three days old",
            Self::InsulinAbsorption => "time of insulin absorption varies by 15 % between days",
            Self::CarbMiscount => "counted over eaten log-normal: 63 % below 1, mean error 21 %",
            Self::MissedMeals => "7 % of meals and snacks neither logged nor covered by a bolus",
            Self::UnloggedRescueCarbs => {
                "half of the carbohydrate taken against lows is not logged"
            }
        }
    }
}

/// The amplitude of each effect in one person; 1 is the published size, 0 is off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Amplitudes([f64; Effect::ALL.len()]);

impl Amplitudes {
    /// No effect acts.
    pub const NONE: Self = Self([0.0; Effect::ALL.len()]);

    /// Draws log-normal amplitudes with median 1 and spread 0.25 (assumed).
    #[must_use]
    pub fn sample(rng: &mut (impl Rng + ?Sized)) -> Self {
        Self(std::array::from_fn(|_| (0.25 * standard_normal(rng)).clamp(-0.6, 0.6).exp()))
    }

    /// The amplitude of one effect.
    #[must_use]
    pub fn of(&self, effect: Effect) -> f64 {
        self.0[effect as usize]
    }

    /// The same amplitudes but one.
    #[must_use]
    pub fn with(mut self, effect: Effect, amplitude: f64) -> Self {
        self.0[effect as usize] = amplitude;
        self
    }

    /// The same amplitudes with one effect switched off.
    #[must_use]
    pub fn without(self, effect: Effect) -> Self {
        self.with(effect, 0.0)
    }
}

impl Serialize for Amplitudes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(Effect::ALL.len()))?;
        for effect in Effect::ALL {
            map.serialize_entry(effect.name(), &self.of(effect))?;
        }
        map.end()
    }
}

/// A smooth step from 0 to 1 about `centre`, mostly within `centre` +- 3 `width`.
fn rise(x: f64, centre: f64, width: f64) -> f64 {
    1.0 / (1.0 + (-(x - centre) / width).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amplitudes_are_kept_by_effect() {
        for (place, effect) in Effect::ALL.into_iter().enumerate() {
            assert_eq!(effect as usize, place);
            let amplitudes = Amplitudes::NONE.with(effect, 0.7);
            assert_eq!(amplitudes.of(effect), 0.7);
            assert_eq!(amplitudes.without(effect), Amplitudes::NONE);
        }
    }
}
