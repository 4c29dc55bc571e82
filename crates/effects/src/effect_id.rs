//! Which effect is meant.

use std::fmt;

use serde::Serialize;

/// The identity of an effect: the name that files use.
///
/// An effect of your own is `EffectId::new("caffeine")`. Names are lower case with underscores; a diagnosis rejects
/// a library in which two effects share one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(transparent)]
pub struct EffectId(&'static str);

/// The identities of the library.
#[expect(missing_docs, reason = "each is said by the card of the effect; see docs/effects.md")]
impl EffectId {
    pub const ALCOHOL: Self = Self("alcohol");
    pub const CARB_MISCOUNT: Self = Self("carb_miscount");
    pub const CIRCADIAN_SENSITIVITY: Self = Self("circadian_sensitivity");
    pub const COMPRESSION_LOWS: Self = Self("compression_lows");
    pub const COUNTER_REGULATION: Self = Self("counter_regulation");
    pub const DAWN: Self = Self("dawn");
    pub const EXERCISE: Self = Self("exercise");
    pub const INSULIN_ABSORPTION: Self = Self("insulin_absorption");
    pub const MISSED_MEALS: Self = Self("missed_meals");
    pub const POST_EXERCISE_SENSITIVITY: Self = Self("post_exercise_sensitivity");
    pub const RENAL_THRESHOLD: Self = Self("renal_threshold");
    pub const SENSOR_DRIFT: Self = Self("sensor_drift");
    pub const SENSOR_LAG: Self = Self("sensor_lag");
    pub const SET_AGEING: Self = Self("set_ageing");
    pub const SET_FAILURE: Self = Self("set_failure");
    pub const SLEEP_LOSS: Self = Self("sleep_loss");
    pub const SLOW_MEALS: Self = Self("slow_meals");
    pub const UNLOGGED_RESCUE_CARBS: Self = Self("unlogged_rescue_carbs");
}

impl EffectId {
    /// The identity of an effect with this name.
    #[must_use]
    pub const fn new(name: &'static str) -> Self {
        Self(name)
    }

    /// The name that files use.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.0
    }
}

impl fmt::Display for EffectId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.0)
    }
}
